// The faces of a mesh as the view needs them: triangles of corners, and a number for each edge.

/** Corners `starts[f]` to `starts[f + 1]` are those of face f. */
export interface Faces {
  starts: Uint32Array;
  /** Point of each corner. */
  corners: Uint32Array;
  /** 1 if the edge from the corner to the next is an edge of the mesh; null if all are. */
  shown: Uint8Array | null;
  /** Face of the mesh of each drawn face; null if they are the same. */
  owner: Uint32Array | null;
}

export interface Triangles {
  /** Three corners of each triangle. */
  corners: Uint32Array;
  /** Face of each triangle. */
  faces: Uint32Array;
}

export function startsOf(counts: Uint32Array): Uint32Array {
  const starts = new Uint32Array(counts.length + 1);
  for (let face = 0; face < counts.length; face++) starts[face + 1] = starts[face] + counts[face];
  return starts;
}

export function nextCorner(faces: Faces, face: number, corner: number): number {
  return corner + 1 < faces.starts[face + 1] ? corner + 1 : faces.starts[face];
}

/** Fans of all faces but the holes. `points` holds x, y, z and a fourth number. */
export function triangulate(faces: Faces, points: Float32Array, holes: Uint32Array | undefined): Triangles {
  const { starts, corners } = faces;
  const skipped = new Uint8Array(starts.length - 1);
  holes?.forEach((face) => (skipped[face] = 1));
  let count = 0;
  for (let face = 0; face + 1 < starts.length; face++) {
    if (!skipped[face]) count += Math.max(0, starts[face + 1] - starts[face] - 2);
  }
  const triangles = { corners: new Uint32Array(3 * count), faces: new Uint32Array(count) };
  let at = 0;
  for (let face = 0; face + 1 < starts.length; face++) {
    const first = starts[face];
    const size = starts[face + 1] - first;
    if (skipped[face] || size < 3) continue;
    const turn = size === 4 && cutsSecondDiagonal(points, corners, first) ? 1 : 0;
    for (let step = 1; step + 1 < size; step++) {
      triangles.corners[3 * at] = first + turn;
      triangles.corners[3 * at + 1] = first + ((step + turn) % size);
      triangles.corners[3 * at + 2] = first + ((step + 1 + turn) % size);
      triangles.faces[at++] = face;
    }
  }
  return triangles;
}

/** True if the diagonal from the second to the fourth corner is better: the other one folds the quad, or is longer. */
function cutsSecondDiagonal(points: Float32Array, corners: Uint32Array, first: number): boolean {
  const a = 4 * corners[first];
  const b = 4 * corners[first + 1];
  const c = 4 * corners[first + 2];
  const d = 4 * corners[first + 3];
  const firstFolds = turnsOver(points, a, b, c, d);
  const secondFolds = turnsOver(points, b, c, d, a);
  if (firstFolds !== secondFolds) return firstFolds;
  return square(points, b, d) < square(points, a, c);
}

/** Whether triangles abc and acd look away from one another: their normals are crosses with the edge ac. */
function turnsOver(p: Float32Array, a: number, b: number, c: number, d: number): boolean {
  const ex = p[c] - p[a];
  const ey = p[c + 1] - p[a + 1];
  const ez = p[c + 2] - p[a + 2];
  const bx = p[b] - p[a];
  const by = p[b + 1] - p[a + 1];
  const bz = p[b + 2] - p[a + 2];
  const dx = p[d] - p[a];
  const dy = p[d + 1] - p[a + 1];
  const dz = p[d + 2] - p[a + 2];
  const x = (by * ez - bz * ey) * (ey * dz - ez * dy);
  const y = (bz * ex - bx * ez) * (ez * dx - ex * dz);
  const z = (bx * ey - by * ex) * (ex * dy - ey * dx);
  return x + y + z < 0;
}

function square(p: Float32Array, a: number, b: number): number {
  return (p[a] - p[b]) ** 2 + (p[a + 1] - p[b + 1]) ** 2 + (p[a + 2] - p[b + 2]) ** 2;
}

/** Numbers edges. The edges from a point to points of larger index lie together, so there is room between numbers. */
export class Edges {
  /** Edge of each corner, from it to the next one. */
  readonly ofCorner: Uint32Array;
  /** Faces of each edge. */
  readonly uses: Uint8Array;
  readonly #first: Uint32Array;
  readonly #upper: Uint32Array;
  readonly #filled: Uint32Array;

  constructor(faces: Faces, points: number) {
    const count = faces.corners.length;
    this.ofCorner = new Uint32Array(count);
    this.uses = new Uint8Array(count);
    this.#upper = new Uint32Array(count);
    this.#filled = new Uint32Array(points);
    this.#first = firsts(faces, points);
    for (let face = 0; face + 1 < faces.starts.length; face++) {
      for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
        const edge = this.#add(faces.corners[corner], faces.corners[nextCorner(faces, face, corner)]);
        this.ofCorner[corner] = edge;
        this.uses[edge] = Math.min(255, this.uses[edge] + 1);
      }
    }
  }

  /** Room for a table by edge. */
  get room(): number {
    return this.uses.length;
  }

  /** The edge between two points, or -1. */
  find(a: number, b: number): number {
    const low = Math.min(a, b);
    const high = Math.max(a, b);
    const first = this.#first[low];
    for (let edge = first; edge < first + this.#filled[low]; edge++) {
      if (this.#upper[edge] === high) return edge;
    }
    return -1;
  }

  #add(a: number, b: number): number {
    const known = this.find(a, b);
    if (known >= 0) return known;
    const low = Math.min(a, b);
    const edge = this.#first[low] + this.#filled[low]++;
    this.#upper[edge] = Math.max(a, b);
    return edge;
  }
}

function firsts(faces: Faces, points: number): Uint32Array {
  const first = new Uint32Array(points + 1);
  for (let face = 0; face + 1 < faces.starts.length; face++) {
    for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
      const low = Math.min(faces.corners[corner], faces.corners[nextCorner(faces, face, corner)]);
      first[low + 1]++;
    }
  }
  for (let point = 0; point < points; point++) first[point + 1] += first[point];
  return first;
}
