// Panels of the model: faces that are joined without a seam of the UV set between them.

import type { Cloth } from "./cloth";
import { ownerOf } from "./shapes";
import type { Elements } from "./shapes";

/** The set of edges where the UV set is cut, which the server adds. */
export const CUTS = "UV seams";

/** The faces of the model in the panels of some of them; without UVs, in their connected pieces. */
export function panelsOf(model: Cloth, seeds: ReadonlySet<number>): Set<number> {
  const { faces, edges, faceCount } = model;
  const beside = neighbours(model);
  const cut = cuts(model);
  const reached = new Uint8Array(faceCount);
  const waiting = [...Array(faceCount).keys()].filter((face) => seeds.has(ownerOf(model, face)));
  for (const face of waiting) reached[face] = 1;
  for (let face = waiting.pop(); face !== undefined; face = waiting.pop()) {
    for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
      const edge = edges.ofCorner[corner];
      const other = beside[2 * edge] === face ? beside[2 * edge + 1] : beside[2 * edge];
      if (other < 0 || reached[other] || cut.has(edge)) continue;
      reached[other] = 1;
      waiting.push(other);
    }
  }
  const found = new Set<number>();
  reached.forEach((is, face) => is && found.add(ownerOf(model, face)));
  return found;
}

/** Elements of the model by the places where they are: those that are in one face, or touch, are together. The largest first. */
export function placesIn(model: Cloth, { points = [], edges = [], faces = [] }: Elements): Elements[] {
  const { starts, corners } = model.faces;
  const marked = new Set([...points, ...edges.flat()]);
  const own = new Set(faces);
  const parents = new Map<number, number>();
  const find = (point: number): number => {
    let at = point;
    for (let up = parents.get(at); up !== undefined && up !== at; up = parents.get(at)) at = up;
    return at;
  };
  const firsts = new Map<number, number>();
  for (let face = 0; face < model.faceCount; face++) {
    const owner = ownerOf(model, face);
    for (const point of corners.subarray(starts[face], starts[face + 1])) {
      if (!own.has(owner) && !marked.has(point)) continue;
      if (!firsts.has(owner)) firsts.set(owner, point);
      parents.set(find(point), find(firsts.get(owner) ?? point));
    }
  }
  const found = new Map<number, Required<Elements>>();
  const at = (point: number) => {
    const root = find(point);
    const place = found.get(root) ?? { points: [], edges: [], faces: [] };
    found.set(root, place);
    return place;
  };
  for (const point of points) at(point).points.push(point);
  for (const edge of edges) at(edge[0]).edges.push(edge);
  for (const face of faces) at(firsts.get(face) ?? -1 - face).faces.push(face);
  const size = (place: Required<Elements>) => place.points.length + place.edges.length + place.faces.length;
  return [...found.values()].sort((a, b) => size(b) - size(a));
}

/** The faces of the model that touch the elements. */
export function facesAt(model: Cloth, elements: Elements): Set<number> {
  const found = new Set(elements.faces);
  const points = new Set([...(elements.points ?? []), ...(elements.edges ?? []).flat()]);
  const edges = new Set((elements.edges ?? []).map(([a, b]) => model.edges.find(a, b)));
  const { starts, corners } = model.faces;
  for (let face = 0; face < model.faceCount; face++) {
    for (let corner = starts[face]; corner < starts[face + 1]; corner++) {
      // Where the mesh is refined for display, its edges are others than those of the model.
      const isAt = elements.edges && !model.faces.owner ? edges.has(model.edges.ofCorner[corner]) : points.has(corners[corner]);
      if (isAt) found.add(ownerOf(model, face));
    }
  }
  return found;
}

/** The first two faces of each edge, or -1. */
function neighbours({ faces, edges, faceCount }: Cloth): Int32Array {
  const beside = new Int32Array(2 * edges.room).fill(-1);
  for (let face = 0; face < faceCount; face++) {
    for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
      const at = 2 * edges.ofCorner[corner];
      if (beside[at] < 0) beside[at] = face;
      else if (beside[at + 1] < 0) beside[at + 1] = face;
    }
  }
  return beside;
}

function cuts({ sets, edges }: Cloth): Set<number> {
  const found = new Set<number>();
  for (const { name, kind, elements } of sets) {
    if (name !== CUTS || kind !== "edge") continue;
    for (let at = 0; at + 1 < elements.length; at += 2) found.add(edges.find(elements[at], elements[at + 1]));
  }
  return found;
}
