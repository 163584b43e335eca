// Where the meshes are on the canvas: one large and others small beside it, columns from left to right, or all in one place.
// Flat panels of the large mesh have the same mesh in space beside them.

import type { Role } from "../server/protocol";
import type { Box, ViewOptions } from "./api";

/** All meshes, from left to right. */
export const ROLES: Role[] = ["model", "sim", "render"];
/** The tool rail lies over the right side of the canvas. [CSS pixels] */
export const RAIL = 56;
/** Part of the breadth that the large mesh has, and that its flat panels have beside it. */
const LARGE = 0.7;
const PANELS = 0.56;

/** A part of the canvas with the meshes in it; the last is solid. `x` and `y` are its upper left corner. [CSS pixels] */
export interface Column extends Box {
  roles: Role[];
  /** Whether it shows the UV plane. */
  flat: boolean;
  /** Of a split view: whether it shows the meshes that were kept, and the part of the breadth that is seen of it. */
  split?: { isKept: boolean; from: number; to: number };
}

type Arrangement = Pick<ViewOptions, "roles" | "layout" | "large" | "flat">;

export function columns(options: Arrangement, width: number, height: number): Column[] {
  const { roles, flat, layout } = options;
  if (layout === "large" && flat && roles.length > 0) return withPanels(largeOf(options), width - RAIL, height);
  if ((layout === "over" && !flat) || roles.length < 2) return [{ x: 0, y: 0, width, height, roles, flat }];
  if (layout === "large") return withLarge(roles, largeOf(options), width - RAIL, height);
  const each = (width - RAIL) / roles.length;
  return roles.map((role, index) => ({ x: index * each, y: 0, width: each, height, roles: [role], flat }));
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
  const breadth = width - x;
  const beside = small.map((role, at) => ({ x, y: at * each, width: breadth, height: each, roles: [role], flat: false }));
  return [{ x: 0, y: 0, width: x, height, roles: [large], flat: false }, ...beside];
}

/** A mesh as flat panels, and in space. */
function withPanels(role: Role, width: number, height: number): Column[] {
  const x = Math.round(PANELS * width);
  const roles = [role];
  return [
    { x: 0, y: 0, width: x, height, roles, flat: true },
    { x, y: 0, width: width - x, height, roles, flat: false },
  ];
}

/** Each column with the meshes that were kept on the left of a line, and those of now on its right. */
export function splitAt(all: Column[], share: number): Column[] {
  return all.flatMap((column) => [
    { ...column, split: { isKept: true, from: 0, to: share } },
    { ...column, split: { isKept: false, from: share, to: 1 } },
  ]);
}

/** What is seen of a column. */
export function windowOf({ x, y, width, height, split }: Column): Pick<Column, "x" | "y" | "width" | "height"> {
  const { from, to } = split ?? { from: 0, to: 1 };
  return { x: x + from * width, y, width: (to - from) * width, height };
}

export function aspectOf({ width, height }: Column): number {
  return width / height;
}

/** Whether the meshes keep their places. */
export function sameColumns(a: Arrangement, b: Arrangement): boolean {
  const key = (each: Arrangement) => [each.flat, each.layout, largeOf(each), ...each.roles].join();
  return key(a) === key(b);
}

export function columnAt(all: Column[], { x, y }: { x: number; y: number }): Column | undefined {
  return all.find((column) => {
    const part = windowOf(column);
    return x >= part.x && x < part.x + part.width && y >= part.y && y < part.y + part.height;
  });
}
