// Smooth normals and the curvature of the surface. Vectors are x, y, z and a fourth number, as in the textures.

import type { Faces } from "./topology";

/** Fills `normals` with unit normals, weighted by area, and with the mean curvature in the fourth number: above 0 where
 *  the surface is hollow as seen with the normals towards you. [1 / length] */
export function computeNormals(points: Float32Array, faces: Faces, normals: Float32Array): void {
  normals.fill(0);
  addFaceNormals(points, faces, normals);
  normalise(normals);
  addCurvature(points, faces, normals);
}

function addFaceNormals(p: Float32Array, { starts, corners }: Faces, n: Float32Array): void {
  for (let face = 0; face + 1 < starts.length; face++) {
    const first = starts[face];
    const size = starts[face + 1] - first;
    if (size === 4) addQuad(p, n, corners, first);
    else addFan(p, n, corners, first, size);
  }
}

/** The cross product of the diagonals is twice the area. */
function addQuad(p: Float32Array, n: Float32Array, corners: Uint32Array, first: number): void {
  const a = 4 * corners[first];
  const b = 4 * corners[first + 1];
  const c = 4 * corners[first + 2];
  const d = 4 * corners[first + 3];
  const ux = p[c] - p[a];
  const uy = p[c + 1] - p[a + 1];
  const uz = p[c + 2] - p[a + 2];
  const vx = p[d] - p[b];
  const vy = p[d + 1] - p[b + 1];
  const vz = p[d + 2] - p[b + 2];
  const x = uy * vz - uz * vy;
  const y = uz * vx - ux * vz;
  const z = ux * vy - uy * vx;
  add(n, a, x, y, z);
  add(n, b, x, y, z);
  add(n, c, x, y, z);
  add(n, d, x, y, z);
}

function addFan(p: Float32Array, n: Float32Array, corners: Uint32Array, first: number, size: number): void {
  const a = 4 * corners[first];
  let x = 0;
  let y = 0;
  let z = 0;
  for (let step = 1; step + 1 < size; step++) {
    const b = 4 * corners[first + step];
    const c = 4 * corners[first + step + 1];
    const ux = p[b] - p[a];
    const uy = p[b + 1] - p[a + 1];
    const uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a];
    const vy = p[c + 1] - p[a + 1];
    const vz = p[c + 2] - p[a + 2];
    x += uy * vz - uz * vy;
    y += uz * vx - ux * vz;
    z += ux * vy - uy * vx;
  }
  for (let step = 0; step < size; step++) add(n, 4 * corners[first + step], x, y, z);
}

function add(n: Float32Array, at: number, x: number, y: number, z: number): void {
  n[at] += x;
  n[at + 1] += y;
  n[at + 2] += z;
}

function normalise(n: Float32Array): void {
  for (let at = 0; at < n.length; at += 4) {
    const length = Math.sqrt(n[at] * n[at] + n[at + 1] * n[at + 1] + n[at + 2] * n[at + 2]);
    const scale = length > 0 ? 1 / length : 0;
    n[at] *= scale;
    n[at + 1] *= scale;
    n[at + 2] *= scale;
  }
}

/** The mean of the normal curvature along the edges that leave a point. Each inner edge leaves both of its points, as
 *  its two faces run along it in opposite ways. */
function addCurvature(p: Float32Array, { starts, corners }: Faces, n: Float32Array): void {
  const edges = leaving(n.length / 4);
  for (let face = 0; face + 1 < starts.length; face++) {
    const end = starts[face + 1];
    let a = 4 * corners[end - 1];
    for (let corner = starts[face]; corner < end; corner++) {
      const b = 4 * corners[corner];
      const x = p[b] - p[a];
      const y = p[b + 1] - p[a + 1];
      const z = p[b + 2] - p[a + 2];
      const square = x * x + y * y + z * z;
      if (square > 0) {
        n[a + 3] += (2 * (x * n[a] + y * n[a + 1] + z * n[a + 2])) / square;
        edges[a >> 2]++;
      }
      a = b;
    }
  }
  for (let at = 3, point = 0; at < n.length; at += 4, point++) if (edges[point] > 1) n[at] /= edges[point];
}

let scratch = new Uint8Array(0);

/** One buffer for all updates, so that they leave no garbage. */
function leaving(points: number): Uint8Array {
  if (scratch.length < points) scratch = new Uint8Array(points);
  else scratch.fill(0, 0, points);
  return scratch;
}
