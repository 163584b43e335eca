// What is marked, selected and highlighted, and where it is on each mesh.

import type { Role } from "../server/protocol";
import type { Marked } from "./api";
import type { Cloth } from "./mesh/cloth";
import { placesIn } from "./mesh/panels";
import { placeGlow, placeMarks } from "./mesh/shapes";
import type { Elements } from "./mesh/shapes";
import type { Marks } from "./mesh/marks";
import { Carrying, drawnOf } from "./mesh/sources";
import { CROSSING, MARK } from "./shade/colours";
import type { Stage } from "./stage";

/** Elements on one mesh. */
export interface OnCloth {
  role: Role;
  cloth: Cloth;
  elements: Elements;
}

export class Markers {
  marked: Marked | null = null;
  /** Elements of the model. */
  selected: Elements | null = null;
  highlighted: ReadonlySet<string> = new Set();
  readonly #marks = new Carrying();
  readonly #selections = new Carrying();
  readonly #hovers = new Carrying();
  /** The place of the marks that is flown to. */
  placeAt = 0;
  #places: { of: Elements; model: Cloth; all: Elements[] } | null = null;

  constructor(private readonly stage: Stage) {}

  /** Places all markers on the meshes that are drawn, in space, on the UV plane, or both. */
  place(roles: Role[], ways: boolean[]): void {
    for (const flat of ways) this.#placeIn(roles, flat);
  }

  /** Elements of the model that the pointer is on, on one of the meshes. */
  carried(model: Cloth, cloth: Cloth, elements: Elements): Elements {
    return this.#hovers.of(model, cloth, elements);
  }

  #placeIn(roles: Role[], flat: boolean): void {
    const { stage } = this;
    const markers = stage.markersOf(flat);
    const marked = this.onMarked;
    if (marked) markers.marked = marked.role;
    markers.marks.setColour(this.marked?.isCrossing ? CROSSING : MARK);
    placeMarks(markers.marks, marked?.cloth, marked?.elements ?? null, flat);
    for (const [role, marks] of Object.entries(markers.selections) as [Role, Marks][]) {
      const found = this.selected && roles.includes(role) ? this.#on(role, this.selected, this.#selections) : null;
      placeMarks(marks, found?.cloth, found?.elements ?? null, flat);
    }
    const shown = roles.flatMap((role) => stage.cloths.get(role) ?? []);
    placeGlow(markers.glow, shown, this.highlighted, flat);
  }

  /** The marked elements on their mesh; null while it is not there. */
  get onMarked(): OnCloth | null {
    return this.marked && this.#on(this.marked.role, this.marked.elements, this.#marks);
  }

  /** The connected places of the marks, the largest first. */
  get places(): Elements[] {
    const [of, model] = [this.marked?.elements, this.stage.cloths.get("model")];
    if (!of || !model) return [];
    if (this.#places?.of !== of || this.#places.model !== model) this.#places = { of, model, all: placesIn(model, of) };
    return this.#places.all;
  }

  /** The place that is flown to, on the mesh of the marks. */
  get onPlace(): OnCloth | null {
    const place = this.places[this.placeAt];
    return this.marked && (place ? this.#on(this.marked.role, place, this.#hovers) : this.onMarked);
  }

  #on(role: Role, elements: Elements, carrying: Carrying): OnCloth | null {
    const [model, cloth] = [this.stage.cloths.get("model"), this.stage.cloths.get(role)];
    if (!model || !cloth) return null;
    const all = carrying.of(model, cloth, elements);
    return { role, cloth, elements: cloth.isIsolated ? drawnOf(cloth, all) : all };
  }
}
