import type { Matrix4 } from "three";

/** Moves a picture by a part of a pixel. Sizes are of the view in device pixels. */
export function shifted(projection: Matrix4, [x, y]: [number, number], width: number, height: number): void {
  const { elements } = projection;
  const isPerspective = elements[15] === 0;
  elements[isPerspective ? 8 : 12] += (2 * x) / width;
  elements[isPerspective ? 9 : 13] += (2 * y) / height;
}
