// The state of the page, which the store changes and components read.

import type { DrawnValues, Fault, Origin, ProductMessage } from "../server/protocol";
import type { Role, SaveMessage, StateMessage, Warning } from "../server/protocol";
import type { Garment } from "./garment";
import type { PlacedFaults } from "./recipe";
import type { Selection } from "./selection";
import type { Picked } from "../view/api";
import { loadSettings, type Settings } from "./settings";
import type { Timing } from "./stopwatch";

export type Document = Omit<StateMessage, "serial">;

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
  products: Partial<Record<Role, ProductMessage>>;
  progress: Partial<Record<Role, { step: string; since: number }>>;
  heat: DrawnValues | null;
  /** Counts the drawings of new meshes, since colours of sets may come with them. */
  drawn: number;
  lastEdit: Timing | null;
  settings: Settings;
  hovered: Picked | null;
  clicked: Picked | null;
  selection: Selection | null;
  /** Whether the bar of the selection is there without one, to type it. */
  isSelecting: boolean;
  marked: Warning | null;
  /** Cards that are open, by full name. */
  open: ReadonlySet<string>;
  dialog: "save" | "keys" | null;
  save: SaveMessage | null;
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
  kept: null,
  merged: {},
  stack: [],
};

export function initialState(): State {
  return {
    connection: "first",
    garment: null,
    document: EMPTY,
    faults: { file: [], recipe: [], sim: [], render: [] },
    placed: { at: new Map(), elsewhere: [] },
    products: {},
    progress: {},
    heat: null,
    drawn: 0,
    lastEdit: null,
    settings: loadSettings(),
    hovered: null,
    clicked: null,
    selection: null,
    isSelecting: false,
    marked: null,
    open: new Set(),
    dialog: null,
    save: null,
    toasts: [],
    spoken: "",
    info: "",
    viewFault: null,
  };
}

/** Warnings of the garment and of its products. */
export function warningsOf({ garment, products }: Pick<State, "garment" | "products">): Warning[] {
  return [...(garment?.warnings ?? []), ...Object.values(products).flatMap(({ warnings }) => warnings)];
}
