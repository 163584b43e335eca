// What the camera frames: everything, the highlighted sets, or the marks.

import { Box3, Sphere, Vector3 } from "three";
import type { Cloth } from "../mesh/cloth";
import type { Shapes } from "../mesh/marks";
import { elementsOfSet, ownerOf, shapesOf } from "../mesh/shapes";
import type { Cloud } from "./rig";

/** Least radius of what is framed, so that a mark is seen with the cloth around it. [mean edges], [UV units] */
const CONTEXT = 8;
const FLAT_CONTEXT = 0.06;

/** All of the mesh that is drawn. */
export function wholeOf(cloth: Cloth, flat: boolean): Cloud {
  if (cloth.isIsolated) {
    const drawn = [...Array(cloth.faceCount).keys()].filter((face) => cloth.isDrawn(face));
    const faces = drawn.map((face) => ownerOf(cloth, face));
    return { values: placesOfShapes(shapesOf(cloth, { faces }, flat)), stride: 3 };
  }
  return flat ? { values: cloth.uvs, stride: 2 } : { values: cloth.points, stride: 4 };
}

/** Places of all elements of the sets, x, y, z each. */
export function placesOfSets(cloth: Cloth, names: ReadonlySet<string>, flat: boolean): number[] {
  const all = [...names].map((name) => elementsOfSet(cloth, name));
  return all.flatMap((elements) => (elements ? placesOfShapes(shapesOf(cloth, elements, flat)) : []));
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

function meanEdge({ faces: { starts, corners }, points }: Cloth): number {
  const [a, b] = [new Vector3(), new Vector3()];
  let sum = 0;
  for (let face = 0; face + 1 < starts.length; face++) {
    b.fromArray(points, 4 * corners[starts[face + 1] - 1]);
    for (let corner = starts[face]; corner < starts[face + 1]; corner++) {
      sum += a.copy(b).distanceTo(b.fromArray(points, 4 * corners[corner]));
    }
  }
  return sum / Math.max(1, corners.length);
}
