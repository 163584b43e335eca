// A brush that paints weights of the points of the model.

import { Vector3 } from "three";
import type { Elements } from "../server/protocol";
import type { Brush } from "./api";
import type { Cloth } from "./mesh/cloth";
import { pointsOf } from "./mesh/shapes";
import { placeOf } from "./mesh/sources";
import { nextCorner } from "./mesh/topology";

export type Stroke = "paint" | "erase" | "smooth";

/** Rings around a set over which its weights fall to 0, as in the engine. */
const BLEND = 2;

const neighbours = new WeakMap<Cloth, Set<number>[]>();

/** The points that an edge leads to from each point. */
function around(model: Cloth): Set<number>[] {
  const known = neighbours.get(model);
  if (known) return known;
  const { starts, corners } = model.faces;
  const found = Array.from({ length: model.pointCount }, () => new Set<number>());
  for (let face = 0; face < model.faceCount; face++) {
    for (let corner = starts[face]; corner < starts[face + 1]; corner++) {
      const [a, b] = [corners[corner], corners[nextCorner(model.faces, face, corner)]];
      found[a].add(b);
      found[b].add(a);
    }
  }
  neighbours.set(model, found);
  return found;
}

/** The weights of a set: 1 at its points, and less on each ring around them. */
export function blended(model: Cloth, elements: Elements | null): Float32Array<ArrayBuffer> {
  const weights = new Float32Array(model.pointCount);
  let rim = elements ? pointsOf(model, elements) : [];
  for (let ring = 0; ring <= BLEND; ring++) {
    for (const point of rim) weights[point] = 1 - ring / (BLEND + 1);
    rim = [...new Set(rim.flatMap((point) => [...around(model)[point]]))].filter((point) => weights[point] === 0);
  }
  return weights;
}

/** Paints around a place on a face, as far as edges lead within the radius: other layers keep their weights. */
export function dab(model: Cloth, face: number, at: Vector3, { weights, radius, strength, mirror }: Brush, stroke: Stroke): void {
  const { starts, corners } = model.faces;
  const far = (point: number) => placeOf(model, point).distanceTo(at) / radius;
  const reached = new Set(corners.subarray(starts[face], starts[face + 1]));
  for (const point of reached) {
    for (const next of around(model)[point]) if (far(next) < 1) reached.add(next);
  }
  const shares = new Map<number, number>();
  for (const point of reached) {
    const share = strength * Math.max(0, 1 - far(point) ** 2) ** 2;
    for (const each of [point, mirror?.[point] ?? point]) shares.set(each, Math.max(share, shares.get(each) ?? 0));
  }
  const before = weights.slice();
  for (const [point, share] of shares) {
    const beside = [...around(model)[point]];
    const mean = beside.reduce((sum, each) => sum + before[each], 0) / Math.max(1, beside.length);
    const goal = stroke === "smooth" ? mean : stroke === "erase" ? 0 : 1;
    weights[point] += share * (goal - before[point]);
  }
}
