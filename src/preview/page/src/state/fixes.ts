// Warnings whose cure is a value: an operator that has less than it asks for is asked for what it has.

import { automaticMeasure, MEASURE, type Finding } from "./garment";
import { valueAt } from "./recipe";
import type { State } from "./state";
import type { Change } from "./store";

/** The options that are made less by each code. */
const CURES: Record<string, string[]> = {
  "narrow-seam": ["width", "normalOffset"],
  "shallow-seam": ["normalOffset"],
  "thin-layer": ["thickness"],
};
/** What is left is rounded down to so many parts of a power of ten. */
const PARTS = 100;

/** The values that end a warning; none where it takes more than that. */
export function cureOf(state: State, { code, place, problem, amount }: Finding): Change[] {
  const operator = state.document.stack.find(({ full }) => full === place);
  // Rows that do not fit have a cure of their own.
  const isAll = code !== "narrow-seam" || problem.startsWith("narrower");
  const isLess = isAll && amount !== undefined && amount > 0 && amount < 1;
  if (!operator || !isLess) return [];
  return (CURES[code] ?? []).flatMap((field) => {
    const key = `${place}.${field}`;
    const asked = Number(valueAt(state.document.merged, key) ?? 0) || (MEASURE[operator.kind] === field ? automatic(state, key) : 0);
    return asked === 0 ? [] : [{ key, value: lowered(asked * amount) }];
  });
}

function automatic({ garment, products }: State, key: string): number {
  const kind = garment?.kinds.find(({ name }) => key.startsWith(`${name}.`));
  return products.render?.lengths[key] ?? (kind ? automaticMeasure(kind, garment) : 0);
}

/** Towards 0, to two figures. */
function lowered(value: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.abs(value)));
  return Number(((Math.trunc((PARTS * value) / power) / PARTS) * power).toPrecision(4));
}
