// The state of the page, which the store changes and components read.

import type { Fields, KindName } from "../server/options";
import type { BodiesMessage, BuildMessage, ClothMessage, DrawnValues, Fault, FitMessage, Origin, PresetsMessage, ProductMessage } from "../server/protocol";
import type { Role, SaveMessage, ShotMessage, StateMessage } from "../server/protocol";
import { findingsIn, SEVERITIES, type Finding, type Garment } from "./garment";
import type { PlacedFaults } from "./recipe";
import type { Brush } from "./painter";
import type { Selection } from "./selection";
import type { Grip, Outline, Picked, Plan } from "../view/api";
import { loadSettings, type Settings } from "./settings";
import { ROLES } from "../view/layout";
import type { Timing } from "./stopwatch";

export type Document = Omit<StateMessage, "serial">;

export type Product = Omit<ProductMessage, "warnings"> & { warnings: Finding[] };

export interface Toast {
  id: number;
  text: string;
  code?: string;
  action?: { label: string; act(): void };
}

export interface State {
  connection: "first" | "open" | "lost";
  garment: Garment | null;
  document: Document;
  faults: Record<Origin, Fault[]>;
  placed: PlacedFaults;
  products: Partial<Record<Role, Product>>;
  progress: Partial<Record<Role, { step: string; since: number }>>;
  cloth: ClothMessage | null;
  shot: ShotMessage | null;
  /** The place on the way of the fit, with what crosses the body there; null without one. */
  fit: (Omit<FitMessage, "warning"> & { finding: Finding | null }) | null;
  bodies: Omit<BodiesMessage, "type">;
  isPlaying: boolean;
  heat: DrawnValues | null;
  /** Whether the picture is the last one, or a better one comes. */
  isFinal: boolean;
  /** Counts the drawings of new meshes, since colours of sets may come with them. */
  drawn: number;
  lastEdit: Timing | null;
  settings: Settings;
  hovered: Picked | null;
  /** What a click there takes, on all meshes. */
  outlines: Outline[];
  clicked: Picked | null;
  selection: Selection | null;
  /** What is written on the flat panels. */
  plan: Plan;
  /** What is painted; null for nothing. */
  brush: Brush | null;
  /** Where the handles of an operator are. */
  grip: Grip | null;
  /** Whether the bar of the selection is there without one, to type it. */
  isSelecting: boolean;
  marked: Finding | null;
  /** Which of the places of the marked warning is in view, and how many there are; null of one. */
  place: { at: number; count: number } | null;
  /** Whether a part of the garment is shown alone. */
  isolated: boolean;
  /** Where the line of a split view is, as a part of each column; null without one. */
  split: number | null;
  /** Cards that are open, by full name. */
  open: ReadonlySet<string>;
  dialog: "save" | "keys" | "build" | null;
  /** Whether a build follows the save. */
  buildsNext: boolean;
  build: BuildMessage | null;
  /** Cards that are selected, by full name. A value that is set in one of them is set in all of its kind. */
  chosen: ReadonlySet<string>;
  /** Where a range of selected cards begins. */
  anchor: string | null;
  /** The card whose name is being typed. */
  naming: string | null;
  /** Values to paste into cards. */
  copied: { kind: KindName; fields: Fields } | null;
  presets: PresetsMessage | null;
  save: SaveMessage | null;
  /** The file that was saved last. */
  savedTo: string | null;
  toasts: Toast[];
  /** Words for screen readers. */
  spoken: string;
  /** Meaning of the option under the pointer or with the focus. */
  info: string;
  /** Why nothing can be drawn, such as no WebGL. */
  viewFault: string | null;
}

const EMPTY: Document = {
  revision: 0,
  upstream: {},
  edits: {},
  canUndo: false,
  canRedo: false,
  unsaved: false,
  comparing: null,
  level: 0,
  savedAs: null,
  kept: null,
  merged: {},
  stack: [],
};

export function initialState(): State {
  return {
    connection: "first",
    garment: null,
    document: EMPTY,
    faults: { file: [], presets: [], recipe: [], sim: [], render: [], cloth: [] },
    placed: { at: new Map(), elsewhere: [] },
    products: {},
    progress: {},
    cloth: null,
    shot: null,
    fit: null,
    bodies: { files: [], isComplete: false },
    isPlaying: false,
    heat: null,
    isFinal: true,
    drawn: 0,
    lastEdit: null,
    settings: loadSettings(),
    hovered: null,
    outlines: [],
    clicked: null,
    selection: null,
    plan: [],
    brush: null,
    grip: null,
    isSelecting: false,
    marked: null,
    place: null,
    isolated: false,
    split: null,
    open: new Set(),
    chosen: new Set(),
    anchor: null,
    naming: null,
    copied: null,
    presets: null,
    dialog: null,
    buildsNext: false,
    build: null,
    save: null,
    savedTo: null,
    toasts: [],
    spoken: "",
    info: "",
    viewFault: null,
  };
}

/** The settings, or those for painting: the cage of the model as heat. */
export function shownOf({ settings, brush }: Pick<State, "settings" | "brush">): Settings {
  if (!brush) return settings;
  const roles = ROLES.filter((role) => role === "model" || settings.roles.includes(role));
  return { ...settings, roles, layout: "large", large: "model", flat: false, shading: "values", smooth: 0, values: brush.primvar };
}

/** Warnings of the garment, of its place on the way of the fit, of its products and of its cloth, the worst first. */
export function findingsOf({ garment, fit, products, cloth }: Pick<State, "garment" | "fit" | "products" | "cloth">): Finding[] {
  const ofProducts = ROLES.flatMap((role) => products[role]?.warnings ?? []);
  const all = [...(garment?.warnings ?? []), ...(fit?.finding ? [fit.finding] : []), ...ofProducts, ...findingsIn(cloth?.warnings ?? [], "sim")];
  return SEVERITIES.flatMap((severity) => all.filter((each) => each.severity === severity));
}

/** How a mesh that is shown stands to the recipe and the files as they are. */
export interface Standing {
  is: "current" | "building" | "stale";
  /** Why it is stale. */
  why: string;
}

type Known = Pick<State, "faults" | "progress" | "products">;

export function standingOf({ faults, progress, products }: Known, role: Role): Standing {
  if (faults.file.length > 0) return { is: "stale", why: "the file cannot be read" };
  // While the garment is fitted, its products wait.
  if (progress[role] ?? progress.model) return { is: "building", why: "" };
  if (role === "model" || role === "body") return CURRENT;
  if (faults.recipe.length > 0) return { is: "stale", why: "an option has an error" };
  if (faults[role].length > 0) return { is: "stale", why: "the last build failed" };
  return products[role] ? CURRENT : { is: "building", why: "" };
}

const CURRENT: Standing = { is: "current", why: "" };
