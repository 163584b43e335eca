// Positions as the textures hold them: x, y, z and an unused number.

export interface Box {
  least: [number, number, number];
  most: [number, number, number];
}

/** Copies x, y, z to every fourth number, and returns their bounds. */
export function copyPoints(from: Float32Array, to: Float32Array): Box {
  let [left, low, back] = [Infinity, Infinity, Infinity];
  let [right, high, front] = [-Infinity, -Infinity, -Infinity];
  for (let at = 0, point = 0; at + 2 < from.length; at += 3, point += 4) {
    const x = from[at];
    const y = from[at + 1];
    const z = from[at + 2];
    to[point] = x;
    to[point + 1] = y;
    to[point + 2] = z;
    if (x < left) left = x;
    if (x > right) right = x;
    if (y < low) low = y;
    if (y > high) high = y;
    if (z < back) back = z;
    if (z > front) front = z;
  }
  return { least: [left, low, back], most: [right, high, front] };
}

/** The sum of all coordinates. */
export function checksum(points: Float32Array): number {
  let sum = 0;
  for (let at = 0; at + 3 < points.length; at += 4) sum += points[at] + points[at + 1] + points[at + 2];
  return sum;
}
