// The selection of this page: an expression of a set, and its elements, which the server finds.

import type { Elements, PageMessage, SelectionMessage, SetKind } from "../server/protocol";
import type { Garment } from "./garment";
import type { Picked, PickHow } from "../view/api";

export interface Selection {
  expression: string;
  kind: SetKind;
  count: number;
  elements: Elements;
  /** Length [m] of edges, area [m²] of faces. */
  size: number | null;
  isClosed: boolean;
}

type Change = Extract<PageMessage, { type: "select" }>["change"];

/** What the server is asked for: a set that changes the selection, or another set, of which something is then made. */
interface Request {
  change: Change;
  set: string;
  of?: { set: string; make(expression: string, elements: Elements | null): void; isQuiet?: boolean };
}

/** A change, given the selection before it; null for none. */
type Step = (before: Selection | null) => Request | null;

/** A way to go on from a selection. */
export interface Way {
  label: string;
  key: string;
  hint: string;
  of: SetKind;
  set(expression: string): string;
}

export const WAYS: Way[] = [
  { label: "Loop", key: "l", hint: "The whole border, seam or edge loop", of: "edge", set: (edges) => `loops(${edges})` },
  { label: "Shell", key: "l", hint: "The whole UV shell", of: "face", set: (faces) => `shell(${faces})` },
  { label: "Material", key: "m", hint: "All with this material", of: "face", set: (faces) => `sameMaterial(${faces})` },
  { label: "Border", key: "b", hint: "The border of the faces", of: "face", set: (faces) => `border(${faces})` },
];

/** Rows of faces beside a set. */
interface Rows {
  of: string;
  count: number;
  /** The selection that they are. */
  expression: string;
}

export class Selector {
  #selection: Selection | null = null;
  #past: (Selection | null)[] = [];
  #future: (Selection | null)[] = [];
  readonly #waiting: Step[] = [];
  #asked: Request | null = null;
  /** The last element that was picked, from which a path begins. */
  #last: { kind: SetKind; set: string } | null = null;
  #rows: Rows | null = null;
  /** Whether the server was asked for a loop, and the last one that it found. */
  #isLoop = false;
  #loop: Selection | null = null;

  constructor(
    private readonly send: (message: PageMessage) => void,
    private readonly show: (selection: Selection | null) => void,
    private readonly refuse: (reason: string) => void,
    /** Whether both sides of the garment are picked at once. */
    private readonly isSymmetric: () => boolean,
  ) {}

  get canUndo(): boolean {
    return this.#past.length > 0;
  }

  get canRedo(): boolean {
    return this.#future.length > 0;
  }

  /** Takes the element of the model that was clicked. */
  pick(picked: Picked, how: PickHow, { checksum }: Garment): void {
    const kind = how === "replace" || !this.#selection ? (picked.edge ? "edge" : "face") : this.#selection.kind;
    if (kind === "edge" && !picked.edge) return this.refuse("Edges are selected; click an edge");
    const numbers = kind === "edge" ? picked.edge?.join("-") : String(picked.face);
    const set = `picked${kind === "edge" ? "Edges" : "Faces"}("${checksum}", "${numbers}")`;
    const from = this.#last;
    this.#last = { kind, set };
    const taken = how === "path" && from?.kind === kind ? `path(${from.set}, ${set})` : set;
    const both = this.isSymmetric() ? `${taken} + mirror(${taken})` : taken;
    this.#add(() => ({ change: how === "path" ? "add" : how, set: both }));
  }

  /** Goes on from the selection by the way of a key; from a whole loop of edges, straight through the junctions at its ends. */
  go(key: string): void {
    this.#add((before) => {
      const ways = WAYS.filter((way) => way.key === key);
      const way = ways.find((way) => way.of === before?.kind);
      if (!before || !way) {
        this.refuse(`${ways.map(({ label }) => label).join(" and ")}: select ${ways.map(({ of }) => `${of}s`).join(" or ")} first`);
        return null;
      }
      this.#isLoop = way.label === "Loop";
      const goesOn = this.#isLoop && before === this.#loop;
      return { change: "replace", set: goesOn ? `onward(${before.expression})` : way.set(before.expression) };
    });
  }

  /** Makes something of the selection once its changes are done. */
  use(make: (selection: Selection) => void): void {
    this.#add((before) => {
      if (before) make(before);
      return null;
    });
  }

  /** Makes something of the set that `of` gives, once the selection is added to it or taken away; of "" if nothing is left. */
  combine(change: "add" | "remove", of: (selection: Selection) => string | null, make: (expression: string) => void): void {
    this.#add((before) => {
      const set = before && of(before);
      return before && set !== null ? { change, set: before.expression, of: { set, make } } : null;
    });
  }

  /** Finds the elements of a set; null if it has none. */
  find(expression: string, found: (elements: Elements | null) => void): void {
    const of = { set: "", make: (_: string, elements: Elements | null) => found(elements), isQuiet: true };
    this.#add(() => ({ change: "replace", set: expression, of }));
  }

  /** Adds a row of faces around the selection, or takes one away. */
  grow(by: 1 | -1): void {
    this.#add((before) => {
      if (!before) return null;
      const known = this.#rows?.expression === before.expression ? this.#rows : null;
      const count = (known?.count ?? 0) + by;
      if (known && count > 0) return { change: "replace", set: this.#rowsOf(known.of, count) };
      if (by > 0) return { change: "replace", set: this.#rowsOf(before.expression, 1) };
      return before.kind === "face" ? { change: "remove", set: `rings(border(${before.expression}))` } : null;
    });
  }

  #rowsOf(of: string, count: number): string {
    const expression = count === 1 ? `rings(${of})` : `rings(${of}, ${count})`;
    this.#rows = { of, count, expression };
    return expression;
  }

  /** Selects the set of an expression. */
  take(expression: string): void {
    this.#add(() => ({ change: "replace", set: expression }));
  }

  clear(): void {
    if (this.#selection) this.#step(null);
  }

  /** Ends the selection, as something was made of it. */
  end(): void {
    this.forget();
    this.#put(null);
  }

  /** Takes up a selection of which something was made. */
  restore(selection: Selection): void {
    this.forget();
    this.#put(selection);
  }

  /** Ends the selection if it is this one. */
  endIf({ expression }: Selection): void {
    if (this.#selection?.expression === expression) this.end();
  }

  /** Forgets the steps to the selection, as others come after them. */
  forget(): void {
    this.#past = [];
    this.#future = [];
  }

  undo(): void {
    this.#swap(this.#past, this.#future);
  }

  redo(): void {
    this.#swap(this.#future, this.#past);
  }

  #swap(from: (Selection | null)[], to: (Selection | null)[]): void {
    const next = from.pop();
    if (next === undefined) return;
    to.push(this.#selection);
    this.#put(next);
  }

  /** The mesh is another: its elements are found again. */
  renew(): void {
    const before = this.#selection?.expression;
    this.#waiting.length = 0;
    this.#last = null;
    this.end();
    if (before) this.take(before);
  }

  /** A new connection answers nothing that was asked before. */
  reset(): void {
    this.#waiting.length = 0;
    this.#asked = null;
  }

  /** The server's answer. */
  answer({ expression, elements, size, isClosed, fault }: SelectionMessage): void {
    const asked = this.#asked;
    this.#asked = null;
    if (asked?.of && (!fault || asked.of.isQuiet)) asked.of.make(elements ? expression : "", elements);
    else if (fault) this.refuse(`${fault.text}; ${fault.remedy}`);
    else if (!elements && asked?.change !== "remove") this.refuse("The set has no elements");
    else if (!elements) this.#step(null);
    else this.#step({ expression, ...countOf(elements), elements, size, isClosed });
    if (this.#isLoop && !fault) {
      const isWhole = this.#loop?.count === this.#selection?.count && this.#loop?.expression === this.#selection?.expression;
      if (isWhole) this.refuse("Nothing goes on straight from here");
      this.#loop = this.#selection;
    }
    this.#isLoop = false;
    this.#next();
  }

  /** Steps that come before an answer wait for it, as they change what it says. */
  #add(step: Step): void {
    this.#waiting.push(step);
    if (!this.#asked) this.#next();
  }

  #next(): void {
    const request = this.#waiting.shift()?.(this.#selection);
    if (request) {
      this.#asked = request;
      const { change, set, of } = request;
      this.send({ type: "select", selection: (of?.set ?? this.#selection?.expression) || "", change, set });
    } else if (this.#waiting.length > 0) this.#next();
  }

  #step(selection: Selection | null): void {
    // An unchanged selection makes no step of undo, but the field waits for its answer.
    if (selection?.expression === this.#selection?.expression) return this.#put(selection);
    this.#past.push(this.#selection);
    this.#future = [];
    this.#put(selection);
  }

  #put(selection: Selection | null): void {
    this.#selection = selection;
    this.show(selection);
  }
}

function countOf(elements: Elements): { kind: SetKind; count: number } {
  if ("edges" in elements) return { kind: "edge", count: elements.edges.length };
  if ("faces" in elements) return { kind: "face", count: elements.faces.length };
  return { kind: "point", count: elements.points.length };
}

/** A set or an expression in words: a name such as `left_armhole` is that of a file. */
export function wordsOf(set: string): string {
  return /^\w+$/.test(set) ? set.replaceAll("_", " ") : shortName(set);
}

/** An expression as the panel shows it: numbers of elements say nothing to an artist. */
export function shortName(expression: string): string {
  const words = (_: string, kind: string, numbers: string) => {
    const count = countIn(kind, numbers);
    return `${count} picked ${count === 1 ? kind.slice(0, -1).toLowerCase() : kind.toLowerCase()}`;
  };
  return expression.replace(/painted\("[^"]*", "[^"]*"\)/g, "painted").replace(/picked(Edges|Faces)\("[^"]*", "([^"]*)"\)/g, words);
}

function countIn(kind: string, numbers: string): number {
  const runs = numbers.split(",").map((run) => run.split("-").map(Number));
  const lengths = runs.map((run) => (kind === "Edges" ? run.length - 1 : run[run.length - 1] - run[0] + 1));
  return lengths.reduce((all, length) => all + length, 0);
}
