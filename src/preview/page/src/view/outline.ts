// Outlines of elements of a mesh, as paths over the canvas.

import { Vector3, type Camera } from "three";
import type { Outline } from "./api";
import type { Column } from "./layout";
import type { Shapes } from "./mesh/marks";
import { toCanvas } from "./picking";

/** The segments and triangles as a path in a column, as its camera sees them. */
export function outlineOf(column: Column, camera: Camera, { segments, triangles }: Shapes): Outline {
  const { x, y, width, height } = column;
  const place = new Vector3();
  const corner = (numbers: ArrayLike<number>, at: number) => {
    const on = toCanvas(place.fromArray(numbers, at).project(camera), { ...column, x: 0, y: 0 });
    return `${on.x.toFixed(1)} ${on.y.toFixed(1)}`;
  };
  const parts = (numbers: ArrayLike<number>, size: number) =>
    Array.from({ length: numbers.length / (3 * size) }, (_, part) => {
      const corners = Array.from({ length: size }, (_, at) => corner(numbers, 3 * (size * part + at)));
      return `M${corners.join("L")}Z`;
    });
  return { x, y, width, height, path: [...parts(segments, 2), ...parts(triangles, 3)].join("") };
}
