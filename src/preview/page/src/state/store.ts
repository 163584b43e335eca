// The state of the page and all that changes it. Components read the state and call methods; the server's messages and
// the view's events come in here too.

import { Connection } from "../server/connection";
import { EditQueue } from "./editQueue";
import { Gestures } from "./gesture";
import { onSystemTheme, paintedChoices, QUALITIES, saveSettings, viewOptions } from "./settings";
import type { Settings } from "./settings";
import { initialState, shownOf, type State, type Toast } from "./state";
import { Selector, type Selection } from "./selection";
import { Player } from "./player";
import { Painter } from "./painter";
import { Way } from "./way";
import { Stopwatch } from "./stopwatch";
import type { MeshFrame } from "../server/frame";
import type { Options, Value } from "../server/options";
import type { GarmentMessage, PageMessage, ProductMessage, ProgressMessage } from "../server/protocol";
import type { Role, ServerMessage, StateMessage } from "../server/protocol";
import { findingsIn, garmentOf, type Finding } from "./garment";
import { Made } from "./made";
import { notePreset } from "./presets";
import { placeFaults, setsOf, withoutValue, withValue } from "./recipe";
import { createView } from "../view/index";
import { ROLES } from "../view/layout";
import type { Isolated, Outline, Picked, PickHow, Plan, View } from "../view/api";

/** An option with another value. */
export interface Change {
  key: string;
  value: Value;
  /** Whether the value is the one below the edits, so that it is no edit. */
  isBack?: boolean;
}

export class Store {
  state = initialState();
  view: View | null = null;
  readonly gestures = new Gestures();
  readonly player = new Player(this);
  readonly way = new Way(this);
  readonly painter = new Painter(this);
  readonly stopwatch = new Stopwatch();
  readonly #listeners = new Set<() => void>();
  readonly #queue = new EditQueue((message) => this.send(message));
  readonly selector = new Selector(
    (message) => this.send(message),
    (selection) => this.#selected(selection),
    (text) => this.toast({ text }),
    () => this.state.settings.symmetric && Boolean(this.state.garment?.mirror),
  );
  readonly made = new Made();
  /** The way through the steps that was asked for last, until the next edit. */
  #way: "undo" | "redo" | null = null;
  #connection: Connection | null = null;
  /** The view that the server was asked for, as text; empty for a new connection. */
  #asked = "";
  /** Roles whose mesh the view has, so that an update of another one has nothing to update. */
  readonly #held = new Set<Role>();
  #toastCount = 0;
  #lastHovered: Picked | null = null;

  subscribe(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  update(change: Partial<State>): void {
    this.state = { ...this.state, ...change };
    if (change.faults || change.document || change.garment) {
      const { faults, garment, document } = this.state;
      const all = [...faults.recipe, ...faults.sim, ...faults.render, ...faults.cloth];
      this.state.placed = placeFaults(all, garment, document);
    }
    for (const listener of this.#listeners) listener();
  }

  /** Draws on the canvas and connects to the server. */
  start(canvas: HTMLCanvasElement): void {
    onSystemTheme((theme) => this.#show({ theme }));
    try {
      this.view = createView(canvas, viewOptions(this.state.settings), {
        hover: (hovered, outlines) => this.#hover(hovered, outlines),
        click: (clicked, how) => this.#click(clicked, how),
        painted: (weights) => this.painter.painted(weights),
        plan: (plan) => this.#plan(plan),
        grip: (grip) => JSON.stringify(grip) !== JSON.stringify(this.state.grip) && this.update({ grip }),
        final: (isFinal) => isFinal !== this.state.isFinal && this.update({ isFinal }),
        drawn: (role, revision, upload) => this.#drawn(role, revision, upload),
      });
    } catch (error) {
      this.update({ viewFault: error instanceof Error ? error.message : String(error) });
    }
    this.#connection = new Connection({
      message: (message) => this.#receive(message),
      mesh: (frame) => this.#mesh(frame),
      connected: (is) => (is ? this.#connected() : this.#disconnected()),
    });
  }

  send(message: PageMessage): void {
    this.#connection?.send(message);
  }

  // ---- Edits

  /** Changes the edits. Changes of a drag or a run of key presses are one gesture, others are one each. The options that
   *  hold are changed alike until the server has merged them. */
  edit(change: (options: Options) => Options, how: "step" | "continuous" = "step"): void {
    const { document } = this.state;
    this.selector.forget();
    this.#replace(change(document.edits), change(document.merged), how);
  }

  #replace(edits: Options, merged: Options, how: "step" | "continuous"): void {
    this.#way = null;
    const gesture = how === "step" ? this.gestures.next() : this.gestures.current;
    this.#queue.push(edits, gesture, this.gestures.input);
    const { document } = this.state;
    this.update({ document: { ...document, edits, merged, unsaved: true, savedAs: null, canUndo: true, canRedo: false } });
  }

  set(key: string, value: Value, how: "step" | "continuous" = "step"): void {
    this.edit((options) => withValue(options, key, value), how);
  }

  /** Sets several options as one change. */
  setAll(changes: Change[], how: "step" | "continuous" = "step"): void {
    this.selector.forget();
    const { edits, upstream, merged } = this.state.document;
    const edited = changes.reduce(
      (all, { key, value, isBack }) => (isBack ? withoutValue(all, key, upstream) : withValue(all, key, value)),
      edits,
    );
    this.#replace(edited, changes.reduce((all, { key, value }) => withValue(all, key, value), merged), how);
  }

  /** Takes edits back. The server knows the values below them. */
  reset(...keys: string[]): void {
    this.selector.forget();
    const { edits, upstream, merged } = this.state.document;
    this.#replace(keys.reduce((all, key) => withoutValue(all, key, upstream), edits), merged, "step");
  }

  /** A message that acts on the document, after the edits that come before it. */
  command(message: PageMessage): void {
    this.#queue.flush();
    if (message.type === "undo" || message.type === "redo") this.#way = message.type;
    this.stopwatch.command();
    this.send(message);
  }

  // ---- What is shown

  settings(changed: Partial<Settings>): void {
    saveSettings(changed);
    this.#show(changed);
  }

  #show(changed: Partial<Settings>): void {
    const settings = this.#withHeat({ ...this.state.settings, ...changed });
    this.update({ settings, ...(settings.shading === "values" ? {} : { heat: null }) });
    const dropped = [...this.#held].filter((role) => !isHeld(role, settings));
    for (const role of dropped) this.#drop(role);
    this.view?.setOptions(viewOptions(shownOf(this.state)));
    this.#ask();
    this.painter.renew();
  }

  /** Changes what is painted, which the meshes show. */
  show(change: Pick<State, "brush">): void {
    this.update(change);
    this.#show({});
  }

  /** Asks for what is shown, unless the server was asked for it already. */
  #ask(): void {
    const wanted = this.#wanted();
    const text = JSON.stringify(wanted);
    if (text === this.#asked) return;
    this.#asked = text;
    this.send(wanted);
  }

  /** Heat needs something to show. */
  #withHeat(settings: Settings): Settings {
    const names = [...paintedChoices(this.state.garment), ...QUALITIES].map(({ name }) => name);
    const isKnown = settings.values !== null && names.includes(settings.values);
    return settings.shading !== "values" || isKnown ? settings : { ...settings, values: names[0] };
  }

  #drop(role: Role): void {
    this.#held.delete(role);
    this.view?.remove(role);
  }

  /** The model is always needed, for marks and picking. */
  #wanted(): PageMessage {
    const settings = shownOf(this.state);
    const { smooth, shading, fabric, flat, values } = settings;
    const { image, relief, colour, weave } = fabric;
    const hasImages = colour === null && (this.state.garment?.looks ?? []).some(({ texture }) => texture !== null);
    const hasFabric = Boolean(hasImages || image || relief || weave !== "none");
    const needsUvs = shading === "checker" || flat || (shading === "cloth" && hasFabric);
    return {
      type: "view",
      roles: [...ROLES, "body" as const].filter((role) => isHeld(role, settings)),
      smooth,
      uv: needsUvs,
      values: shading === "values" ? values : null,
    };
  }

  /** Highlights sets, or else those of the marked warning. */
  highlight(sets: string[] | null): void {
    this.view?.highlight(sets ?? this.state.marked?.names ?? []);
  }

  /** Marks the elements of a warning on its mesh, which is shown, and flies there; null ends it. */
  mark(finding: Finding | null): void {
    this.update({ marked: finding });
    const hasElements = finding && Object.values(finding.elements).some((list) => list.length > 0);
    if (finding && hasElements) this.#bringUp(finding.role);
    if (hasElements && this.state.isolated) this.isolate(null);
    this.view?.mark(hasElements ? finding : null);
    this.highlight(null);
    this.visit(0);
  }

  /** Flies to a place of the marked warning, where it has several; from the last to the first. */
  visit(wanted: number): void {
    const count = this.view?.placeCount() ?? 0;
    const at = count > 0 ? (wanted + count) % count : 0;
    if (count > 1) this.view?.flyToPlace(at);
    this.update({ place: count > 1 ? { at, count } : null });
  }

  /** Without a change of the stored settings, which are the artist's own. */
  #bringUp(role: Role): void {
    const { roles, large } = this.state.settings;
    if (roles.includes(role) && large === role) return;
    this.#show({ large: role, roles: ROLES.filter((each) => each === role || roles.includes(each)) });
  }

  /** Shows a part of the garment alone, or all of it for null. */
  isolate(what: Isolated | null): void {
    const isolated = this.view?.isolate(what) ?? false;
    this.update({ isolated, clicked: null });
  }

  /** Keeps the meshes that are shown on the left of a line, or moves the line; null ends it. */
  split(share: number | null): void {
    if (share !== null && this.state.drawn === 0) return;
    this.view?.split(share);
    this.update({ split: share });
  }

  toggleSplit(): void {
    this.split(this.state.split === null ? 0.5 : null);
  }

  /** Isolates the selected faces, or the panel at the pointer or where it was last; or shows all again. */
  toggleIsolated(): void {
    const { isolated, selection, hovered, clicked } = this.state;
    const faces = selection?.kind === "face" ? selection.elements : null;
    const what = faces ?? hovered ?? clicked ?? selection?.elements ?? this.#lastHovered;
    if (!isolated && !what) return this.toast({ text: "Point at a panel, or select faces, to show them alone" });
    this.isolate(isolated ? null : what);
  }

  openCard(full: string, isOpen: boolean): void {
    const open = new Set(this.state.open);
    if (isOpen) open.add(full);
    else open.delete(full);
    this.update({ open });
  }

  toast(toast: Omit<Toast, "id">): void {
    const id = ++this.#toastCount;
    this.update({ toasts: [...this.state.toasts, { ...toast, id }] });
    setTimeout(() => this.dismiss(id), toast.action ? 20_000 : 7_000);
  }

  dismiss(id: number): void {
    this.update({ toasts: this.state.toasts.filter((toast) => toast.id !== id) });
  }

  // ---- The view's events

  /** Edges are thin, so that a highlight under the pointer does not flicker as one of faces would. */
  #hover(hovered: Picked | null, outlines: Outline[]): void {
    this.#lastHovered = hovered ?? this.#lastHovered;
    this.update({ hovered, outlines });
    const { document, garment } = this.state;
    const used = document.stack.flatMap((each) => setsOf(document.merged, each, garment?.kinds ?? []));
    const edges = (hovered?.sets ?? []).filter(({ kind, name }) => kind === "edge" && used.includes(name));
    this.highlight(edges.length > 0 ? edges.map(({ name }) => name) : null);
  }

  /** A click with a modifier is about the selection alone. */
  #click(clicked: Picked | null, how: PickHow): void {
    this.update({ clicked: how === "replace" ? clicked : null });
    const { garment } = this.state;
    if (clicked && garment) this.selector.pick(clicked, how, garment);
    else if (how === "replace") this.selector.clear();
  }

  #selected(selection: Selection | null): void {
    this.update({ selection });
    this.view?.select(selection?.elements ?? null);
  }

  /** In space there is none, and each picture would tell all listeners. */
  #plan(plan: Plan): void {
    if (plan.length > 0 || this.state.plan.length > 0) this.update({ plan });
  }

  #drawn(role: Role, revision: number, upload: number): void {
    const timing = this.stopwatch.drawn(role, revision, upload);
    const isEdit = timing?.edited !== null;
    this.update({ drawn: this.state.drawn + 1, ...(timing && isEdit ? { lastEdit: timing } : {}) });
  }

  // ---- The server's messages

  #connected(): void {
    this.#queue.reset();
    this.selector.reset();
    this.player.reset();
    this.way.reset();
    this.update({ connection: "open" });
    this.#asked = "";
    this.#ask();
  }

  #disconnected(): void {
    if (this.state.connection !== "open") return;
    this.update({ connection: "lost", progress: {} });
  }

  #receive(message: ServerMessage): void {
    switch (message.type) {
      case "garment":
        return this.#garment(message);
      case "state":
        return this.#document(message);
      case "faults":
        return this.update({ faults: { ...this.state.faults, [message.origin]: message.faults } });
      case "product":
        return this.#product(message);
      case "build":
        return this.update({ build: message });
      case "shot":
        return this.player.receive(message);
      case "fit":
        return this.way.receive(message);
      case "bodies":
        return this.update({ bodies: message });
      case "cloth":
        return this.update({ cloth: message });
      case "progress":
        return this.#progress(message);
      case "selection":
        return this.selector.answer(message);
      case "save":
        return this.update({ save: message });
      case "presets":
        return this.update({ presets: message });
      case "presetSaved":
        return notePreset(this, message);
    }
  }

  #garment(garment: GarmentMessage): void {
    this.way.reset();
    if (this.state.marked) this.mark(null);
    this.made.clear();
    this.#lastHovered = null;
    if (this.state.isolated) this.isolate(null);
    // The kept meshes of another model have other numbers of edges and faces.
    if (this.state.garment?.checksum !== garment.checksum) this.split(null);
    if (garment.body === null) this.#drop("body");
    this.update({ garment: garmentOf(garment) });
    this.selector.renew();
    this.view?.setUp(garment.upAxis);
    this.view?.setGarment(garment);
    document.title = `${garment.file} · usdtailor`;
    // The garment may no longer have the primvar that heat shows.
    this.#show({});
  }

  #document(message: StateMessage): void {
    const { serial, ...state } = message;
    this.stopwatch.revision(message.revision, this.#queue.inputOf(serial));
    const current = this.state.document;
    const { edits, merged, stack } = this.#queue.isBehind(serial) ? current : state;
    this.update({ document: { ...state, edits, merged, stack } });
    this.#follow(current.merged, merged);
    this.painter.follow();
  }

  /** The selection of an operator that is undone is there again, and ends once more when it is done again. */
  #follow(before: Options, after: Options): void {
    const undone = this.#way === "undo" ? this.made.between(before, after) : null;
    const redone = this.#way === "redo" ? this.made.between(after, before) : null;
    if (undone) this.selector.restore(undone);
    if (redone) this.selector.endIf(redone);
  }

  #product(product: ProductMessage): void {
    const { marked } = this.state;
    const { role } = product;
    const found = { ...product, warnings: findingsIn(product.warnings, role) };
    this.update({ products: { ...this.state.products, [role]: found } });
    if (marked?.role !== role) return;
    const same = found.warnings.find(({ code, place }) => code === marked.code && place === marked.place);
    if (same) this.#remark(same);
    else this.mark(null);
  }

  /** The marks of a warning that a new build has again; the camera stays. */
  #remark(finding: Finding): void {
    this.update({ marked: finding });
    this.view?.mark(finding, false);
  }

  #progress({ role, step }: ProgressMessage): void {
    const progress = { ...this.state.progress };
    if (step === null) delete progress[role];
    else progress[role] = { step, since: progress[role]?.since ?? performance.now() };
    this.update({ progress });
  }

  #mesh(frame: MeshFrame): void {
    const { role, replaces, values } = frame.header;
    // Frames that were on their way while the mesh was hidden.
    if (!isHeld(role, this.state.settings) || (!replaces && !this.#held.has(role))) return;
    this.#held.add(role);
    // A quality figure is of one mesh, so that the others have no values.
    if (values) this.update({ heat: values });
    this.view?.update(frame);
    if (role === "model") this.painter.arrived(replaces);
    this.stopwatch.replaced(frame);
  }
}

/** Whether the page has a mesh. The model is always needed, for marks and picking. */
function isHeld(role: Role, { roles, body }: Settings): boolean {
  return role === "model" || (role === "body" ? body : roles.includes(role));
}
