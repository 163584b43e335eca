// Where the meshes are on the canvas: columns from left to right.

import type { Role } from "../server/protocol";
import type { ViewOptions } from "./api";

/** The tool rail lies over the right side of the canvas. [CSS pixels] */
const RAIL = 56;

/** A part of the canvas over its full height, with the meshes in it; the last is solid. [CSS pixels] */
export interface Column {
  x: number;
  width: number;
  height: number;
  roles: Role[];
}

export function columns(options: ViewOptions, width: number, height: number): Column[] {
  const { roles } = options;
  const together = options.layout === "over" && !options.flat;
  if (together || roles.length < 2) return [{ x: 0, width, height, roles }];
  const each = (width - RAIL) / roles.length;
  return roles.map((role, index) => ({ x: index * each, width: each, height, roles: [role] }));
}

/** Whether the meshes keep their places. */
export function sameColumns(a: ViewOptions, b: ViewOptions): boolean {
  return a.flat === b.flat && a.layout === b.layout && a.roles.join() === b.roles.join();
}

export function columnAt(all: Column[], x: number): Column | undefined {
  return all.find((column) => x >= column.x && x < column.x + column.width);
}
