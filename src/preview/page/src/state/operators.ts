// Changes of the stack: operators that are added, copied, renamed, moved, removed.

import type { Fields, Options } from "../server/options";
import { automaticMeasure, type Garment, type Kind } from "./garment";
import { fullName, listOf, instanceAt, uniqueName } from "./recipe";
import { withInstance, withValue, ORDER, type Operator } from "./recipe";
import type { Selection } from "./selection";
import type { Store } from "./store";
import { isTyping } from "./typing";

/** Depth of a new seam, as a share of its width. */
const GROOVE = 0.2;

/** A new operator of a set, named after it or after `wish`. The camera flies to it if it is out of view. */
export function addOperator(store: Store, kind: Kind, set: string, wish = set): Operator {
  const { document, garment } = store.state;
  const name = uniqueName(document.merged, kind.name, wish);
  const fields: Fields = { [kind.sets.field]: [set] };
  if (kind.name === "seam") fields.normalOffset = -Number((GROOVE * automaticMeasure(kind, garment)).toPrecision(2));
  const operator = { kind: kind.name, name };
  insert(store, operator, fields);
  store.view?.reveal(set);
  return operator;
}

/** The kind of operator that takes selected elements. */
export function kindFor(selection: Selection | null, garment: Garment | null): Kind | undefined {
  return garment?.kinds.find(({ sets }) => sets.of === selection?.kind);
}

/** A new operator of the selection, which ends it. */
export function addFromSelection(store: Store): void {
  store.selector.use((selection) => {
    const kind = kindFor(selection, store.state.garment);
    if (!kind || store.state.connection !== "open") return;
    const { expression } = selection;
    const isWord = /^[\w.]+$/.test(expression);
    store.selector.end();
    store.update({ isSelecting: false });
    const operator = addOperator(store, kind, expression, isWord ? expression : kind.name);
    store.made.note(operator, selection);
    store.view?.reveal(selection.elements);
  });
}

/** A copy with the same sets, whose other values are then changed, such as for a second row of stitches. */
export function duplicateOperator(store: Store, operator: Operator): void {
  const { document } = store.state;
  const name = uniqueName(document.merged, operator.kind, operator.name);
  insert(store, { kind: operator.kind, name }, { ...instanceAt(document.merged, operator) });
}

/** A new operator is the last one. Its card opens alone, to be named. */
function insert(store: Store, operator: Operator, fields: Fields): void {
  const { merged, stack } = store.state.document;
  const list = listOf(merged);
  const full = fullName(operator);
  // Without a list, the order is by name.
  const before = list.length > 0 ? list : stack.map((each) => each.full);
  store.edit((options) => withValue(withInstance(options, operator, fields), ORDER, [...before, full]));
  store.update({ open: new Set([full]), chosen: new Set(), anchor: full, naming: full });
  show(full);
}

export function isUpstream(store: Store, operator: Operator): boolean {
  return instanceAt(store.state.document.upstream, operator) !== undefined;
}

/** Removes an operator that was added here, and turns one of the garment off, since its layer is not ours. */
export function deleteOperator(store: Store, operator: Operator): void {
  if (isUpstream(store, operator)) {
    setEnabled(store, operator, false);
    store.toast({ text: `“${operator.name}” is authored in the garment; turned off` });
    return;
  }
  const full = fullName(operator);
  const without = (list: string[]) => list.filter((each) => each !== full);
  store.edit((options) => withListed(withInstance(options, operator, undefined), without));
  store.highlight(null);
}

export function renameOperator(store: Store, operator: Operator, name: string): void {
  const renamed = { kind: operator.kind, name };
  const [before, after] = [fullName(operator), fullName(renamed)];
  store.edit((options) => {
    const fields = { ...instanceAt(options, operator) };
    const moved = withInstance(withInstance(options, operator, undefined), renamed, fields);
    return withListed(moved, (list) => list.map((each) => (each === before ? after : each)));
  });
  const renamedIn = (cards: ReadonlySet<string>) => new Set([...cards].map((each) => (each === before ? after : each)));
  store.update({ open: renamedIn(store.state.open), chosen: renamedIn(store.state.chosen) });
}

/** The options with another list of operators, if they have one. */
function withListed(options: Options, change: (list: string[]) => string[]): Options {
  const list = options.render?.operators;
  return Array.isArray(list) ? withValue(options, ORDER, change(list)) : options;
}

export function setEnabled(store: Store, operator: Operator, on: boolean): void {
  store.set(`${fullName(operator)}.enabled`, on);
}

/** Moves an operator to a place of the stack, from 0. */
export function moveOperator(store: Store, full: string, to: number): void {
  const { stack } = store.state.document;
  const from = stack.findIndex((each) => each.full === full);
  if (from < 0 || to < 0 || to >= stack.length || from === to) return;
  const others = stack.filter((each) => each.full !== full);
  const moved = [...others.slice(0, to), stack[from], ...others.slice(to)].map((each) => ({ ...each, listed: true }));
  const order = moved.map((each) => each.full);
  store.edit((options) => withValue(options, ORDER, order));
  // A second move may come before the server's answer.
  store.update({ document: { ...store.state.document, stack: moved } });
  store.update({ spoken: `${full} is now ${to + 1} of ${order.length}` });
}

/** Frames in which the server should have answered an edit. */
const FRAMES = 120;

/** Opens a card and brings it into sight. The server's answer has the card of a new operator. */
export function reveal(store: Store, full: string): void {
  store.openCard(full, true);
  show(full);
}

/** Scrolls to a card and focuses it. A field that the artist types in meanwhile keeps the focus. */
export function show(full: string, frames = FRAMES): void {
  requestAnimationFrame(() => {
    const card = document.querySelector<HTMLElement>(`[data-card="${CSS.escape(full)}"]`);
    if (!card && frames > 0) return show(full, frames - 1);
    // The head stays in sight of a card that is higher than the panel.
    const isHigh = (card?.offsetHeight ?? 0) > (card?.closest(".recipe-scroll")?.clientHeight ?? 0) / 2;
    card?.scrollIntoView({ block: isHigh ? "start" : "nearest", behavior: "smooth" });
    if (isTyping(document.activeElement)) return;
    (card?.querySelector<HTMLElement>(".card-rename") ?? card)?.focus({ preventScroll: true });
  });
}
