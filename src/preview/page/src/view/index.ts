// The view of the meshes: takes frames and options, draws when something changed, and tells what is under the pointer.

import { Vector3 } from "three";
import type { MeshFrame } from "../server/frame";
import type { Elements, LookInfo, Role, UpAxis } from "../server/protocol";
import type { Picked, PickHow, Side, View, ViewEvents, ViewOptions, ViewStats } from "./api";
import { poseOfAll, poseOfMarks, poseOfSets } from "./camera/aims";
import type { Sight } from "./camera/aims";
import { Cloth } from "./mesh/cloth";
import { css, setColour } from "./shade/colours";
import { Hover } from "./hover";
import { listen } from "./input";
import type { Place } from "./input";
import { columnAt, columns, sameColumns } from "./layout";
import type { Column } from "./layout";
import type { Pose } from "./camera/motion";
import { checksum } from "./mesh/points";
import { describe, onFace, Picker, toCanvas, toDevice } from "./picking";
import type { Spot } from "./picking";
import { FlatRig, SIDES, SpaceRig, THREE_QUARTER } from "./camera/rig";
import type { Rig } from "./camera/rig";
import { placeGlow, placeMarks, shapesOf } from "./mesh/shapes";
import { clearPicture, film } from "./rest/pictures";
import { Still } from "./rest/still";
import { Stage } from "./stage";
import { Uploads } from "./uploads";

/** Places around a click where cloth may be, the nearest first. [CSS pixels] */
const NEARBY = [0, 3, 6].flatMap((far) => (far === 0 ? [[0, 0]] : around(far)));

function around(far: number): number[][] {
  return [...Array(8).keys()].map((i) => [far * Math.cos((i * Math.PI) / 4), far * Math.sin((i * Math.PI) / 4)]);
}

/** Samples of a picture of a film, which are drawn while it is recorded. */
const FILMED = 4;

/** Turn of the camera for a drag. [radians / CSS pixel] */
const TURN = 0.0075;

export function createView(canvas: HTMLCanvasElement, options: ViewOptions, events: ViewEvents): View {
  return new CanvasView(canvas, options, events);
}

class CanvasView implements View {
  readonly #stage: Stage;
  readonly #picker: Picker;
  readonly #hover: Hover;
  readonly #space = new SpaceRig();
  readonly #flat = new FlatRig();
  #highlighted: ReadonlySet<string> = new Set();
  #looks: LookInfo[] = [];
  /** Edge sets under the pointer. */
  #hot: string[] = [];
  #marked: Elements | null = null;
  #selected: Elements | null = null;
  /** Rigs that the artist has not moved, which frame the garment again when the view changes. */
  readonly #untouched = new Set<Rig>([this.#space, this.#flat]);
  readonly #framed = new Set<Rig>();
  /** A frame of animation is on its way. */
  #awaited = 0;
  readonly #uploads = new Uploads();
  readonly #still: Still;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private options: ViewOptions,
    private readonly events: ViewEvents,
  ) {
    this.#stage = new Stage(canvas);
    this.#stage.setOptions(options);
    this.#picker = new Picker(this.#stage.renderer);
    this.#still = new Still(this.#stage.renderer, ({ sample: target }, sample) =>
      this.#stage.draw({ ...this.#stage.sheet(this.#columns), target }, this.#rig, this.#space, sample),
    );
    this.#hover = new Hover(this.#picker, (at) => this.#spotAt(at), events.hover, (sets) => this.#warm(sets));
    new ResizeObserver(() => this.#resized()).observe(canvas);
    canvas.addEventListener("webglcontextrestored", () => this.#invalidate());
    listen(canvas, {
      orbit: (dx, dy) => (this.options.flat ? this.#pan(dx, dy) : this.#orbit(dx, dy)),
      pan: (dx, dy) => this.#pan(dx, dy),
      zoom: (factor, at) => this.#zoom(factor, at),
      click: (at, how) => this.#click(at, how),
      rest: (at) => this.#hover.moveTo(at),
    });
    this.#invalidate();
  }

  update(frame: MeshFrame): void {
    const start = performance.now();
    const { role, replaces, revision } = frame.header;
    const known = this.#stage.cloths.get(role);
    if (replaces) this.#replace(role, frame);
    else if (known) known.update(frame);
    else return;
    this.#placeMarkers();
    this.#stage.measure(this.options.roles);
    if (!known) this.#frameUntouched();
    this.#uploads.add(role, revision, performance.now() - start);
    this.#hover.forget();
    this.#invalidate();
  }

  remove(role: Role): void {
    this.#stage.take(role);
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
    if (!sameColumns(before, options)) this.#frameUntouched();
    this.#hover.forget();
    this.#invalidate();
  }

  setUp(axis: UpAxis): void {
    this.#space.setUp(axis);
    this.#frameUntouched();
    this.#invalidate();
  }

  setLooks(looks: LookInfo[], metersPerUnit: number): void {
    this.#looks = looks;
    this.#stage.setUnit(metersPerUnit);
    for (const cloth of this.#stage.cloths.values()) cloth.setLooks(looks);
    this.#invalidate();
  }

  frame(): void {
    const part = poseOfMarks(this.#sight, this.#marked ?? this.#selected) ?? poseOfSets(this.#sight, this.#highlighted);
    if (part) this.#untouched.delete(this.#rig);
    this.#fly(part ?? poseOfAll(this.#sight));
  }

  look(side: Side): void {
    this.#untouched.delete(this.#rig);
    this.#fly(poseOfAll(this.#sight, SIDES[side]));
  }

  highlight(sets: string[]): void {
    if (sets.length === this.#highlighted.size && sets.every((name) => this.#highlighted.has(name))) return;
    this.#highlighted = new Set(sets);
    for (const cloth of this.#stage.cloths.values()) cloth.highlight(this.#highlighted);
    this.#placeMarkers();
    this.#invalidate();
  }

  mark(elements: Elements | null): void {
    this.#marked = elements;
    this.#placeMarkers();
    const pose = poseOfMarks(this.#sight, this.#marked);
    if (pose) this.#untouched.delete(this.#rig);
    this.#fly(pose);
  }

  select(elements: Elements | null): void {
    this.#selected = elements;
    this.#placeMarkers();
    this.#invalidate();
  }

  colourOf(set: string): string {
    return css(setColour(set));
  }

  screenshot(): Promise<Blob> {
    // What is new has no samples yet.
    if (this.#awaited) this.#draw();
    this.#still.finish();
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("The picture could not be encoded."))));
    });
  }

  clearPicture(width: number, height: number): Promise<Blob> {
    const ratio = height / this.#stage.height;
    const [across, up] = [width / ratio, this.#stage.height];
    const sheet = { width: across, height: up, ratio, columns: columns(this.options, across, up), isClear: true };
    return clearPicture(this.#stage.renderer, width, height, ({ sample: target }, sample) =>
      this.#stage.draw({ ...sheet, target }, this.#rig, this.#space, sample),
    );
  }

  async turntable(seconds: number): Promise<Blob> {
    const pose: Pose = [...this.#space.motion.goal];
    const turned = (share: number): void => {
      const [x, y, z, size, turn, tilt] = pose;
      this.#space.motion.jump([x, y, z, size, turn + 2 * Math.PI * share, tilt]);
      this.#draw();
      this.#still.finish(FILMED);
    };
    const blob = await film(this.canvas, seconds, turned).finally(() => this.#space.motion.jump(pose));
    this.#invalidate();
    return blob;
  }

  stats(role: Role): ViewStats | null {
    const cloth = this.#stage.cloths.get(role);
    return cloth ? { points: cloth.pointCount, faces: cloth.faceCount, checksum: checksum(cloth.points) } : null;
  }

  samples(): number {
    return this.#still.count;
  }

  project(role: Role, point: number): { x: number; y: number } | null {
    const cloth = this.#stage.cloths.get(role);
    const column = this.#columns.find(({ roles }) => roles.includes(role));
    if (!cloth || !column || point >= cloth.pointCount) return null;
    const shapes = shapesOf(cloth, { points: [point] }, this.options.flat);
    if (shapes.points.length === 0) return null;
    this.#rig.place(this.#aspect);
    const device = new Vector3().fromArray(shapes.points).project(this.#rig.camera);
    const inside = Math.max(Math.abs(device.x), Math.abs(device.y), Math.abs(device.z)) <= 1;
    return inside ? toCanvas(device, column) : null;
  }

  get #rig(): Rig {
    return this.options.flat ? this.#flat : this.#space;
  }

  get #columns(): Column[] {
    return columns(this.options, this.#stage.width, this.#stage.height);
  }

  get #aspect(): number {
    const { width, height } = this.#columns[0];
    return width / height;
  }

  /** Meshes that are drawn, with the solid one last. */
  get #shown(): Cloth[] {
    return this.options.roles.map((role) => this.#stage.cloths.get(role)).filter((cloth) => cloth !== undefined);
  }

  get #sight(): Sight {
    return {
      rig: this.#rig,
      space: this.#space,
      aspect: this.#aspect,
      flat: this.options.flat,
      shown: this.#shown,
      model: this.#stage.cloths.get("model"),
    };
  }

  #replace(role: Role, frame: MeshFrame): void {
    const cloth = new Cloth(frame, this.#stage.paintOf(role));
    cloth.setLooks(this.#looks);
    cloth.highlight(this.#highlighted);
    this.#thicken(cloth);
    this.#stage.put(role, cloth);
  }

  #invalidate(): void {
    this.#awaited ||= requestAnimationFrame((now) => this.#tick(now));
  }

  #tick(now: number): void {
    this.#awaited = 0;
    const more = this.#rig.motion.step(now);
    this.#draw();
    if (more) this.#invalidate();
    else this.#hover.look();
  }

  #draw(): void {
    this.#stage.resize();
    const start = performance.now();
    this.#stage.draw(this.#stage.sheet(this.#columns), this.#rig, this.#space);
    this.#still.restart();
    this.#uploads.tell(this.events.drawn, performance.now() - start);
  }

  /** At once, as a canvas of a new size is empty until it is drawn. */
  #resized(): void {
    if (!this.#stage.resize()) return;
    this.#frameUntouched();
    this.#draw();
  }

  #fly(pose: Pose | null): void {
    if (pose) this.#rig.motion.fly(pose);
    this.#invalidate();
  }

  #moved(move: (rig: Rig) => void): void {
    this.#untouched.delete(this.#rig);
    move(this.#rig);
    this.#hover.forget();
    this.#invalidate();
  }

  #orbit(dx: number, dy: number): void {
    this.#moved(() => this.#space.orbit(dx * TURN, dy * TURN));
  }

  #pan(dx: number, dy: number): void {
    const { height } = this.#stage;
    this.#moved((rig) => rig.pan(dx / height, dy / height, this.#aspect));
  }

  #zoom(factor: number, at: Place): void {
    const spot = this.#spotAt(at);
    const face = spot ? this.#hover.faceAt(spot) : -1;
    const column = columnAt(this.#columns, at.x) ?? this.#columns[0];
    const surface = spot && face >= 0 ? onFace(spot, face) : null;
    const about = surface ?? this.#rig.onTargetPlane(toDevice(at, column), this.#aspect);
    this.#moved((rig) => rig.zoom(factor, about));
  }

  #click(at: Place, how: PickHow): void {
    this.events.click(this.#pickedNear(at), how);
  }

  /** What is at a place, or else beside it: the outer half of a border's line is beyond the cloth. */
  #pickedNear(at: Place): Picked | null {
    for (const [dx, dy] of NEARBY) {
      const spot = this.#spotAt({ x: at.x + dx, y: at.y + dy });
      const face = spot ? this.#picker.face(spot) : -1;
      if (spot && face >= 0) return describe({ ...spot, at }, face);
    }
    return null;
  }

  /** The mesh that is picked at a place: the solid one of the column. */
  #spotAt(at: Place): Spot | null {
    const column = columnAt(this.#columns, at.x);
    const role = column?.roles.filter((name) => this.#stage.cloths.has(name)).at(-1);
    const cloth = role && this.#stage.cloths.get(role);
    const { flat } = this.options;
    if (!column || !cloth || (flat && !cloth.hasUvs)) return null;
    this.#rig.place(column.width / column.height);
    return { role, cloth, column, camera: this.#rig.camera, at, flat };
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

  #frameUntouched(): void {
    const rig = this.#rig;
    if (!this.#untouched.has(rig) && this.#framed.has(rig)) return;
    const pose = poseOfAll(this.#sight, THREE_QUARTER);
    if (!pose) return;
    rig.motion.jump(pose);
    this.#framed.add(rig);
  }

  #placeMarkers(): void {
    const { marks, glow, selection, cloths } = this.#stage;
    placeMarks(selection, cloths.get("model"), this.#selected, this.options.flat);
    placeMarks(marks, cloths.get("model"), this.#marked, this.options.flat);
    placeGlow(glow, this.#shown, this.#highlighted, this.options.flat);
  }
}
