// A cloth and bodies under it.

import { writeFileSync } from "node:fs";

/** A cloth of 4 by 4 quads, 4 wide. */
export const SHEET = `
    def Mesh "model"
    {
        point3f[] points = [${Array.from({ length: 25 }, (_, i) => `(${i % 5}, ${Math.floor(i / 5)}, 0)`).join(", ")}]
        int[] faceVertexCounts = [${Array(16).fill(4).join(", ")}]
        int[] faceVertexIndices = [${Array.from({ length: 16 }, (_, i) => i + Math.floor(i / 4)).flatMap((at) => [at, at + 1, at + 6, at + 5]).join(", ")}]
    }`;

/** A box from one corner to the other. */
export function body(path, least, most) {
  const corners = Array.from({ length: 8 }, (_, i) => [0, 1, 2].map((axis) => ((i >> axis) & 1 ? most : least)[axis]));
  const faces = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
  const points = corners.map((corner) => `(${corner.join(", ")})`).join(", ");
  const mesh = `point3f[] points = [${points}]\n int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]\n int[] faceVertexIndices = [${faces.join(", ")}]`;
  writeFileSync(path, `#usda 1.0\n(\n upAxis = "Y"\n metersPerUnit = 0.01\n)\ndef Mesh "body"\n{\n uniform token subdivisionScheme = "none"\n ${mesh}\n}\n`);
  return path;
}
