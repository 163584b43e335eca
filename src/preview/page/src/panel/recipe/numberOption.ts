// A number of the recipe in the unit of the panel, for the controls that set it: of cards, and in the view.

import type { Domain, Option } from "../../server/protocol";
import { keysWith } from "../../state/cards";
import { automaticLength } from "../../state/garment";
import { fabricValue, valueAt } from "../../state/recipe";
import type { State } from "../../state/state";
import type { Store } from "../../state/store";
import { lengthUnit, neat, niceStep, snapped, unitOf } from "../controls/numbers";
import type { Range } from "../controls/Slider";

export interface NumberOption {
  value: number;
  /** The number that 0 stands for, if it does. */
  auto: number | null;
  unit: string;
  /** Metres in one of the unit, of lengths. */
  metres: number | null;
  /** Mesh units in one of the unit, of lengths; else 1. */
  size: number;
  range: Range;
}

/** Null of what is not a number. */
export function numberOption({ garment, document, products }: State, option: Option, full: string): NumberOption | null {
  // Lengths are in the unit of the panel here, and in mesh units outside.
  const isLength = option.domain.type === "length";
  const { metres, size } = isLength ? lengthUnit(garment) : { metres: 1, size: 1 };
  const range = rangeOf(option.domain, (garment?.meanEdge ?? 1) / size);
  if (!range) return null;
  const used = products.sim?.lengths[full] ?? products.render?.lengths[full];
  const length = used ?? fabricValue(document.merged, garment, full) ?? automaticLength(option.domain, garment);
  return {
    value: neatly(Number(valueAt(document.merged, full) ?? option.default) / size, size),
    auto: length === null ? null : length / size,
    unit: unitOf(option.unit, garment),
    metres: isLength || option.unit === "m" ? metres : null,
    size,
    range,
  };
}

/** Numbers in mesh units stay as they are. */
function neatly(number: number, size: number): number {
  return size === 1 ? number : neat(number);
}

/** Sets a number in all cards that are edited together. */
export function setNumber(store: Store, option: Option, full: string, size: number, typed: number, how: "step" | "continuous"): void {
  const value = neatly(typed * size, size);
  // The value without the edits of the page. Typing it removes the edit.
  const below = (key: string) => valueAt(store.state.document.upstream, key) ?? option.default;
  const keys = keysWith(store.state, full);
  store.setAll(keys.map((key) => ({ key, value, isBack: how === "step" && value === below(key) })), how);
}

/** The usual range of a number, with a step that can be seen; null of what is not a number. */
function rangeOf(domain: Domain, meanEdge: number): Range | null {
  switch (domain.type) {
    case "whole":
      return { least: 0, most: domain.usual, step: 1, fine: 1 };
    case "number":
      return { least: domain.usual[0], most: domain.usual[1], step: neat(domain.step), fine: neat(domain.step / 10) };
    case "length": {
      const [least, most] = domain.usual.map((share) => share * meanEdge);
      const step = niceStep(most - least);
      return { least: snapped(least, step), most: snapped(most, step), step, fine: neat(step / 10) };
    }
    default:
      return null;
  }
}

/** The nearest value that the option takes. A slider's end is not a limit. */
export function clamped(domain: Domain, typed: number): number {
  switch (domain.type) {
    case "whole":
      return Math.min(domain.most, Math.max(0, Math.round(typed)));
    case "number":
      if (domain.orZero && typed <= 0) return Math.max(typed, Math.min(domain.least, 0));
      return Math.min(domain.most ?? Infinity, Math.max(domain.least, typed));
    case "length":
      return domain.usual[0] < 0 ? typed : Math.max(0, typed);
    default:
      return typed;
  }
}
