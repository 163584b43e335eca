// Presets of seams and folds: those of the program, and those in a file beside the garment.

import type { Fields, KindName } from "../server/options";
import type { PresetSavedMessage, PresetsMessage } from "../server/protocol";
import type { Store } from "./store";

export interface Preset {
  name: string;
  values: Fields;
  isSaved: boolean;
}

/** The presets of a kind, those of the program first. */
export function presetsOf(presets: PresetsMessage | null, kind: KindName): Preset[] {
  const from = (of: PresetsMessage["saved"] | undefined, isSaved: boolean) =>
    Object.entries(of?.[kind] ?? {}).map(([name, values]) => ({ name, values, isSaved }));
  return [...from(presets?.builtIn, false), ...from(presets?.saved, true)];
}

/** The preset that values are of, the user's own before one of the program. */
export function presetOf(presets: Preset[], values: Fields): Preset | undefined {
  const same = ({ values: of }: Preset) => Object.entries(of).every(([key, value]) => isSame(value, values[key]));
  return presets.filter(same).at(-1);
}

/** Numbers of the recipe are 32-bit. */
function isSame(a: unknown, b: unknown): boolean {
  return typeof a === "number" && typeof b === "number" ? Math.fround(a) === Math.fround(b) : a === b;
}

export function savePreset(store: Store, kind: KindName, name: string, values: Fields): void {
  store.send({ type: "preset", kind, name, values });
}

/** Takes a saved preset out. It can be put back, since no undo of the recipe does so. */
export function removePreset(store: Store, kind: KindName, { name, values }: Preset): void {
  store.send({ type: "preset", kind, name, values: null });
  const act = () => savePreset(store, kind, name, values);
  store.toast({ text: `The preset “${name}” is removed`, action: { label: "Put back", act } });
}

/** Says how it went, but for a removal, which was announced at once. */
export function notePreset(store: Store, { name, file, fault, removed }: PresetSavedMessage): void {
  if (fault) store.toast({ text: `“${name}” is not changed: ${fault.place} ${fault.text}. ${fault.remedy}` });
  else if (!removed) store.toast({ text: `The preset “${name}” is in ${file}` });
}
