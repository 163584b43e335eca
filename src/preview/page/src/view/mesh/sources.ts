// Elements of the model on a mesh that was made of it, by the model's face of each of its faces.

import { Line3, Vector3 } from "three";
import type { Cloth } from "./cloth";
import { ownerOf } from "./shapes";
import type { Elements } from "./shapes";
import { nextCorner } from "./topology";

/** The faces, edges and points of a mesh that come from elements of the model, those that operators made included. A point has
 *  the nearest point. Faces that are too small for a face of the mesh have the nearest point of their own points. */
export function carried(model: Cloth, mesh: Cloth, elements: Elements): Elements {
  if (!mesh.sources) return elements;
  const drawn = new Drawn(model, mesh, elements);
  const found: Required<Elements> = { points: [], edges: [], faces: [] };
  for (const face of elements.faces ?? []) drawn.addFace(face, found);
  for (const point of elements.points ?? []) found.points.push(...drawn.nearest(point));
  for (const edge of elements.edges ?? []) drawn.addEdge(edge, found);
  return found;
}

/** The elements that are drawn: all, or those of what is shown alone. */
export function drawnOf(mesh: Cloth, { points = [], edges = [], faces = [] }: Elements): Elements {
  const { starts, corners } = mesh.faces;
  const [ownPoints, ownFaces] = [new Set<number>(), new Set<number>()];
  for (let face = 0; face < mesh.faceCount; face++) {
    if (!mesh.isDrawn(face)) continue;
    ownFaces.add(ownerOf(mesh, face));
    for (let corner = starts[face]; corner < starts[face + 1]; corner++) ownPoints.add(corners[corner]);
  }
  return {
    points: points.filter((point) => ownPoints.has(point)),
    edges: edges.filter((ends) => ends.every((end) => ownPoints.has(end))),
    faces: faces.filter((face) => ownFaces.has(face)),
  };
}

/** Remembers what it carried, since points move more often than faces change. */
export class Carrying {
  readonly #known = new WeakMap<Cloth, { model: Cloth; sources: Uint32Array | null; elements: Elements; found: Elements }>();

  of(model: Cloth, mesh: Cloth, elements: Elements): Elements {
    const known = this.#known.get(mesh);
    if (known?.model === model && known.elements === elements && known.sources === mesh.sources) return known.found;
    const found = mesh === model ? elements : carried(model, mesh, elements);
    this.#known.set(mesh, { model, sources: mesh.sources, elements, found });
    return found;
  }
}

/** The model's face of each face that is drawn, also where it is refined for display. */
export function sourceOf(mesh: Cloth, face: number): number {
  const owner = ownerOf(mesh, face);
  return mesh.sources ? mesh.sources[owner] : owner;
}

/** The corners of a face of the model. Where it is refined for display, they are those of its parts, in order, at points that the
 *  model has itself. */
export function cageCorners({ faces }: Cloth, face: number, points: number): number[] {
  const first = faces.owner ? faces.owner.indexOf(face) : face;
  const found = new Map<number, number>();
  for (let part = first; part >= 0 && (part === first || faces.owner?.[part] === face); part++) {
    for (let corner = faces.starts[part]; corner < faces.starts[part + 1]; corner++) {
      const point = faces.corners[corner];
      if (point < points && !found.has(point)) found.set(point, corner);
    }
  }
  return [...found.values()];
}

class Drawn {
  /** Faces of the model around each point that is asked for. */
  readonly #around = new Map<number, Set<number>>();
  /** Points of each face of the model that is asked for. */
  readonly #corners = new Map<number, Set<number>>();
  /** Faces of the mesh, as drawn, of each face of the model that is asked for. */
  readonly #parts = new Map<number, number[]>();

  constructor(
    private readonly model: Cloth,
    private readonly mesh: Cloth,
    { points = [], edges = [], faces = [] }: Elements,
  ) {
    for (const point of [...points, ...edges.flat()]) this.#around.set(point, new Set());
    for (const face of faces) this.#corners.set(face, new Set());
    this.#readModel();
    for (const face of [...this.#corners.keys(), ...[...this.#around.values()].flatMap((all) => [...all])]) {
      this.#parts.set(face, []);
    }
    for (let face = 0; face < mesh.faceCount; face++) this.#parts.get(sourceOf(mesh, face))?.push(face);
  }

  #readModel(): void {
    const { faces, faceCount } = this.model;
    for (let face = 0; face < faceCount; face++) {
      const owner = ownerOf(this.model, face);
      const corners = this.#corners.get(owner);
      for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
        this.#around.get(faces.corners[corner])?.add(owner);
        corners?.add(faces.corners[corner]);
      }
    }
  }

  addFace(face: number, found: Required<Elements>): void {
    const parts = this.#parts.get(face) ?? [];
    found.faces.push(...new Set(parts.map((part) => ownerOf(this.mesh, part))));
    if (parts.length > 0) return;
    for (const point of this.#corners.get(face) ?? []) found.points.push(...this.nearest(point).slice(0, 1));
  }

  /** The edges between the two faces of the model, or on its border; or else the points nearest to the ends. */
  addEdge([a, b]: [number, number], found: Required<Elements>): void {
    const sides = [...this.#of(a)].filter((face) => this.#of(b).has(face));
    const edges = sides.length > 1 ? this.#between(new Set(sides)) : this.#onBorder(sides, a, b);
    if (edges.length > 0) found.edges.push(...edges);
    else found.points.push(...this.nearest(a), ...this.nearest(b));
  }

  #of(point: number): Set<number> {
    return this.#around.get(point) ?? new Set();
  }

  #between(sides: Set<number>): [number, number][] {
    const first = new Map<number, number>();
    const found: [number, number][] = [];
    this.#eachEdge(sides, (edge, pair, source) => {
      const before = first.get(edge);
      if (before === undefined) first.set(edge, source);
      else if (before !== source) found.push(pair);
    });
    return found;
  }

  /** Edges of one face beside the segment from a to b; a face may have several borders. */
  #onBorder(sides: number[], a: number, b: number): [number, number][] {
    const [p, q] = [placeOf(this.model, a), placeOf(this.model, b)];
    const segment = new Line3(p, q);
    const reach = 0.35 * segment.distance();
    const found: [number, number][] = [];
    this.#eachEdge(new Set(sides), (edge, pair) => {
      const [s, t] = pair.map((point) => placeOf(this.mesh, point));
      const middle = s.add(t).multiplyScalar(0.5);
      const beside = segment.closestPointToPoint(middle, true, new Vector3());
      if (this.mesh.edges.uses[edge] === 1 && beside.distanceTo(middle) < reach) found.push(pair);
    });
    return found;
  }

  #eachEdge(sides: Set<number>, visit: (edge: number, pair: [number, number], source: number) => void): void {
    const { faces, edges } = this.mesh;
    for (const source of sides) {
      for (const face of this.#parts.get(source) ?? []) {
        for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
          const pair: [number, number] = [faces.corners[corner], faces.corners[nextCorner(faces, face, corner)]];
          visit(edges.ofCorner[corner], pair, source);
        }
      }
    }
  }

  /** The nearest point of the faces around a point of the model, or of all faces where those have none. */
  nearest(point: number): number[] {
    if (point >= this.model.pointCount) return [];
    const { faces } = this.mesh;
    const at = placeOf(this.model, point);
    const parts = [...this.#of(point)].flatMap((face) => this.#parts.get(face) ?? []);
    let [least, found] = [Infinity, -1];
    const look = (candidate: number): void => {
      const far = at.distanceTo(placeOf(this.mesh, candidate));
      if (far < least) [least, found] = [far, candidate];
    };
    for (const face of parts) faces.corners.subarray(faces.starts[face], faces.starts[face + 1]).forEach(look);
    if (parts.length === 0) for (let each = 0; each < this.mesh.pointCount; each++) look(each);
    return found < 0 ? [] : [found];
  }
}

export function placeOf(cloth: Cloth, point: number): Vector3 {
  return new Vector3().fromArray(cloth.points, 4 * point);
}
