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

/** The sum of the fan's cross products is twice the area. */
function addFaceNormals(p: Float32Array, { starts, corners }: Faces, n: Float32Array): void {
  for (let face = 0; face + 1 < starts.length; face++) {
    const end = starts[face + 1];
    const a = 4 * corners[starts[face]];
    let [x, y, z] = [0, 0, 0];
    for (let corner = starts[face] + 1; corner + 1 < end; corner++) {
      const b = 4 * corners[corner];
      const c = 4 * corners[corner + 1];
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
    for (let corner = starts[face]; corner < end; corner++) {
      const at = 4 * corners[corner];
      n[at] += x;
      n[at + 1] += y;
      n[at + 2] += z;
    }
  }
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
