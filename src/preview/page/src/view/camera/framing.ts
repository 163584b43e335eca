// What the camera frames: everything, the highlighted sets, or the marks.

import { Box3, Sphere, Vector3 } from "three";
import type { Cloth } from "../mesh/cloth";
import type { Shapes } from "../mesh/marks";
import type { Cloud } from "./rig";

/** Least radius of what is framed, so that a mark is seen with the cloth around it. [mean edges], [UV units] */
const CONTEXT = 8;
const FLAT_CONTEXT = 0.06;

/** All of the mesh that is drawn. */
export function wholeOf(cloth: Cloth, flat: boolean): Cloud {
  if (cloth.isIsolated) return { values: placesDrawn(cloth, flat), stride: flat ? 2 : 4 };
  return flat ? { values: cloth.uvs, stride: 2 } : { values: cloth.points, stride: 4 };
}

function placesDrawn(cloth: Cloth, flat: boolean): number[] {
  const { starts, corners } = cloth.faces;
  const places: number[] = [];
  for (let face = 0; face < cloth.faceCount; face++) {
    if (!cloth.isDrawn(face)) continue;
    for (let corner = starts[face]; corner < starts[face + 1]; corner++) {
      if (flat) places.push(...cloth.uvs.subarray(2 * corner, 2 * corner + 2));
      else places.push(...cloth.points.subarray(4 * corners[corner], 4 * corners[corner] + 4));
    }
  }
  return places;
}

/** Places of all elements of the sets, x, y, z each. */
export function placesOfSets(cloth: Cloth, names: ReadonlySet<string>, flat: boolean): number[] {
  const points = pointsOfSets(cloth, names);
  const places: number[] = [];
  if (!flat) for (const point of points) places.push(...cloth.points.subarray(4 * point, 4 * point + 3));
  else if (cloth.hasUvs) {
    cloth.faces.corners.forEach((point, corner) => {
      if (points.has(point)) places.push(cloth.uvs[2 * corner], cloth.uvs[2 * corner + 1], 0);
    });
  }
  return places;
}

function pointsOfSets(cloth: Cloth, names: ReadonlySet<string>): Set<number> {
  const points = new Set<number>();
  const { starts, corners } = cloth.faces;
  for (const { name, kind, elements } of cloth.sets) {
    if (!names.has(name)) continue;
    for (const element of elements) {
      if (kind !== "face") points.add(element);
      else for (let corner = starts[element]; corner < starts[element + 1]; corner++) points.add(corners[corner]);
    }
  }
  return points;
}

export function placesOfShapes({ points, segments, triangles }: Shapes): number[] {
  return [points, segments, triangles].flat();
}

/** The sphere around the box of places, no smaller than what gives context; null if there are none. */
export function ballOf(places: number[], cloth: Cloth, flat: boolean): Sphere | null {
  if (places.length === 0) return null;
  const { center, radius } = new Box3().setFromArray(places).getBoundingSphere(new Sphere());
  const context = flat ? FLAT_CONTEXT : CONTEXT * meanEdge(cloth);
  return new Sphere(center, Math.max(radius, context));
}

/** The mean of the outward normals, or null if they cancel out. */
export function meanNormal(cloth: Cloth, points: number[]): Vector3 | null {
  const sum = new Vector3();
  for (const point of points) sum.add(new Vector3().fromArray(cloth.normals, 4 * point));
  return sum.length() > 0.3 * points.length ? sum.normalize().multiplyScalar(cloth.handed) : null;
}

function meanEdge(cloth: Cloth): number {
  const { starts, corners } = cloth.faces;
  let sum = 0;
  for (let face = 0; face + 1 < starts.length; face++) {
    let before = corners[starts[face + 1] - 1];
    for (let corner = starts[face]; corner < starts[face + 1]; corner++) {
      const point = corners[corner];
      sum += length(cloth.points, 4 * before, 4 * point);
      before = point;
    }
  }
  return sum / Math.max(1, corners.length);
}

function length(p: Float32Array, a: number, b: number): number {
  return Math.hypot(p[a] - p[b], p[a + 1] - p[b + 1], p[a + 2] - p[b + 2]);
}
