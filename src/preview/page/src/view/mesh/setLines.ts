// The edge sets of a mesh as lines, in space and on the UV plane.

import { Color, Group } from "three";
import { ACCENT, setColour } from "../shade/colours";
import type { Rgb } from "../shade/colours";
import { HIGHLIGHTED } from "../shade/classes";
import { lift, lineMaterial, Lines, type Eye } from "./lines";
import type { ElementSet } from "./sets";
import { nextCorner } from "./topology";
import type { Edges, Faces } from "./topology";

interface Source {
  faces: Faces;
  edges: Edges;
  points: Float32Array;
  uvs: Float32Array;
  sets: ElementSet[];
  isDrawn(face: number): boolean;
}

/** How they are drawn. */
export interface LineStyle {
  flat: boolean;
  /** All sets, or highlighted ones alone. */
  hasSets: boolean;
  /** How far the mesh lies over another one, as a share of its distance. */
  over: number;
}

/** Both corners of an edge, and its class. Each face has its own, as in the flat view it is elsewhere. */
type Line = [corner: number, next: number, edgeClass: number];

// They outlive meshes, as a program is compiled anew when its last material goes.
const PLAIN = lineMaterial({ linewidth: 2.5, vertexColors: true });
const HOT = lineMaterial({ linewidth: 4, color: new Color(...ACCENT) });

/** Lines of one look in one of the ways in which the mesh is seen. They are made once they are drawn. */
class SetLine extends Lines {
  stale: "points" | "all" | null = null;
}

/** In space, or on the UV plane. */
class Way extends Group {
  readonly plain = new SetLine(PLAIN);
  readonly hot = new SetLine(HOT);

  constructor() {
    super();
    this.add(this.plain, this.hot);
  }
}

export class SetLines {
  readonly object = new Group();
  readonly #space = new Way();
  readonly #plane = new Way();
  #lines: Line[] = [];
  #hotClass = -1;
  #plain: Line[] = [];
  #hot: Line[] = [];

  constructor(private readonly source: Source) {
    this.object.add(this.#space, this.#plane);
  }

  /** Takes the edges of which the class is that of a set. */
  set(classes: Uint8Array): void {
    this.#lines = linesOf(this.source, classes);
    this.#sort();
  }

  /** Thickens the edges of a class, too. */
  setHot(edgeClass: number): void {
    if (edgeClass === this.#hotClass) return;
    this.#hotClass = edgeClass;
    this.#sort();
  }

  #sort(): void {
    const isHot = ([, , each]: Line) => each === HIGHLIGHTED || each === this.#hotClass;
    this.#plain = this.#lines.filter((line) => !isHot(line));
    this.#hot = this.#lines.filter(isHot);
    for (const { plain, hot } of [this.#space, this.#plane]) plain.stale = hot.stale = "all";
  }

  /** The points of the mesh have moved. */
  follow(): void {
    for (const lines of [this.#space.plain, this.#space.hot]) lines.stale ??= "points";
  }

  /** Returns whether there is a line. */
  show(eye: Eye, { flat, hasSets, over }: LineStyle): boolean {
    [this.#space.visible, this.#plane.visible] = [!flat, flat];
    const { plain, hot } = flat ? this.#plane : this.#space;
    PLAIN.visible = hasSets;
    for (const [lines, all, pixels] of [[plain, this.#plain, 4], [hot, this.#hot, 8]] as const) {
      if (lines.stale && (hasSets || lines === hot)) this.#fill(lines, all, flat);
      lift(lines, eye, pixels, over);
      lines.renderOrder = over > 0 ? 5 : 1;
    }
    return (hasSets && plain.visible) || hot.visible;
  }

  #fill(lines: SetLine, all: Line[], flat: boolean): void {
    const hasColours = lines.stale === "all" && lines.material === PLAIN;
    lines.set(this.#ends(all, flat), hasColours ? this.#colours(all) : undefined);
    lines.stale = null;
  }

  #ends(lines: Line[], flat: boolean): Float32Array {
    const { faces, points, uvs } = this.source;
    const ends = new Float32Array(6 * lines.length);
    const put = (corner: number, at: number) => {
      const from = flat ? 2 * corner : 4 * faces.corners[corner];
      ends.set((flat ? uvs : points).subarray(from, from + (flat ? 2 : 3)), at);
    };
    lines.forEach(([corner, next], at) => (put(corner, 6 * at), put(next, 6 * at + 3)));
    return ends;
  }

  #colours(lines: Line[]): Float32Array {
    const byClass = new Map(this.source.sets.map(({ name, edgeClass }) => [edgeClass, setColour(name)]));
    const ends = (colour: Rgb) => [...colour, ...colour];
    return Float32Array.from(lines.flatMap(([, , edgeClass]) => ends(byClass.get(edgeClass) ?? ACCENT)));
  }

  dispose(): void {
    for (const { plain, hot } of [this.#space, this.#plane]) [plain, hot].forEach(({ geometry }) => geometry.dispose());
  }
}

function linesOf(source: Source, classes: Uint8Array): Line[] {
  const { faces, edges } = source;
  const found: Line[] = [];
  for (let face = 0; face + 1 < faces.starts.length; face++) {
    if (!source.isDrawn(face)) continue;
    for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
      const edgeClass = classes[edges.ofCorner[corner]];
      const isShown = !faces.shown || faces.shown[corner];
      if (edgeClass >= HIGHLIGHTED && isShown) found.push([corner, nextCorner(faces, face, corner), edgeClass]);
    }
  }
  return found;
}
