// Draws the meshes into their columns.

import { Box3, Camera, Group, LinearSRGBColorSpace, Sphere, Vector3, WebGLRenderer } from "three";
import type { IUniform, WebGLRenderTarget } from "three";
import type { LookInfo, Role } from "../server/protocol";
import type { Fabric, Shading, ViewOptions } from "./api";
import { Backdrop } from "./shade/backdrop";
import type { Cloth } from "./mesh/cloth";
import { ACCENT } from "./shade/colours";
import { squareOf } from "./shade/checker";
import { Chosen } from "./shade/fabric";
import { aspectOf, ROLES, windowOf } from "./layout";
import type { Column } from "./layout";
import { Images } from "./shade/images";
import { setView } from "./mesh/lines";
import type { Eye } from "./mesh/lines";
import { MarkerSet } from "./mesh/markerSet";
import { Paint } from "./shade/paint";
import type { Codes } from "./shade/paint";
import type { Cameras } from "./camera/cameras";
import type { SpaceRig } from "./camera/rig";
import { isSoftware } from "./shade/software";
import type { Sample } from "./rest/samples";
import { Shadows } from "./rest/shadows";

const SHADINGS: Record<Shading, number> = { cloth: 0, faceSets: 1, checker: 2, values: 3 };

/** Part of the garment's radius within which hollows darken. */
const CAVITY = 0.02;
/** Part of the radius by which wires over another mesh are nearer, so that they are seen where they lie just inside. */
const BIAS = 0.0055;
const MOST_RATIO = 2;
/** Part of the pixels across and up that a draft has. */
const DRAFT_RATIO = 0.5;

/** What is drawn on. */
export interface Sheet {
  /** Null for the canvas. */
  target: WebGLRenderTarget | null;
  /** [CSS pixels] */
  width: number;
  height: number;
  /** Device pixels of one CSS pixel. */
  ratio: number;
  columns: Column[];
  /** Without the ground and what is behind it. */
  isClear?: boolean;
}

export class Stage {
  readonly renderer: WebGLRenderer;
  readonly cloths = new Map<Role, Cloth>();
  /** The body under the garment. It is neither picked nor marked. */
  body: Cloth | null = null;
  /** Meshes that a split view compares with. */
  readonly kept = new Map<Role, Cloth>();
  readonly images = new Images();
  readonly inSpace = new MarkerSet();
  readonly onPlane = new MarkerSet();
  readonly uniforms = {
    uFlat: { value: false },
    uWires: { value: false },
    uEdgeSets: { value: false },
    uShading: { value: 0 },
    uPixel: { value: 1 },
    uSize: { value: 1 },
    uBias: { value: 0 },
    uUp: { value: new Vector3(0, 1, 0) },
    uAccent: { value: new Vector3(...ACCENT) },
  } satisfies Record<string, IUniform>;
  width = 1;
  height = 1;
  isDraft = false;
  readonly centre = new Vector3();
  radius = 1;
  /** Edge of a square of the checker, or 0 if the scale of the UVs is not known. [m] */
  square = 0;
  readonly #paints = new Map<string, Paint>();
  readonly #world = new Group();
  readonly #backdrop = new Backdrop();
  /** Sees the whole canvas. */
  readonly #whole = new Camera();
  readonly #half = new Vector3(1, 1, 1);
  readonly #shadows: Shadows;
  #hasShadows = false;
  #hasBody = true;
  /** A pixel of the canvas has one sample. */
  readonly #isHard: boolean;
  #metersPerUnit = 0.01;
  #fabric: Fabric | null = null;
  readonly #chosen = new Chosen();

  /** `changed` is called when an image has arrived. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly changed: () => void,
  ) {
    // Several samples a pixel take more than twice the time without a graphics card, and the picture at rest has them anyway.
    this.#isHard = isSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.#isHard, alpha: false, powerPreference: "high-performance" });
    this.renderer.autoClear = false;
    // All colours are those of the screen, and cloth encodes its own.
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.#shadows = new Shadows(this.renderer);
    const { ground, square } = this.#backdrop;
    this.#world.add(ground, square, ...[this.inSpace, this.onPlane].flatMap(({ all }) => all.map(({ object }) => object)));
    this.resize();
  }

  paintOf(role: Role, isKept = false): Paint {
    const key = `${role} ${isKept}`;
    const shared = { ...this.uniforms, ...this.#chosen.uniforms, ...this.#shadows.uniforms, uImages: this.images.uniform };
    const paint = this.#paints.get(key) ?? new Paint(role, shared);
    paint.setCodes(this.#codes);
    this.#paints.set(key, paint);
    return paint;
  }

  /** Takes the size of the canvas on the page. A moving picture is a draft of fewer pixels where the processor draws them.
   *  Returns whether the size is another. */
  resize(isMoving = false): boolean {
    const { clientWidth, clientHeight } = this.canvas;
    this.isDraft = isMoving && this.#isHard;
    const ratio = Math.min(MOST_RATIO, devicePixelRatio) * (this.isDraft ? DRAFT_RATIO : 1);
    const same = clientWidth === this.width && clientHeight === this.height && ratio === this.renderer.getPixelRatio();
    if (same || clientWidth === 0 || clientHeight === 0) return false;
    this.width = clientWidth;
    this.height = clientHeight;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(clientWidth, clientHeight, false);
    return true;
  }

  put(role: Role, cloth: Cloth, among = this.cloths): void {
    this.take(role, among);
    among.set(role, cloth);
    this.#world.add(cloth.object);
  }

  take(role: Role, among = this.cloths): void {
    const cloth = among.get(role);
    if (!cloth) return;
    this.#world.remove(cloth.object);
    cloth.dispose();
    among.delete(role);
  }

  setBody(body: Cloth | null): void {
    if (this.body) {
      this.#world.remove(this.body.object);
      this.body.dispose();
    }
    this.body = body;
    if (body) this.#world.add(body.object);
  }

  /** Those of now, and those that were kept. */
  get all(): Cloth[] {
    return [...this.cloths.values(), ...this.kept.values()];
  }

  setOptions(options: ViewOptions): void {
    this.uniforms.uWires.value = options.wires;
    this.uniforms.uEdgeSets.value = options.edgeSets;
    this.uniforms.uShading.value = SHADINGS[options.shading];
    this.#setFabric(options.fabric);
    this.#hasShadows = options.shadows;
    this.#hasBody = options.body;
    this.#backdrop.setTheme(options.theme);
  }

  get #codes(): Codes {
    return { ...this.#chosen.codes, IMAGES: this.images.layers.length > 0 };
  }

  #recode(): void {
    for (const paint of this.#paints.values()) paint.setCodes(this.#codes);
    this.changed();
  }

  /** Takes the looks of the model's materials; those with images once more when these are there. */
  setLooks(looks: LookInfo[]): void {
    this.#dress(looks);
    void this.images.load(looks).then((isNew) => {
      if (!isNew) return;
      this.#dress(looks);
      this.#recode();
    });
  }

  #dress(looks: LookInfo[]): void {
    for (const cloth of this.all) cloth.setLooks(looks, this.images.layers);
  }

  setUnit(metersPerUnit: number): void {
    this.#metersPerUnit = metersPerUnit;
    if (this.#fabric) this.#setFabric(this.#fabric);
  }

  #setFabric(fabric: Fabric): void {
    this.#fabric = fabric;
    this.#chosen.set(fabric, this.#metersPerUnit, () => this.#fabric && this.#setFabric(this.#fabric));
    this.#recode();
  }

  /** Takes the bounds of these meshes, and the size of their checker. */
  measure(roles: Role[]): void {
    this.#setSquares();
    const all = new Box3();
    for (const role of roles) all.union(this.cloths.get(role)?.box ?? all);
    if (all.isEmpty()) return;
    all.getCenter(this.centre);
    all.getSize(this.#half).multiplyScalar(0.5);
    this.radius = Math.max(this.#half.length(), 1e-6);
    this.uniforms.uSize.value = CAVITY * this.radius;
    this.uniforms.uBias.value = BIAS * this.radius;
  }

  /** One length for all meshes, so that they compare: by the first that has UVs. */
  #setSquares(): void {
    const first = this.#withUvs;
    const length = first ? first.uvLength * first.uvRange * this.#metersPerUnit : 0;
    this.square = length > 0 ? squareOf(length) : 0;
    for (const cloth of this.all) cloth.setSquare(this.square / this.#metersPerUnit);
  }

  get #withUvs(): Cloth | undefined {
    return ROLES.map((role) => this.cloths.get(role)).find((cloth) => cloth?.hasUvs);
  }

  /** A mesh that was not shown when others were kept is as it is now. */
  clothsOf({ split }: Column): Map<Role, Cloth> {
    return split?.isKept ? new Map([...this.cloths, ...this.kept]) : this.cloths;
  }

  markersOf(flat: boolean): MarkerSet {
    return flat ? this.onPlane : this.inSpace;
  }

  /** The canvas with these columns. */
  sheet(columns: Column[]): Sheet {
    const { width, height } = this;
    return { target: null, width, height, ratio: this.renderer.getPixelRatio(), columns };
  }

  /** Draws a plain picture, or a sample of the picture at rest. */
  draw(sheet: Sheet, cameras: Cameras, sample: Sample | null = null): void {
    for (const _ of this.parts(sheet, cameras, sample));
  }

  /** The same in parts. What lies under the pointer may be looked for between them. */
  *parts(sheet: Sheet, cameras: Cameras, sample: Sample | null): Generator<void> {
    const { renderer } = this;
    this.#backdrop.setGround(this.centre, this.#half, cameras.space.up);
    this.uniforms.uPixel.value = sheet.ratio;
    this.#open(sheet, { x: 0, y: 0, width: sheet.width, height: sheet.height, roles: [], flat: false });
    renderer.setClearColor(0, 0);
    renderer.clear();
    if (!sheet.isClear) renderer.render(this.#backdrop.sky, this.#whole);
    for (const column of sheet.columns) {
      const caster = sample && this.#hasShadows && !column.flat ? this.solidOf(column) : null;
      if (caster) yield* this.#cast(caster, column, cameras.space, sample as Sample);
      this.#drawColumn(sheet, column, cameras, sample, caster !== null);
      renderer.setScissorTest(false);
      renderer.setRenderTarget(null);
      if (caster) yield;
    }
  }

  /** What follows is drawn to a part of the sheet. */
  #open(sheet: Sheet, column: Column): void {
    const { renderer } = this;
    const { target, ratio } = sheet;
    const { x, y, width, height } = column;
    const seen = windowOf(column);
    const low = sheet.height - y - height;
    if (target) {
      target.viewport.set(x * ratio, low * ratio, width * ratio, height * ratio).round();
      target.scissor.set(seen.x * ratio, low * ratio, seen.width * ratio, height * ratio).round();
      target.scissorTest = true;
    }
    renderer.setRenderTarget(target);
    if (target) return;
    renderer.setScissorTest(true);
    renderer.setViewport(x, low, width, height);
    renderer.setScissor(seen.x, low, seen.width, height);
  }

  #drawColumn(sheet: Sheet, column: Column, cameras: Cameras, sample: Sample | null, hasShadows: boolean): void {
    const { width, height, flat } = column;
    const { ratio } = sheet;
    const { space } = cameras;
    const rig = cameras.of(flat);
    this.uniforms.uFlat.value = flat;
    this.#backdrop.ground.visible = !flat && !sheet.isClear;
    this.#backdrop.square.visible = flat && !sheet.isClear;
    rig.setBounds(this.centre, this.radius);
    rig.place(width / height);
    this.uniforms.uUp.value.copy(space.up).transformDirection(rig.camera.matrixWorldInverse);
    const eye = { camera: rig.camera, width, height };
    setView(eye);
    this.#show(column, eye, hasShadows);
    for (const marks of this.markersOf(flat).all) marks.setEye(eye, ratio / this.renderer.getPixelRatio());
    if (sample) rig.camera.setViewOffset(width, height, sample.jitter[0] / ratio, sample.jitter[1] / ratio, width, height);
    this.#open(sheet, column);
    this.renderer.render(this.#world, rig.camera);
    rig.camera.clearViewOffset();
  }

  /** The last mesh of a column, which is solid; null while it is not there. */
  solidOf(column: Column): Cloth | null {
    const cloths = this.clothsOf(column);
    return column.roles.map((role) => cloths.get(role)).filter((cloth) => cloth !== undefined).at(-1) ?? null;
  }

  *#cast(cloth: Cloth, column: Column, space: SpaceRig, sample: Sample): Generator<void> {
    const all = new Sphere(this.centre, this.radius);
    space.setBounds(this.centre, this.radius);
    space.place(aspectOf(column));
    yield* this.#shadows.cast(cloth, sample, space.camera, all, space.inView());
  }

  /** The last mesh is solid; those before it lie over it as wires. */
  #show(column: Column, eye: Eye, hasShadows: boolean): void {
    const { flat } = column;
    const cloths = this.clothsOf(column);
    const drawn = column.roles.filter((role) => cloths.has(role));
    for (const cloth of this.all) cloth.object.visible = false;
    for (const [role, cloth] of cloths) {
      const order = drawn.indexOf(role);
      const last = order === drawn.length - 1;
      cloth.object.visible = order >= 0 && (!flat || cloth.hasUvs);
      cloth.solid.material = last ? (hasShadows ? cloth.paint.shaded : cloth.paint.solid) : cloth.paint.overlay;
      cloth.solid.renderOrder = last ? 0 : 1 + order;
      const over = last ? 0 : this.uniforms.uBias.value / eye.camera.position.distanceTo(this.centre);
      // The lines of the mesh above say more, and two of one colour would be mistaken for one another.
      cloth.lines.object.visible = !last || drawn.length < 2;
      const hasLines = cloth.lines.show(eye, { flat, hasSets: this.uniforms.uEdgeSets.value, over });
      // Lines are seen where the surface beside them rises towards the eye.
      cloth.solid.material.polygonOffset = hasLines && cloth.lines.object.visible;
    }
    if (this.body) {
      this.body.object.visible = this.#hasBody && !flat;
      this.body.lines.object.visible = false;
    }
    this.markersOf(!flat).show(null);
    this.markersOf(flat).show(drawn);
  }
}
