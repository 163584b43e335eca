// Keys of the whole page.

import type { Before, Role } from "../server/protocol";
import { openBuild } from "./build";
import { setFiner } from "./density";
import { addFromSelection } from "./operators";
import { WAYS } from "./selection";
import type { Store } from "./store";
import { isTyping } from "./typing";
import type { Side } from "../view/api";
import { largeOf, ROLES } from "../view/layout";

export const KEYS: [string, string][] = [
  ["Ctrl Z", "Undo"],
  ["Ctrl Shift Z", "Redo, also Ctrl Y"],
  ["C", "Hold to see the garment before the last change"],
  ["Shift C", "Hold to see it as it was saved, or else opened"],
  ["X", "Split the view: what is shown now stays on the left, edits go on on the right. While C is held, what C shows stays"],
  ["Ctrl S", "Save"],
  ["Ctrl B", "Build what is saved"],
  ["Space", "Play the cache, or pause; with , and . a frame back and on"],
  ["F", "Frame what is marked, or everything"],
  ["[ ]", "The previous and the next place of the marked warning"],
  ["W", "Edges of the mesh"],
  ["1 2 3", "Show or hide model, simulation mesh, render mesh"],
  ["Shift 1 2 3", "Show one of them alone, and again all"],
  ["I", "Show the panel at the pointer or the selected faces alone, and again all"],
  ["G", "Make the next mesh the large one"],
  ["4 5 6 7 8", "Look from the front, the side, the back, the top, at three quarters"],
  ["Alt ↑ ↓", "Move the focused card in the stack"],
  ["Ctrl Click", "On the head of a card: select it, to set values in several; with Shift all up to it; also with Space"],
  ["Ctrl C V", "Copy the values of the focused card, paste them into it or into all selected cards"],
  ["Shift ↑ ↓", "Ten steps at a time on a slider or in a number field"],
  ["Shift Drag", "On a slider or a number: a tenth of the way"],
  ["Drag", "Turn the view; with the right button or Shift, pan"],
  ["Wheel", "Zoom to the pointer"],
  ["Y", "Select and edit both sides of a symmetric garment at once, or one"],
  ["Click", "Select the edge or the face of the model there, on any mesh; with Shift add, with Alt take away, with Ctrl add the path to it"],
  ["L", "Select the whole border, seam or loop of an edge, again: straight on; the whole UV shell of a face"],
  ["M", "Select all faces with the material of the selected ones"],
  ["B", "Select the border of the selected faces"],
  ["+ −", "Select one row of faces more or less around the selection"],
  ["N", "New seam along the selected edges, new fold of the selected faces"],
  ["D", "Smaller triangles on the selected faces; with Shift again larger ones"],
  ["P", "Paint the density, the thickness of folds, pins; drag, with Alt take away, with Shift smooth; [ and ] change the radius"],
  ["E", "Type the selection as an expression"],
  ["Esc", "End a mark, show all panels, end the selection, close what is open"],
  ["?", "This list"],
];

export function installKeys(store: Store): void {
  addEventListener("keydown", (event) => {
    if (document.querySelector("dialog[open]")) return;
    if (event.ctrlKey || event.metaKey) withControl(store, event);
    else if (!event.altKey && !isTyping(event.target)) plain(store, event);
  });
  const endCompare = () => isComparing && compare(store, null);
  addEventListener("keyup", ({ key }) => key.toLowerCase() === "c" && endCompare());
  addEventListener("blur", endCompare);
}

function withControl(store: Store, event: KeyboardEvent): void {
  const key = event.key.toLowerCase();
  if (key === "s") {
    event.preventDefault();
    if (store.state.connection === "open" && store.state.garment) store.update({ dialog: "save", save: null });
    return;
  }
  if (key === "b") {
    event.preventDefault();
    if (store.state.connection === "open" && store.state.garment) openBuild(store);
    return;
  }
  const isRedo = key === "y" || (key === "z" && event.shiftKey);
  if ((key !== "z" && key !== "y") || keepsUndo(event.target)) return;
  event.preventDefault();
  const { selector } = store;
  // The steps of a selection end when something is made of it, so that they come after all edits.
  if (isRedo ? selector.canRedo : selector.canUndo) return isRedo ? selector.redo() : selector.undo();
  const { canUndo, canRedo } = store.state.document;
  if (isRedo ? canRedo : canUndo) store.command({ type: isRedo ? "redo" : "undo" });
}

function plain(store: Store, event: KeyboardEvent): void {
  const { settings, document } = store.state;
  const key = event.key.toLowerCase();
  if (key === " " && !isButton(event.target) && store.state.shot) {
    event.preventDefault();
    store.player.toggle();
  }
  if (key === "," || key === ".") store.player.step(key === "," ? -1 : 1);
  if (key === "f") store.view?.frame();
  if (key === "g") nextLarge(store);
  if (key === "i") store.toggleIsolated();
  if (key === "x" && !event.repeat) store.toggleSplit();
  if (key === "w") store.settings({ wires: !settings.wires });
  if (key === "p") store.painter.toggle();
  const { brush } = store.state;
  if (brush && (key === "[" || key === "]")) store.painter.set({ radius: brush.radius * (key === "]" ? 1.25 : 0.8) });
  else if (key === "[" || key === "]") store.visit((store.state.place?.at ?? 0) + (key === "]" ? 1 : -1));
  if (key === "y" && store.state.garment?.mirror) store.settings({ symmetric: !settings.symmetric });
  if (key === "?") store.update({ dialog: "keys" });
  const earlier = event.shiftKey ? "saved" : "step";
  if (key === "c" && !event.repeat && document.canUndo) compare(store, earlier);
  if (key === "escape") escape(store);
  if (key === "e") {
    event.preventDefault();
    store.update({ isSelecting: true, clicked: null });
  }
  if (key === "d") setFiner(store, !event.shiftKey);
  select(store, key);
  // Shift gives digits other signs.
  const digit = Number(/^(?:Digit|Numpad)(\d)$/.exec(event.code)?.[1] ?? 0);
  if (digit >= 1 && digit <= ROLES.length) (event.shiftKey ? showAlone : toggleRole)(store, digit - 1);
  const side = event.shiftKey ? undefined : SIDE_NAMES[digit - 1 - ROLES.length];
  if (side) store.view?.look(side);
}

/** Keys that change the selection or make something of it. */
function select(store: Store, key: string): void {
  const isWay = WAYS.some((way) => way.key === key);
  if (isWay) store.selector.go(key);
  if (key === "+" || key === "=") store.selector.grow(1);
  if (key === "-" || key === "−") store.selector.grow(-1);
  if (key === "n") addFromSelection(store);
  if (isWay || "+=-−n".includes(key)) store.update({ clicked: null });
}

function escape(store: Store): void {
  if (store.state.brush) store.painter.end();
  else if (store.state.clicked) store.update({ clicked: null });
  else if (store.state.marked) store.mark(null);
  else if (store.state.isolated) store.isolate(null);
  else if (store.state.split !== null) store.split(null);
  else {
    store.update({ isSelecting: false });
    store.selector.clear();
  }
}

let isComparing = false;

function compare(store: Store, state: Before | null): void {
  isComparing = state !== null;
  store.command({ type: "compare", with: state });
}

/** In the order of their keys. */
export const SIDE_NAMES: Side[] = ["front", "side", "back", "top", "three-quarter"];

/** Shows one mesh, or all if it is alone. */
export function showAlone(store: Store, index: number): void {
  const alone = [ROLES[index]];
  store.settings({ roles: store.state.settings.roles.join() === alone.join() ? ROLES : alone });
}

/** Makes a mesh the large one, with the others beside it. */
export function makeLarge(store: Store, large: Role): void {
  store.settings({ layout: "large", large });
}

/** The next of the meshes that are shown; in another layout, the one that was large. */
function nextLarge(store: Store): void {
  const { settings } = store.state;
  const { roles } = settings;
  const large = largeOf(settings);
  makeLarge(store, settings.layout === "large" ? roles[(roles.indexOf(large) + 1) % roles.length] : large);
}

/** Shows or hides a mesh; the last one stays. */
export function toggleRole(store: Store, index: number): void {
  const role = ROLES[index];
  const { roles } = store.state.settings;
  const next = ROLES.filter((each) => (each === role ? !roles.includes(each) : roles.includes(each)));
  if (next.length > 0) store.settings({ roles: next });
}

/** What a space presses; a slider is only focused. */
function isButton(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.closest("button, input:not([type=range]), select, [data-card]") !== null;
}

/** A field with text that is not taken yet has an undo of its own. */
function keepsUndo(target: EventTarget | null): boolean {
  const isText = isTyping(target) && !(target instanceof HTMLSelectElement);
  return isText && target instanceof HTMLElement && target.dataset.clean === undefined;
}
