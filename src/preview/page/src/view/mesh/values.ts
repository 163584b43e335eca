// The values of a mesh that heat shows.

import type { DrawnValues } from "../../server/protocol";
import { scaleOf, shareOf } from "../shade/heat";
import type { Cloth } from "./cloth";
import { ownerOf } from "./shapes";

/** A number for each point, corner or face. */
export interface MeshValues extends DrawnValues {
  numbers: Float32Array;
}

/** Where each value is on the scale. */
export function sharesOf(values: MeshValues): Float32Array {
  const scale = scaleOf(values);
  return values.numbers.map((value) => shareOf(value, scale));
}

/** How many values are in each of equal parts of the scale. Those beyond it are in the last parts. */
export function histogram(values: MeshValues, parts: number): number[] {
  const counts = new Array<number>(parts).fill(0);
  for (const share of sharesOf(values)) {
    if (!Number.isNaN(share)) counts[Math.min(parts - 1, Math.max(0, Math.floor(share * parts)))] += 1;
  }
  return counts;
}

/** The face with the worst quality: the least angle, or the length that is farthest from the target; -1 if there is none. */
export function worstFace(cloth: Cloth): number {
  const { values } = cloth;
  if (!values || values.of !== "face" || !isQuality(values)) return -1;
  const { isAboutIdeal } = scaleOf(values);
  let [worst, found] = [-Infinity, -1];
  sharesOf(values).forEach((share, face) => {
    const badness = isAboutIdeal ? Math.abs(share - 0.5) : -share;
    if (badness > worst && cloth.isDrawn(face)) [worst, found] = [badness, face];
  });
  return found < 0 ? -1 : ownerOf(cloth, found);
}

export function isQuality({ name }: { name: string }): boolean {
  return name.startsWith("quality:");
}
