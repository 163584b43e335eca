// Positions as the textures hold them: x, y, z and an unused number.

import { Box3 } from "three";

/** Copies x, y, z to every fourth number, and returns their bounds. */
export function copyPoints(from: Float32Array, to: Float32Array): Box3 {
  for (let at = 0, point = 0; at + 2 < from.length; at += 3, point += 4) {
    to[point] = from[at];
    to[point + 1] = from[at + 1];
    to[point + 2] = from[at + 2];
  }
  return new Box3().setFromArray(from);
}

/** The sum of all coordinates. */
export function checksum(points: Float32Array): number {
  let sum = 0;
  for (let at = 0; at + 3 < points.length; at += 4) sum += points[at] + points[at + 1] + points[at + 2];
  return sum;
}
