// The edge sets of a mesh as lines, in space and on the UV plane.

import { Color, Group } from "three";
import { ACCENT, setColour } from "../shade/colours";
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

/** The lines in one of the ways in which the mesh is seen. They are made once they are drawn. */
class Way extends Group {
  isStale = true;
  readonly plain = new Lines(PLAIN);
  readonly hot = new Lines(HOT);

  constructor() {
    super();
    this.add(this.plain, this.hot);
  }
}

export class SetLines {
  readonly object = new Group();
  readonly #ways = { space: new Way(), plane: new Way() };
  #lines: Line[] = [];
  #hot = -1;

  constructor(private readonly source: Source) {
    this.object.add(...Object.values(this.#ways));
  }

  /** Takes the edges of which the class is that of a set. */
  set(classes: Uint8Array): void {
    this.#lines = linesOf(this.source, classes);
    this.#renew();
  }

  /** Thickens the edges of a class. */
  setHot(edgeClass: number): void {
    if (edgeClass === this.#hot) return;
    this.#hot = edgeClass;
    this.#renew();
  }

  #renew(): void {
    for (const way of Object.values(this.#ways)) way.isStale = true;
  }

  /** The points of the mesh have moved. */
  follow(): void {
    this.#ways.space.isStale = true;
  }


  /** Returns whether there is a line. */
  show(eye: Eye, { flat, hasSets, over }: LineStyle): boolean {
    const { space, plane } = this.#ways;
    const way = flat ? plane : space;
    if (way.isStale) this.#fill(way, flat);
    [space.visible, plane.visible] = [!flat, flat];
    way.plain.material.visible = hasSets;
    for (const [lines, pixels] of [[way.plain, 2.5], [way.hot, 3.5]] as const) {
      lift(lines, eye, pixels, over);
      lines.renderOrder = over > 0 ? 5 : 1;
    }
    return (hasSets && way.plain.visible) || way.hot.visible;
  }

  #fill(way: Way, flat: boolean): void {
    way.isStale = false;
    const isHot = ([, , edgeClass]: Line) => edgeClass === HIGHLIGHTED || edgeClass === this.#hot;
    const plain = this.#lines.filter((line) => !isHot(line));
    way.plain.set(this.#ends(plain, flat), this.#colours(plain));
    way.hot.set(this.#ends(this.#lines.filter(isHot), flat));
  }

  #ends(lines: Line[], flat: boolean): Float32Array {
    const { faces, points, uvs } = this.source;
    const ends = new Float32Array(6 * lines.length);
    lines.forEach(([corner, next], at) =>
      [corner, next].forEach((each, end) => {
        const from = flat ? 2 * each : 4 * faces.corners[each];
        ends.set((flat ? uvs : points).subarray(from, from + (flat ? 2 : 3)), 6 * at + 3 * end);
      }),
    );
    return ends;
  }

  #colours(lines: Line[]): Float32Array {
    const byClass = new Map(this.source.sets.map(({ name, edgeClass }) => [edgeClass, setColour(name)]));
    return Float32Array.from(lines.flatMap(([, , edgeClass]) => [0, 1].flatMap(() => byClass.get(edgeClass) ?? ACCENT)));
  }

  dispose(): void {
    for (const { plain, hot } of Object.values(this.#ways)) [plain, hot].forEach(({ geometry }) => geometry.dispose());
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
