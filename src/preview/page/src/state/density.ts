// Finer here: selected faces join the set whose triangles are smaller, or leave it.

import { fitting, valueAt } from "./recipe";
import type { State } from "./state";
import type { Store } from "./store";

const DENSITY = "sim.density";

/** The density: a set, or painted weights, with which no set can be combined. */
export function densityOf({ document, garment }: State): { name: string; isPainted: boolean } {
  const name = String(valueAt(document.merged, DENSITY) ?? "");
  return { name, isPainted: fitting(garment?.primvars ?? [], "weights").some((primvar) => primvar.name === name) };
}

/** Gives the selected faces smaller triangles, or again those of their surroundings. */
export function setFiner(store: Store, finer: boolean): void {
  store.selector.use(({ kind, expression }) => {
    if (store.state.connection !== "open") return;
    const { name, isPainted } = densityOf(store.state);
    if (kind !== "face") return store.toast({ text: "Finer and coarser: select faces first" });
    if (isPainted) return store.toast({ text: paintedHint(name) });
    store.selector.end();
    store.update({ isSelecting: false });
    store.set(DENSITY, changed(name, expression, finer));
  });
}

export const paintedHint = (name: string) => `The density is painted (${name}): choose none for it in the panel first`;

function changed(before: string, faces: string, finer: boolean): string {
  if (!before || before === faces) return finer ? faces : "";
  return `${before} ${finer ? "+" : "-"} ${/^[\w.]+$|^\w+\([^()]*\)$/.test(faces) ? faces : `(${faces})`}`;
}
