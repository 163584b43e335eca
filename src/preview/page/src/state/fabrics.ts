// Fabrics of the recipe: added, renamed, removed.

import type { Fields } from "../server/options";
import { reveal } from "./operators";
import { fullName, instanceAt, uniqueName, valueAt, withInstance, withValue, type Instance } from "./recipe";
import type { Store } from "./store";

const GARMENT = "cloth.fabric";

/** A new fabric of a face set, or of the whole garment. */
export function addFabric(store: Store, set: string | null): void {
  const { merged } = store.state.document;
  const name = uniqueName(merged, "fabric", set ?? "fabric");
  const fabric: Instance = { kind: "fabric", name };
  const below = String(valueAt(merged, GARMENT));
  const preset = below in (store.state.garment?.fabrics ?? {}) ? below : null;
  const fields: Fields = { ...(set === null ? {} : { faces: [set] }), ...(preset ? { preset } : {}) };
  store.edit((options) => {
    const changed = withInstance(options, fabric, fields);
    return set === null ? withValue(changed, GARMENT, name) : changed;
  });
  reveal(store, fullName(fabric));
}

export function renameFabric(store: Store, fabric: Instance, name: string): void {
  const renamed = { ...fabric, name };
  store.edit((options) => {
    const fields = { ...instanceAt(options, fabric) };
    const moved = withInstance(withInstance(options, fabric, undefined), renamed, fields);
    return valueAt(options, GARMENT) === fabric.name ? withValue(moved, GARMENT, name) : moved;
  });
  if (store.state.open.has(fullName(fabric))) store.openCard(fullName(renamed), true);
}

/** Removes a fabric. A garment that is of it gets the fabric below. */
export function deleteFabric(store: Store, fabric: Instance): void {
  const preset = String(valueAt(store.state.document.merged, `${fullName(fabric)}.preset`) ?? "cotton");
  store.edit((options) => {
    const without = withInstance(options, fabric, undefined);
    return valueAt(options, GARMENT) === fabric.name ? withValue(without, GARMENT, preset) : without;
  });
}
