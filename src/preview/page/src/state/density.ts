// Finer here: selected faces join the set whose triangles are smaller, or leave it.

import { fitting, valueAt } from "./recipe";
import { shortName, type Selection } from "./selection";
import type { State } from "./state";
import type { Store } from "./store";

const DENSITY = "sim.density";

/** The density: a set, or painted weights, with which no set can be combined. */
export function densityOf({ document, garment }: State): { name: string; isPainted: boolean } {
  const name = String(valueAt(document.merged, DENSITY) ?? "");
  return { name, isPainted: name.startsWith("painted(") || fitting(garment?.primvars ?? [], "weights").some((primvar) => primvar.name === name) };
}

/** Gives the selected faces smaller triangles, or again those of their surroundings. */
export function setFiner(store: Store, finer: boolean): void {
  const refuse = (text: string) => (store.toast({ text }), null);
  const of = ({ kind }: Selection) => {
    const { name, isPainted } = densityOf(store.state);
    if (store.state.connection !== "open") return null;
    if (kind !== "face") return refuse("Finer and coarser: select faces first");
    if (isPainted) return refuse(paintedHint(name));
    return name || finer ? name : refuse("No faces are finer yet");
  };
  store.selector.combine(finer ? "add" : "remove", of, (expression) => {
    store.selector.end();
    store.update({ isSelecting: false });
    store.set(DENSITY, expression);
  });
}

export const paintedHint = (name: string) => `The density is painted (${shortName(name)}): choose none for it in the panel first`;
