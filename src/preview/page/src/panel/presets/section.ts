// The cross-section of the cloth through a seam or a fold, as the render mesh has it. Normals are up.

import type { Fields } from "../../server/options";

export type Point = [x: number, y: number];

export interface Section {
  /** Control points of the cloth's cubic B-spline, which Catmull-Clark has there: left to right for a seam, around the fold
   *  and back for a fold. [mesh units] */
  cloth: Point[];
  /** The surface without the operator, as a line. */
  before: [Point, Point];
  /** Lengths that are measured, with the ends of their arrows. */
  measures: { key: string; from: Point; to: Point }[];
}

/** Lines of each side of a seam as shares of its width there, as in `render/seam/profile.rs`. */
const LINES = [1 / 3, 2 / 3, 1, 4 / 3];
/** Smallest share of the width on one side, as in `render/seam/options.rs`. */
const LEAST_SIDE = 0.05;
/** Smallest radius of a turn, in half thicknesses, as in `render/fold.rs`. */
const LEAST_TURN = 0.4;
/** Length of the second layer that is drawn, in thicknesses. The faces of the fold have their own. */
const HEM_LENGTH = 7;
/** Part of the drawing that the second layer takes. */
const HEM_SHARE = 0.7;

const number = (value: unknown): number => (typeof value === "number" && Number.isFinite(value) ? value : 0);

/** `auto` is the width that 0 stands for. */
export function seamSection(fields: Fields, auto: number): Section {
  const width = number(fields.width) || auto;
  // A crease is a line of the surface as it is.
  const [offset, depth] = fields.crease === true ? [0, 0] : [number(fields.normalOffset), number(fields.depth)];
  const share = Math.min(1 - LEAST_SIDE, Math.max(LEAST_SIDE, 0.5 * (1 - number(fields.asymmetry))));
  const [left, right] = [width * share, width * (1 - share)];
  const heights = [(1 - LINES[0]) * offset + depth, 0, 0, 0];
  const side = (length: number): Point[] => LINES.map((line, i) => [line * length, heights[i]]);
  const profile: Point[] = [...side(-left).reverse(), [0, offset], ...side(right)];
  const centres = rowCentres(fields, width);
  const rows = centres.flatMap((centre, i) => {
    // Rows that are close end midway.
    const [from, to] = [centres[i - 1] ?? -Infinity, centres[i + 1] ?? Infinity].map((other) => (other + centre) / 2);
    return profile.map(([x, y]): Point => [centre + x, y]).filter(([x]) => x > from && x < to);
  });
  const first = centres.at(-1) ?? 0;
  const flat = width / 4;
  const ends = [Math.min(0, rows[0][0]) - flat, Math.max(0, rows[rows.length - 1][0]) + flat];
  const lines: Point[] = [[ends[0], 0], ...rows, [ends[1], 0]];
  const cloth = [0, 1].map((axis) => fitted(lines.map((point) => point[axis]), lines.map(() => true)));
  const before: Section["before"] = [[ends[0], 0], [ends[1], 0]];
  const measures = [{ key: "width", from: [first - left, 0] as Point, to: [first + right, 0] as Point }];
  if (offset !== 0) measures.push({ key: "normalOffset", from: [first, 0], to: [first, offset] });
  return { cloth: joined(cloth), before, measures };
}

/** Rows that are drawn on a side at most. */
const MOST_ROWS = 6;

/** Places of the rows across, from left to right. The edges are at 0. */
function rowCentres(fields: Fields, width: number): number[] {
  const gap = number(fields.rowGap) || 1.5 * width;
  const count = Math.min(MOST_ROWS, Math.max(1, number(fields.rows)));
  const away = Array.from({ length: count }, (_, i) => number(fields.offset) + i * gap);
  const signs = [-1, 1].filter((sign) => fields.side !== (sign < 0 ? "right" : "left"));
  return [...new Set(signs.flatMap((sign) => away.map((distance) => sign * distance)))].sort((a, b) => a - b);
}

/** `auto` is the thickness that 0 stands for, `reach` the length of the second layer. The border of the cloth is at 0. */
export function foldSection(fields: Fields, auto: number, reach?: number): Section {
  const thickness = number(fields.thickness) || auto;
  const y = (fields.side === "outer" ? 1 : -1) * thickness;
  // A closed layer goes as far as the cloth does.
  const length = reach === undefined ? HEM_LENGTH * thickness : Math.max(reach, 3 * thickness);
  const far = -length / HEM_SHARE;
  const end = fields.closed === true ? far : -length;
  // A support loop is as far from the fold as the layers are from one another. The surface stays in place, and the limit of
  // the layer is at the thickness.
  const xs = [far, 0.6 * end, 0.4 * end, -thickness, 0, 0, -thickness, 0.4 * end, 0.6 * end, end];
  const [border, turn] = [xs.length / 2, Math.max(LEAST_TURN, number(fields.turn ?? 1))];
  const ys = fitted(xs.map((_, i) => (i < border ? 0 : i === border ? turn * y : y)), xs.map((_, i) => i >= border));
  const cloth = joined([xs, ys]);
  const at = 0.75 * end;
  return { cloth, before: [[far, 0], [0, 0]], measures: [{ key: "thickness", from: [at, Math.min(0, y)], to: [at, Math.max(0, y)] }] };
}

const joined = ([xs, ys]: number[][]): Point[] => xs.map((x, i) => [x, ys[i]]);

/** The points of a curve at its controls. Both ends are on theirs. */
export function knots(controls: Point[]): Point[] {
  const last = controls.length - 1;
  const at = (i: number, axis: number) => (controls[i - 1][axis] + 4 * controls[i][axis] + controls[i + 1][axis]) / 6;
  return controls.map((point, i) => (i === 0 || i === last ? point : [at(i, 0), at(i, 1)]));
}

/** A curve of control points as a path of Bézier curves. */
export function smoothPath(controls: Point[]): string {
  const on = knots(controls);
  const between = (i: number, part: number): Point => [
    controls[i][0] + (controls[i + 1][0] - controls[i][0]) * part,
    controls[i][1] + (controls[i + 1][1] - controls[i][1]) * part,
  ];
  const text = (...points: Point[]) => points.map((point) => point.map(rounded).join(" ")).join(" ");
  const curves = on.slice(1).map((point, i) => `C${text(between(i, 1 / 3), between(i, 2 / 3), point)}`);
  return `M${text(on[0])}${curves.join("")}`;
}

const rounded = (value: number): string => String(Number(value.toFixed(3)));

/** Controls of a curve that goes through `values` where it fits, and are the values elsewhere and at both ends. */
function fitted(values: number[], fits: boolean[]): number[] {
  const last = values.length - 1;
  const isFree = (i: number) => fits[i] && i > 0 && i < last;
  // Elimination from the first to the last, then back: neighbours of a control that fits have a share of 1 to 4.
  const [shares, sums] = [[0], [values[0]]];
  for (let i = 1; i <= last; i++) {
    const pivot = 4 - shares[i - 1];
    shares.push(isFree(i) ? 1 / pivot : 0);
    sums.push(isFree(i) ? (6 * values[i] - sums[i - 1]) / pivot : values[i]);
  }
  const controls = [...sums];
  for (let i = last - 1; i >= 0; i--) controls[i] = sums[i] - shares[i] * controls[i + 1];
  return controls;
}
