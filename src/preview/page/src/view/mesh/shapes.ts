// Where marked elements are, in space or on the UV plane.

import type { Cloth } from "./cloth";
import type { Marks, Shapes } from "./marks";
import { nextCorner } from "./topology";

/** Elements of any kinds. */
export interface Elements {
  points?: number[];
  edges?: [number, number][];
  faces?: number[];
}

/** Shapes of elements of the mesh. If it is refined for display, its first points are those of the cage. */
export function shapesOf(cloth: Cloth, elements: Elements, flat: boolean): Shapes {
  return flat ? flatShapes(cloth, elements) : spaceShapes(cloth, elements);
}

export function placeMarks(marks: Marks, model: Cloth | undefined, elements: Elements | null, flat: boolean): void {
  if (model && elements) marks.set(shapesOf(model, elements, flat));
  else marks.clear();
}

/** Highlighted point sets, which cloth itself cannot show. */
export function placeGlow(marks: Marks, cloths: Cloth[], names: ReadonlySet<string>, flat: boolean): void {
  const setsOf = (cloth: Cloth) => cloth.sets.filter(({ name, kind }) => kind === "point" && names.has(name));
  const cloth = names.size ? cloths.find((shown) => setsOf(shown).length > 0) : undefined;
  const points = cloth ? setsOf(cloth).flatMap(({ elements }) => [...elements]) : [];
  placeMarks(marks, cloth, { points }, flat);
}

/** The elements of a set of the mesh as it is drawn; null if it has none of that name. */
export function elementsOfSet(cloth: Cloth, name: string): Elements | null {
  const set = cloth.sets.find((each) => each.name === name);
  if (!set) return null;
  if (set.kind !== "face") return { points: [...new Set(set.elements)] };
  return { faces: [...new Set([...set.elements].map((face) => ownerOf(cloth, face)))] };
}

/** The points that the elements touch. */
export function pointsOf(cloth: Cloth, elements: Elements): number[] {
  const points = new Set<number>(elements.points ?? []);
  elements.edges?.forEach((pair) => pair.forEach((point) => points.add(point)));
  const faces = new Set(elements.faces ?? []);
  eachCorner(cloth, (corner, _, face) => {
    if (faces.has(ownerOf(cloth, face))) points.add(cloth.faces.corners[corner]);
  });
  return [...points].filter((point) => point < cloth.pointCount);
}

function spaceShapes(cloth: Cloth, elements: Elements): Shapes {
  const place = (point: number): number[] => [...cloth.points.subarray(4 * point, 4 * point + 3)];
  const known = (point: number): boolean => point < cloth.pointCount;
  const corner = (index: number): number[] => place(cloth.faces.corners[index]);
  return {
    points: (elements.points ?? []).filter(known).flatMap(place),
    segments: (elements.edges ?? []).filter((pair) => pair.every(known)).flatMap((pair) => pair.flatMap(place)),
    triangles: trianglesOf(cloth, elements).flatMap(corner),
  };
}

/** A point or an edge may be at several places of the UV plane. */
function flatShapes(cloth: Cloth, elements: Elements): Shapes {
  const shapes: Shapes = { points: [], segments: [], triangles: [] };
  if (!cloth.hasUvs) return shapes;
  const place = (corner: number): [number, number, number] => [cloth.uvs[2 * corner], cloth.uvs[2 * corner + 1], 0];
  const points = new Set(elements.points ?? []);
  const edges = new Set((elements.edges ?? []).map(([a, b]) => cloth.edges.find(a, b)));
  eachCorner(cloth, (corner, next) => {
    if (points.has(cloth.faces.corners[corner])) shapes.points.push(...place(corner));
    if (edges.has(cloth.edges.ofCorner[corner])) shapes.segments.push(...place(corner), ...place(next));
  });
  shapes.triangles = trianglesOf(cloth, elements).flatMap(place);
  return shapes;
}

/** Corners of the triangles of the faces. */
function trianglesOf(cloth: Cloth, elements: Elements): number[] {
  const wanted = new Set(elements.faces ?? []);
  const found: number[] = [];
  if (wanted.size === 0) return found;
  cloth.triangles.faces.forEach((face, triangle) => {
    const corners = cloth.triangles.corners.subarray(3 * triangle, 3 * triangle + 3);
    if (wanted.has(ownerOf(cloth, face))) found.push(...corners);
  });
  return found;
}

export function ownerOf(cloth: Cloth, face: number): number {
  return cloth.faces.owner ? cloth.faces.owner[face] : face;
}

function eachCorner(cloth: Cloth, visit: (corner: number, next: number, face: number) => void): void {
  const { starts } = cloth.faces;
  for (let face = 0; face + 1 < starts.length; face++) {
    for (let corner = starts[face]; corner < starts[face + 1]; corner++) {
      visit(corner, nextCorner(cloth.faces, face, corner), face);
    }
  }
}
