// Where the meshes are on the canvas: one large and others small beside it, columns from left to right, or all in one place.

import type { Role } from "../server/protocol";
import type { ViewOptions } from "./api";

/** All meshes, from left to right. */
export const ROLES: Role[] = ["model", "sim", "render"];
/** The tool rail lies over the right side of the canvas. [CSS pixels] */
export const RAIL = 56;
/** Part of the breadth that the large mesh has. */
const LARGE = 0.7;

/** A part of the canvas with the meshes in it; the last is solid. `x` and `y` are its upper left corner. [CSS pixels] */
export interface Column {
  x: number;
  y: number;
  width: number;
  height: number;
  roles: Role[];
}

type Arrangement = Pick<ViewOptions, "roles" | "layout" | "large" | "flat">;

export function columns(options: Arrangement, width: number, height: number): Column[] {
  const { roles } = options;
  const together = options.layout === "over" && !options.flat;
  if (together || roles.length < 2) return [{ x: 0, y: 0, width, height, roles }];
  if (options.layout === "large") return withLarge(roles, largeOf(options), width - RAIL, height);
  const each = (width - RAIL) / roles.length;
  return roles.map((role, index) => ({ x: index * each, y: 0, width: each, height, roles: [role] }));
}

/** The mesh that is large: the wanted one, or else the last that is shown. */
export function largeOf({ roles, large }: Pick<Arrangement, "roles" | "large">): Role {
  return roles.includes(large) ? large : roles[roles.length - 1];
}

/** The large mesh comes first. */
function withLarge(roles: Role[], large: Role, width: number, height: number): Column[] {
  const small = roles.filter((role) => role !== large);
  const x = Math.round(LARGE * width);
  const each = height / small.length;
  const beside = small.map((role, index) => ({ x, y: index * each, width: width - x, height: each, roles: [role] }));
  return [{ x: 0, y: 0, width: x, height, roles: [large] }, ...beside];
}

/** Whether the meshes keep their places. */
export function sameColumns(a: Arrangement, b: Arrangement): boolean {
  const key = (each: Arrangement) => [each.flat, each.layout, largeOf(each), ...each.roles].join();
  return key(a) === key(b);
}

export function columnAt(all: Column[], { x, y }: { x: number; y: number }): Column | undefined {
  return all.find((c) => x >= c.x && x < c.x + c.width && y >= c.y && y < c.y + c.height);
}
