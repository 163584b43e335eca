// The view of the meshes: takes frames and options, draws when something changed, and tells what is under the pointer.

import { Vector3 } from "three";
import type { MeshFrame } from "../server/frame";
import type { UpAxis } from "../server/options";
import type { Elements, LookInfo, Role } from "../server/protocol";
import type { Brush, Isolated, Marked, Outline, Picked, PickHow, Side, View, ViewEvents, ViewOptions, ViewStats } from "./api";
import { Cloth } from "./mesh/cloth";
import type { Content } from "./mesh/cloth";
import { contentOf } from "./mesh/copy";
import type { Cameras } from "./camera/cameras";
import { Director } from "./director";
import { css, placeSets, setColour, sortSets } from "./shade/colours";
import { Hover } from "./hover";
import { listen } from "./input";
import type { Place } from "./input";
import { blended, dab } from "./brush";
import type { Stroke } from "./brush";
import { Gripper } from "./grip";
import type { Sight } from "./grip";
import { aspectOf, columnAt, columns, largeOf, ROLES, sameColumns, splitAt } from "./layout";
import type { Column } from "./layout";
import type { Pose } from "./camera/motion";
import { checksum } from "./mesh/points";
import { outlineOf } from "./outline";
import { describe, onFace, Picker, toCanvas, toDevice } from "./picking";
import type { Spot } from "./picking";
import type { Rig } from "./camera/rig";
import { Planner } from "./plan";
import { Markers } from "./markers";
import type { Paint } from "./shade/paint";
import { clearPicture, film } from "./rest/pictures";
import { Still } from "./rest/still";
import type { Draw } from "./rest/still";
import { elementsOfSet, shapesOf } from "./mesh/shapes";
import { sourceOf } from "./mesh/sources";
import { CUTS, facesAt, panelsOf } from "./mesh/panels";
import { histogram, worstFace } from "./mesh/values";
import { Stage } from "./stage";
import { Uploads } from "./uploads";

/** Samples of a picture of a film, which are drawn while it is recorded. */
const FILMED = 4;
/** A body as clay. */
const CLAY: LookInfo[] = [{ set: "", colour: [0.52, 0.4, 0.33], texture: null, roughness: 0.8 }];

/** Turn of the camera for a drag. [radians / CSS pixel] */
const TURN = 0.0075;

export function createView(canvas: HTMLCanvasElement, options: ViewOptions, events: ViewEvents): View {
  return new CanvasView(canvas, options, events);
}

class CanvasView implements View {
  readonly #stage: Stage;
  readonly #picker: Picker;
  readonly #hover: Hover;
  readonly #director: Director;
  #looks: LookInfo[] = [];
  /** Points of the model, without those of its refinement for display. */
  #points = 0;
  #hovered: Picked | null = null;
  readonly #markers: Markers;
  /** Edge sets under the pointer. */
  #hot: string[] = [];
  /** Faces of the model that alone are shown. */
  #isolated: ReadonlySet<number> | null = null;
  /** Marks are to be flown to once their mesh is there. */
  #fliesToMarks = false;
  /** Where the line of a split view is, as a part of each column; null without one. */
  #split: number | null = null;
  /** A frame of animation is on its way. */
  #awaited = 0;
  readonly #uploads = new Uploads();
  readonly #still: Still;
  readonly #planner = new Planner();
  readonly #gripper: Gripper;
  #brush: Brush | null = null;
  #stroke: Stroke = "paint";

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private options: ViewOptions,
    private readonly events: ViewEvents,
  ) {
    this.#stage = new Stage(canvas, () => this.#invalidate());
    this.#stage.setOptions(options);
    this.#markers = new Markers(this.#stage);
    this.#director = new Director(this.#stage, () => this.#columns, () => this.#shown);
    this.#picker = new Picker(this.#stage.renderer);
    this.#gripper = new Gripper(this.#picker, (at) => this.#spotAt(at));
    const parts: Draw = ({ sample: target }, sample) =>
      this.#stage.parts({ ...this.#stage.sheet(this.#columns), target }, this.#cameras, sample);
    this.#still = new Still(this.#stage.renderer, parts, () => this.#drawPlain(false), (is) => this.events.final(is));
    const hover = (picked: Picked | null): void => this.#hovers(picked);
    this.#hover = new Hover(this.#picker, (at) => this.#spotAt(at), hover, (sets) => this.#warm(sets));
    new ResizeObserver(() => this.#resized()).observe(canvas);
    canvas.addEventListener("webglcontextrestored", () => this.#invalidate());
    listen(canvas, {
      begin: (at, event) => this.#begin(at, event),
      stroke: (at) => void this.#dab(at),
      end: () => this.#brush && this.events.painted(this.#brush.weights),
      orbit: (dx, dy, from) => (this.#columnAt(from).flat ? this.#pan(dx, dy, from) : this.#orbit(dx, dy)),
      pan: (dx, dy, from) => this.#pan(dx, dy, from),
      zoom: (factor, at) => this.#zoom(factor, at),
      click: (at, how) => this.#click(at, how),
      rest: (at) => this.#hover.moveTo(at),
    });
    this.#invalidate();
  }

  update(frame: MeshFrame): void {
    const start = performance.now();
    const { role, replaces, revision } = frame.header;
    if (role === "body") return this.#updateBody(frame, start);
    const known = this.#stage.cloths.get(role);
    if (replaces) this.#replace(role, frame);
    else if (known) known.update(frame);
    else return;
    this.#stage.kept.get(role)?.takeUvs(frame);
    this.#placeMarkers();
    this.#stage.measure(this.options.roles);
    if (!known) this.#director.fit();
    if (this.#fliesToMarks) this.#flyToMarks();
    this.#uploads.add(role, revision, performance.now() - start);
    this.#hover.forget();
    this.#invalidate();
  }

  hasBody(): boolean {
    return this.#stage.body !== null && this.options.body;
  }

  #updateBody(frame: MeshFrame, start: number): void {
    const { body } = this.#stage;
    if (body && !frame.header.replaces) body.update(frame);
    else {
      const cloth = new Cloth(frame, this.#stage.paintOf("body"));
      cloth.setLooks(CLAY, []);
      this.#stage.setBody(cloth);
    }
    this.#uploads.add("body", frame.header.revision, performance.now() - start);
    this.#invalidate();
  }

  remove(role: Role): void {
    if (role === "body") this.#stage.setBody(null);
    else this.#stage.take(role);
    this.#uploads.forget(role);
    this.#placeMarkers();
    this.#hover.forget();
    this.#invalidate();
  }

  setOptions(options: ViewOptions): void {
    const before = this.options;
    this.options = options;
    this.#stage.setOptions(options);
    this.#stage.measure(options.roles);
    this.#placeMarkers();
    if (!sameColumns(before, options)) this.#director.fit();
    this.#hover.forget();
    this.#invalidate();
  }

  setUp(axis: UpAxis): void {
    this.#cameras.space.setUp(axis);
    this.#director.begin();
    this.#invalidate();
  }

  setGarment({ looks, sets, points, metersPerUnit }: Parameters<View["setGarment"]>[0]): void {
    this.#looks = looks ?? [];
    this.#points = points;
    placeSets([...sets, { name: CUTS, kind: "edge" }]);
    this.#stage.setUnit(metersPerUnit);
    this.#stage.setLooks(this.#looks);
    for (const cloth of this.#stage.all) cloth.recolour();
    this.#invalidate();
  }

  frame(): void {
    const { onMarked, selected, highlighted } = this.#markers;
    const part = onMarked ?? (selected && { role: "model" as const, elements: selected });
    this.#director.frame(part, highlighted);
    this.#invalidate();
  }

  look(side: Side): void {
    this.#director.look(side);
    this.#invalidate();
  }

  highlight(sets: string[]): void {
    const { highlighted } = this.#markers;
    if (sets.length === highlighted.size && sets.every((name) => highlighted.has(name))) return;
    this.#markers.highlighted = new Set(sets);
    for (const cloth of this.#stage.all) cloth.highlight(this.#markers.highlighted);
    this.#placeMarkers();
    this.#invalidate();
  }

  mark(marked: Marked | null, flies = true): void {
    this.#markers.marked = marked;
    this.#markers.placeAt = 0;
    this.#fliesToMarks = marked !== null && flies;
    this.#placeMarkers();
    if (this.#fliesToMarks) this.#flyToMarks();
    this.#invalidate();
  }

  placeCount(): number {
    return this.#markers.places.length;
  }

  flyToPlace(at: number): void {
    this.#markers.placeAt = at;
    this.#fliesToMarks = true;
    this.#flyToMarks();
    this.#invalidate();
  }

  select(elements: Elements | null): void {
    this.#markers.selected = elements;
    this.#placeMarkers();
    this.#invalidate();
  }

  grip(elements: Elements | null): void {
    this.#gripper.set(elements);
    this.#invalidate();
  }

  brush(brush: Brush | null): void {
    this.#brush = brush;
    for (const cloth of this.#stage.all) cloth.showValues(null);
    this.#showWeights();
  }

  weightsOf(name: string): Float32Array<ArrayBuffer> | null {
    const values = this.#stage.cloths.get("model")?.values;
    return values?.name === name && values.of === "point" ? values.numbers.slice() : null;
  }

  blended(elements: Elements | null): Float32Array<ArrayBuffer> | null {
    const model = this.#stage.cloths.get("model");
    return model ? blended(model, elements) : null;
  }

  #showWeights(): void {
    const numbers = this.#brush?.weights;
    if (numbers) this.#stage.cloths.get("model")?.showValues({ name: "", of: "point", least: 0, most: 1, numbers });
    this.#invalidate();
  }

  #begin(at: Place, { altKey, shiftKey }: PointerEvent): boolean {
    this.#stroke = shiftKey ? "smooth" : altKey ? "erase" : "paint";
    return this.#dab(at);
  }

  /** Paints where the pointer is on cloth. */
  #dab(at: Place): boolean {
    const spot = this.#brush && this.#spotAt(at);
    const face = spot ? this.#picker.look(spot).face : -1;
    const place = spot && face >= 0 ? onFace(spot, face) : null;
    if (!this.#brush || !spot || !place || spot.flat) return false;
    dab(spot.model, sourceOf(spot.cloth, face), place, this.#brush, this.#stroke);
    this.#showWeights();
    return true;
  }

  reveal(what: Elements | string): void {
    const model = this.#stage.cloths.get("model");
    const elements = typeof what !== "string" ? what : model ? elementsOfSet(model, what) : null;
    if (elements) this.#director.reveal({ role: "model", elements });
    this.#invalidate();
  }

  isolate(what: Isolated | null): boolean {
    const faces = what === null ? null : this.#facesOf(what);
    this.#isolated = faces && faces.size > 0 ? faces : null;
    for (const cloth of this.#stage.all) cloth.isolate(this.#isolated);
    this.#placeMarkers();
    this.#hover.forget();
    this.#invalidate();
    return this.#isolated !== null;
  }

  /** Faces of the model. */
  #facesOf(what: Isolated): Set<number> | null {
    const model = this.#stage.cloths.get("model");
    if (!model) return null;
    if (typeof what === "string") return new Set(elementsOfSet(model, what)?.faces);
    if ("face" in what) return panelsOf(model, new Set([what.face]));
    return "faces" in what ? new Set(what.faces) : panelsOf(model, facesAt(model, what));
  }

  split(share: number | null): void {
    const { cloths, kept } = this.#stage;
    if (share === null) for (const role of ROLES) this.#stage.take(role, kept);
    else if (this.#split === null) {
      for (const [role, cloth] of cloths) {
        this.#stage.put(role, this.#cloth(contentOf(cloth), this.#stage.paintOf(role, true)), kept);
      }
      this.#stage.measure(this.options.roles);
    }
    this.#split = share;
    this.#hover.forget();
    this.#invalidate();
  }

  colourOf(set: string): string {
    return css(setColour(set));
  }

  edgeSets(): string[] {
    const names = new Set(this.#shown.flatMap((cloth) => cloth.drawnEdgeSets()));
    return sortSets([...names].map((name) => ({ name, kind: "edge" as const }))).map(({ name }) => name);
  }

  screenshot(): Promise<Blob> {
    // A picture that has just changed has no samples yet, and a draft has too few pixels.
    if (this.#awaited || this.#stage.isDraft) this.#draw(false);
    this.#still.finish();
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("The picture could not be encoded."))));
    });
  }

  clearPicture(width: number, height: number): Promise<Blob> {
    const ratio = height / this.#stage.height;
    const [across, up] = [width / ratio, this.#stage.height];
    const sheet = { width: across, height: up, ratio, columns: this.#columnsOf(across, up), isClear: true };
    return clearPicture(this.#stage.renderer, width, height, ({ sample: target }, sample) =>
      this.#stage.parts({ ...sheet, target }, this.#cameras, sample),
    );
  }

  async turntable(seconds: number): Promise<Blob> {
    const pose: Pose = [...this.#cameras.space.motion.goal];
    const turned = (share: number): void => {
      const [x, y, z, size, turn, tilt] = pose;
      this.#cameras.space.motion.jump([x, y, z, size, turn + 2 * Math.PI * share, tilt]);
      this.#draw(false);
      this.#still.finish(FILMED);
    };
    const blob = await film(this.canvas, seconds, turned).finally(() => this.#cameras.space.motion.jump(pose));
    this.#invalidate();
    return blob;
  }

  square(): number {
    return this.#stage.square;
  }

  histogram(parts: number): number[] | null {
    const values = this.#valued?.values;
    return values ? histogram(values, parts) : null;
  }

  flyToWorst(): boolean {
    const cloth = this.#valued;
    const face = cloth ? worstFace(cloth) : -1;
    if (!cloth || face < 0) return false;
    const role = this.options.roles.find((each) => this.#stage.cloths.get(each) === cloth) ?? "sim";
    this.#director.flyTo({ role, elements: { faces: [face] } });
    this.#invalidate();
    return true;
  }

  stats(role: Role): ViewStats | null {
    const cloth = this.#stage.cloths.get(role);
    if (!cloth) return null;
    const { pointCount, faceCount, box } = cloth;
    return { points: pointCount, faces: faceCount, checksum: checksum(cloth.points), least: box.min.toArray() };
  }

  samples(): number {
    return this.#still.count;
  }

  aim(): ReturnType<View["aim"]> {
    const { goal } = this.#cameras.space.motion;
    const direction = this.#cameras.space.backOf(goal).negate().toArray();
    return { target: goal.slice(0, 3), direction, distance: Math.exp(goal[3]) };
  }

  project(role: Role, point: number, flat = this.options.flat): { x: number; y: number } | null {
    const cloth = this.#stage.cloths.get(role);
    const column = this.#columns.find((each) => !each.split?.isKept && each.flat === flat && each.roles.includes(role));
    if (!cloth || !column || point >= cloth.pointCount) return null;
    const shapes = shapesOf(cloth, { points: [point] }, flat);
    if (shapes.points.length === 0) return null;
    const rig = this.#cameras.of(flat);
    rig.place(aspectOf(column));
    const device = new Vector3().fromArray(shapes.points).project(rig.camera);
    const inside = Math.max(Math.abs(device.x), Math.abs(device.y), Math.abs(device.z)) <= 1;
    return inside ? toCanvas(device, column) : null;
  }

  get #cameras(): Cameras {
    return this.#director.cameras;
  }

  get #columns(): Column[] {
    return this.#columnsOf(this.#stage.width, this.#stage.height);
  }

  #columnsOf(width: number, height: number): Column[] {
    const all = columns(this.options, width, height);
    return this.#split === null ? all : splitAt(all, this.#split);
  }

  /** The column at a place, or else the first one. */
  #columnAt(at: Place): Column {
    const all = this.#columns;
    return columnAt(all, at) ?? all[0];
  }

  /** Meshes that are drawn, with the solid one last. */
  get #shown(): Cloth[] {
    return this.options.roles.map((role) => this.#stage.cloths.get(role)).filter((cloth) => cloth !== undefined);
  }

  /** The mesh that heat is of: the large one, if it has values. */
  get #valued(): Cloth | undefined {
    const { roles } = this.options;
    const ordered = [largeOf(this.options), ...roles].map((role) => this.#stage.cloths.get(role));
    return ordered.find((cloth) => cloth?.values);
  }

  #replace(role: Role, frame: MeshFrame): void {
    const cloth = this.#cloth(frame, this.#stage.paintOf(role));
    this.#thicken(cloth);
    this.#stage.put(role, cloth);
  }

  #cloth(content: Content, paint: Paint): Cloth {
    const cloth = new Cloth(content, paint);
    cloth.setLooks(this.#looks, this.#stage.images.layers);
    cloth.highlight(this.#markers.highlighted);
    cloth.isolate(this.#isolated);
    return cloth;
  }

  #invalidate(): void {
    this.#awaited ||= requestAnimationFrame((now) => this.#tick(now));
  }

  #tick(now: number): void {
    this.#awaited = 0;
    const more = this.#cameras.step(now);
    this.#draw();
    if (more) return this.#invalidate();
    this.#hover.look();
    this.#settle();
  }

  #drawPlain(isMoving: boolean): void {
    this.#stage.resize(isMoving);
    this.#stage.draw(this.#stage.sheet(this.#columns), this.#cameras);
  }

  /** A moving picture may be a draft. */
  #draw(isMoving = true): void {
    const start = performance.now();
    this.#drawPlain(isMoving);
    this.#still.restart(this.#stage.isDraft);
    this.#plan();
    this.events.grip(this.#gripper.seen(this.#renderSight));
    if (this.#hovered) this.#hovers(this.#hovered);
    this.#uploads.tell(this.events.drawn, performance.now() - start);
  }

  #plan(): void {
    const { cloths } = this.#stage;
    const solid = ({ roles }: Column) => roles.map((role) => cloths.get(role)).filter((cloth) => cloth !== undefined).at(-1);
    const columns = this.#columns.filter(({ flat, split }) => flat && !split?.isKept);
    this.events.plan(this.#planner.plan(cloths.get("model"), columns, solid, this.#cameras.flat));
  }

  #settle(near: Place | null = null): void {
    const sight = this.#renderSight;
    if (this.#gripper.settle(sight, near)) this.events.grip(this.#gripper.seen(sight));
  }

  /** The render mesh in space, where it is solid. */
  get #renderSight(): Sight | null {
    const [model, cloth] = [this.#stage.cloths.get("model"), this.#stage.cloths.get("render")];
    const column = this.#columns.find(({ flat, roles, split }) => !flat && !split?.isKept && roles.at(-1) === "render");
    if (!model || !cloth || !column) return null;
    const rig = this.#cameras.space;
    rig.place(aspectOf(column));
    return { model, cloth, column, camera: rig.camera };
  }

  /** At once, as a canvas of a new size is empty until it is drawn. */
  #resized(): void {
    if (!this.#stage.resize()) return;
    this.#director.begin();
    this.#draw();
  }

  #flyToMarks(): void {
    const { onPlace } = this.#markers;
    if (!onPlace || !this.options.roles.includes(onPlace.role)) return;
    this.#fliesToMarks = false;
    this.#director.flyTo(onPlace);
  }

  #moved<Moved extends Rig>(rig: Moved, move: (rig: Moved) => void): void {
    this.#cameras.touch(rig);
    move(rig);
    this.#hover.forget();
    this.#invalidate();
  }

  #orbit(dx: number, dy: number): void {
    this.#moved(this.#cameras.space, (rig) => rig.orbit(dx * TURN, dy * TURN));
  }

  #pan(dx: number, dy: number, from: Place): void {
    const column = this.#columnAt(from);
    this.#moved(this.#cameras.of(column.flat), (rig) => rig.pan(dx / column.height, dy / column.height, aspectOf(column)));
  }

  #zoom(factor: number, at: Place): void {
    const spot = this.#spotAt(at);
    const face = spot ? this.#hover.seenAt(spot).face : -1;
    const column = this.#columnAt(at);
    const surface = spot && face >= 0 ? onFace(spot, face) : null;
    const rig = this.#cameras.of(column.flat);
    const about = surface ?? rig.onTargetPlane(toDevice(at, column), aspectOf(column));
    this.#moved(rig, () => rig.zoom(factor, about));
  }

  #click(at: Place, how: PickHow): void {
    this.events.click(this.#pickedNear(at), how);
  }

  /** What is at a place, or else beside it: the outer half of a border's line is beyond the cloth. */
  #pickedNear(at: Place): Picked | null {
    const spot = this.#spotAt(at);
    return spot && describe(spot, this.#picker.look(spot));
  }

  /** The mesh that is picked at a place: the solid one of the column. */
  #spotAt(at: Place): Spot | null {
    const column = columnAt(this.#columns, at);
    const cloths = column && this.#stage.clothsOf(column);
    const role = column?.roles.filter((name) => cloths?.has(name)).at(-1);
    const cloth = role && cloths?.get(role);
    const model = cloths?.get("model");
    if (!column || !cloth || !model || (column.flat && !cloth.hasUvs)) return null;
    const { flat } = column;
    const rig = this.#cameras.of(flat);
    rig.place(aspectOf(column));
    this.#stage.uniforms.uFlat.value = flat;
    return { role, cloth, model, points: this.#points, column, camera: rig.camera, at, flat };
  }

  #hovers(picked: Picked | null): void {
    const isNew = picked && (picked.x !== this.#hovered?.x || picked.y !== this.#hovered.y);
    this.#hovered = picked;
    if (isNew && picked.role === "render" && picked.edge && this.#gripper.has(picked.edge)) this.#settle(picked);
    this.events.hover(picked, picked ? this.#columns.flatMap((column) => this.#outlineIn(column, picked)) : []);
  }

  /** What a click on it takes, where it is drawn. */
  #outlineIn(column: Column, { face, edge }: Picked): Outline[] {
    const [model, cloth] = [this.#stage.cloths.get("model"), this.#stage.solidOf(column)];
    if (!model || !cloth || column.split?.isKept) return [];
    const elements = this.#markers.carried(model, cloth, edge ? { edges: [edge] } : { faces: [face] });
    const rig = this.#cameras.of(column.flat);
    rig.place(aspectOf(column));
    return [outlineOf(column, rig.camera, shapesOf(cloth, elements, column.flat))];
  }

  /** Thickens the edge set under the pointer. */
  #warm(sets: string[]): void {
    this.#hot = sets;
    for (const cloth of this.#stage.cloths.values()) this.#thicken(cloth);
    this.#invalidate();
  }

  #thicken(cloth: Cloth): void {
    cloth.setHot(this.options.edgeSets ? this.#hot : []);
  }

  #placeMarkers(): void {
    this.#markers.place(this.options.roles, this.#director.ways);
  }
}
