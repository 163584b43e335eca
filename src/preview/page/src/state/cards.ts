// Cards that are selected together, and values that go from card to card.

import type { Fields, Value } from "../server/options";
import type { Stacked } from "../server/protocol";
import type { Garment, Kind } from "./garment";
import { fullName, instanceAt, setsOf, valueAt, type Operator } from "./recipe";
import type { State } from "./state";
import type { Change, Store } from "./store";

/** Selects a card besides others, or takes it out. */
export function toggleCard(store: Store, full: string): void {
  const chosen = new Set(store.state.chosen);
  if (!chosen.delete(full)) chosen.add(full);
  store.update({ chosen, anchor: full });
}

/** Selects all cards from the last one that was clicked. */
export function chooseTo(store: Store, full: string): void {
  const order = store.state.document.stack.map((each) => each.full);
  const [a, b] = [order.indexOf(store.state.anchor ?? full), order.indexOf(full)];
  const [from, to] = a < 0 ? [b, b] : [Math.min(a, b), Math.max(a, b)];
  store.update({ chosen: new Set(order.slice(from, to + 1)) });
}

/** A click without a modifier. It keeps a selection that the card is in. */
export function clickCard(store: Store, full: string): void {
  const chosen = store.state.chosen.has(full) ? store.state.chosen : new Set<string>();
  store.update({ chosen, anchor: full });
}

/** The selected operators of the kind of one of them, or else it alone; with the twins of all. */
export function together(state: State, operator: Stacked): Stacked[] {
  const { chosen, document } = state;
  const isAlone = !chosen.has(operator.full);
  const all = isAlone ? [operator] : document.stack.filter(({ full, kind }) => kind === operator.kind && chosen.has(full));
  return [...new Set([...all, ...all.flatMap((each) => twinOf(state, each) ?? [])])];
}

/** The operator of the same kind on the other side of a symmetric garment; it itself if it has both sides. Without symmetry there
 *  is none. */
export function twinOf({ settings, garment, document }: State, operator: Stacked): Stacked | undefined {
  const twins = settings.symmetric ? garment?.mirror?.twins : undefined;
  if (!garment || !twins) return undefined;
  const sets = (each: Stacked) => setsOf(document.merged, each, garment.kinds);
  const others = sets(operator).map((name) => twins[name] ?? "");
  const isTwin = (each: Stacked) => each.kind === operator.kind && sets(each).sort().join() === others.sort().join();
  return others.length > 0 ? document.stack.find(isTwin) : undefined;
}

/** The keys of an option in all cards that are edited together. */
export function keysWith(state: State, key: string): string[] {
  const at = key.lastIndexOf(".");
  const operator = state.document.stack.find(({ full }) => full === key.slice(0, at));
  return operator ? together(state, operator).map(({ full }) => full + key.slice(at)) : [key];
}

/** Whether cards that are edited together differ in an option. */
export function isMixed(state: State, key: string, fallback: Value): boolean {
  const keys = keysWith(state, key);
  const text = (each: string) => JSON.stringify(valueAt(state.document.merged, each) ?? fallback);
  return keys.length > 1 && keys.some((each) => text(each) !== text(keys[0]));
}

/** The values of an operator that others may take over: all but its sets and its switch. */
export function valuesOf(state: State, operator: Operator): Fields {
  const fields = instanceAt(state.document.merged, operator);
  const options = sharedOptions(kindOf(state.garment, operator));
  return Object.fromEntries(options.map(({ key, default: usual }) => [key, fields?.[key] ?? usual]));
}

function kindOf(garment: Garment | null, { kind }: Operator): Kind | undefined {
  return garment?.kinds.find(({ name }) => name === kind);
}

function sharedOptions(kind: Kind | undefined): Kind["options"] {
  return (kind?.options ?? []).filter(({ key, domain }) => key !== "enabled" && domain.type !== "sets");
}

/** Gives values to an operator and to those that are selected with it, as one step. */
export function giveValues(store: Store, operator: Stacked, fields: Fields): void {
  const options = sharedOptions(kindOf(store.state.garment, operator));
  const changes = together(store.state, operator).flatMap((each) =>
    options.filter(({ key }) => key in fields).map(({ key, default: usual }): Change => {
      const full = `${fullName(each)}.${key}`;
      const below = valueAt(store.state.document.upstream, full) ?? usual;
      return { key: full, value: fields[key], isBack: fields[key] === below };
    }),
  );
  store.setAll(changes);
}

export function copyValues(store: Store, operator: Stacked): void {
  store.update({
    copied: { kind: operator.kind, fields: valuesOf(store.state, operator) },
    spoken: `The values of ${operator.full} are copied`,
  });
}

/** Why values cannot be pasted into an operator, or null. */
export function pasteProblem({ copied }: State, { kind }: Stacked): string | null {
  if (!copied) return "copy the values of a card first";
  return copied.kind === kind ? null : `the copied values are of a ${copied.kind}`;
}

export function pasteValues(store: Store, operator: Stacked): void {
  const { copied } = store.state;
  const problem = pasteProblem(store.state, operator);
  if (problem || !copied) return store.toast({ text: `Nothing is pasted: ${problem}` });
  giveValues(store, operator, copied.fields);
  store.update({ spoken: `The values are pasted into ${together(store.state, operator).map(({ full }) => full).join(", ")}` });
}
