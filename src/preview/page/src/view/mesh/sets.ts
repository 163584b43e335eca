// The sets of a mesh: which edges and faces are in them, and their colours in the tables that the shaders read.

import type { DrawnSet, SetKind } from "../../server/protocol";
import type { PickedSet } from "../api";
import { bytes, setColour } from "../shade/colours";
import { HIDDEN, PLAIN, HIGHLIGHTED, FIRST_SET, CLASSES } from "../shade/classes";
import type { Edges } from "./topology";

/** Flags in the fourth channel of a face's colour. */
const COLOURED = 128;
const LIT_UP = 64;

export interface ElementSet extends PickedSet {
  family: string;
  elements: Uint32Array;
  /** Class of its edges in the shader. */
  edgeClass: number;
}

/** Sets in the order of the frame, but those that the build derives come first so that authored ones cover them. */
export function readSets(headers: DrawnSet[], elements: Uint32Array | undefined): ElementSet[] {
  const derived = (set: DrawnSet) => set.family.startsWith("tailor");
  const ordered = [...headers.filter(derived), ...headers.filter((set) => !derived(set))];
  let edgeSets = 0;
  return ordered.map(({ name, kind, family, offset, length }) => ({
    name,
    kind,
    family,
    elements: elements ? elements.slice(offset, offset + length) : new Uint32Array(0),
    edgeClass: kind === "edge" ? FIRST_SET + (edgeSets++ % (CLASSES - FIRST_SET)) : HIDDEN,
  }));
}

/** Class of each edge by its number: its last set, or plain. */
export function edgeClasses(edges: Edges, sets: ElementSet[], highlighted: ReadonlySet<string>): Uint8Array {
  const classes = new Uint8Array(edges.room).fill(PLAIN);
  const put = (set: ElementSet, edgeClass: number) => {
    for (let at = 0; at + 1 < set.elements.length; at += 2) {
      const edge = edges.find(set.elements[at], set.elements[at + 1]);
      if (edge >= 0) classes[edge] = edgeClass;
    }
  };
  const edgeSets = sets.filter((set) => set.kind === "edge");
  edgeSets.forEach((set) => put(set, set.edgeClass));
  edgeSets.filter((set) => highlighted.has(set.name)).forEach((set) => put(set, HIGHLIGHTED));
  return classes;
}

/** Names of the edge sets of which an edge is drawn; the others are hidden by sets that come after them. */
export function namesDrawn(edges: Edges, sets: ElementSet[]): string[] {
  const drawn = new Set(edgeClasses(edges, sets, new Set()));
  return sets.filter(({ kind, edgeClass }) => kind === "edge" && drawn.has(edgeClass)).map(({ name }) => name);
}

/** Fills the table of faces: the colour of the last set of each, and flags. */
export function fillFaces(table: Uint8Array, sets: ElementSet[], highlighted: ReadonlySet<string>): void {
  table.fill(0);
  for (const { name, kind, elements, family } of sets) {
    if (kind !== "face") continue;
    const [red, green, blue] = setColour(name).map(bytes);
    const lit = highlighted.has(name);
    for (const face of elements) {
      const at = 4 * face;
      if (at + 3 >= table.length) continue;
      // Materials repeat what other sets say, and would hide them.
      if (family !== "materialBind") {
        table[at] = red;
        table[at + 1] = green;
        table[at + 2] = blue;
        table[at + 3] |= COLOURED;
      }
      if (lit) table[at + 3] |= LIT_UP;
    }
  }
}

/** Which sets an element is in. Built when first asked, as a pick is rare and frames are not. */
export class Membership {
  #faces: Map<number, PickedSet[]> | null = null;
  #edges: Map<number, PickedSet[]> | null = null;

  constructor(
    private readonly sets: ElementSet[],
    private readonly edges: Edges,
  ) {}

  ofFace(face: number): PickedSet[] {
    this.#faces ??= collect(this.sets, "face", (elements) => elements);
    return this.#faces.get(face) ?? [];
  }

  ofEdge(a: number, b: number): PickedSet[] {
    this.#edges ??= collect(this.sets, "edge", (elements) => this.#numbers(elements));
    return this.#edges.get(this.edges.find(a, b)) ?? [];
  }

  #numbers(pairs: Uint32Array): number[] {
    const numbers: number[] = [];
    for (let at = 0; at + 1 < pairs.length; at += 2) {
      const edge = this.edges.find(pairs[at], pairs[at + 1]);
      if (edge >= 0) numbers.push(edge);
    }
    return numbers;
  }
}

/** The last set comes first, as its colour is the one that is seen. */
function collect(
  sets: ElementSet[],
  kind: SetKind,
  keys: (elements: Uint32Array) => Iterable<number>,
): Map<number, PickedSet[]> {
  const found = new Map<number, PickedSet[]>();
  for (const set of sets) {
    if (set.kind !== kind) continue;
    const picked = { name: set.name, kind };
    for (const key of keys(set.elements)) {
      const list = found.get(key);
      if (!list) found.set(key, [picked]);
      else if (list[0] !== picked) list.unshift(picked);
    }
  }
  return found;
}
