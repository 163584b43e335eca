// Markers on cloth: points as dots, edges as thick lines, faces tinted. Sizes are in CSS pixels.

import {
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  Color,
  DoubleSide,
  GreaterDepth,
  Group,
  LessEqualDepth,
  Mesh,
  MeshBasicMaterial,
  Points,
  PointsMaterial,
} from "three";
import type { MaterialParameters, Texture } from "three";
import type { Rgb } from "../shade/colours";
import { lift, lineMaterial, Lines, type Eye } from "./lines";

/** Places as x, y, z; of segments both ends, of triangles three corners. */
export interface Shapes {
  points: number[];
  segments: number[];
  triangles: number[];
}

/** How much of marks is seen behind cloth: all, or little. */
export const THROUGH = 1;
export const FAINT = 0.12;
const DOT = 14;
const RIM: Rgb = [0.08, 0.08, 0.08];
/** White, with a dark rim. */
const DISC = disc();

export class Marks {
  readonly object = new Group();
  readonly #layers: Layer[];

  constructor(colour: Rgb, width: number, behind: number) {
    const faint = { depthFunc: GreaterDepth, opacity: behind };
    const kinds = behind === THROUGH ? [{ depthTest: false }] : [faint, { depthFunc: LessEqualDepth }];
    this.#layers = kinds.map((kind) => new Layer(kind, width));
    this.object.add(...this.#layers);
    this.#layers.flatMap(({ children }) => children).forEach((child, at) => (child.renderOrder = 10 + at));
    this.setColour(colour);
  }

  setColour(colour: Rgb): void {
    for (const { own } of this.#layers) for (const { color } of own) color.setRGB(...colour);
  }

  /** `ratio` is the device pixels of a CSS pixel, as a share of those of the canvas. */
  setEye(eye: Eye, ratio: number): void {
    lift(this.object, eye, 3);
    for (const { dots } of this.#layers) dots.material.size = DOT * ratio;
  }

  set(shapes: Shapes): void {
    for (const layer of this.#layers) layer.set(shapes);
  }

  clear(): void {
    this.set({ points: [], segments: [], triangles: [] });
  }
}

/** What is before the cloth, behind it, or both. */
class Layer extends Group {
  readonly dots: Points<BufferGeometry, PointsMaterial>;
  readonly #fill: Mesh<BufferGeometry, MeshBasicMaterial>;
  // The rims of all lines are below the lines, so that the joints of short ones are not seen.
  readonly #rims: Lines;
  readonly #lines: Lines;

  constructor({ opacity = 1, ...kind }: MaterialParameters, width: number) {
    super();
    const shared = { ...kind, transparent: true, depthWrite: false };
    const fill = new MeshBasicMaterial({ ...shared, opacity: 0.38 * opacity, side: DoubleSide });
    this.#fill = new Mesh(new BufferGeometry(), fill);
    this.#rims = new Lines(lineMaterial({ ...shared, opacity: 0.55 * opacity, linewidth: width + 2.4, color: new Color(...RIM) }));
    this.#lines = new Lines(lineMaterial({ ...shared, opacity, linewidth: width }));
    this.dots = new Points(new BufferGeometry(), new PointsMaterial({ ...shared, opacity, map: DISC, sizeAttenuation: false }));
    for (const each of [this.#fill, this.dots]) each.frustumCulled = false;
    this.add(this.#fill, this.#rims, this.#lines, this.dots);
  }

  /** Materials of the colour of the marks. */
  get own(): { color: Color }[] {
    return [this.#fill.material, this.#lines.material, this.dots.material];
  }

  set({ points, segments, triangles }: Shapes): void {
    place(this.#fill, triangles);
    place(this.dots, points);
    for (const lines of [this.#rims, this.#lines]) lines.set(new Float32Array(segments));
  }
}

function place(object: Mesh | Points, places: number[]): void {
  object.geometry.dispose();
  object.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
  object.visible = places.length > 0;
}

function disc(): Texture {
  const side = 4 * DOT;
  const canvas = new OffscreenCanvas(side, side);
  const context = canvas.getContext("2d") as OffscreenCanvasRenderingContext2D;
  context.translate(side / 2, side / 2);
  for (const [radius, style] of [[26, "#141414c0"], [18.4, "#fff"]] as const) {
    context.beginPath();
    context.fillStyle = style;
    context.arc(0, 0, radius, 0, 2 * Math.PI);
    context.fill();
  }
  return new CanvasTexture(canvas);
}
