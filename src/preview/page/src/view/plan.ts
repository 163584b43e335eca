// What is written on flat panels: their names, and how long things are.

import { Vector3 } from "three";
import type { Plan, PlanColumn } from "./api";
import type { Rig } from "./camera/rig";
import type { Column } from "./layout";
import type { Cloth } from "./mesh/cloth";
import type { ElementSet } from "./mesh/sets";
import { toCanvas } from "./picking";

/** The sets of the server that hold a UV shell each. */
const SHELL = /^uvShells\.(\d+)$/;
/** A set that has more of other panels than of this one is not its name. */
const MOST_BESIDE = 2;

interface Panel {
  name: string;
  /** One of its faces, as drawn. */
  face: number;
  /** Its lower and its upper corner on the UV plane. */
  low: [number, number];
  high: [number, number];
}

/** Remembers the panels, since the camera moves more often than UVs change. */
export class Planner {
  #known: { uvs: Float32Array; sets: ElementSet[]; panels: Panel[] } | null = null;

  /** `clothOf` is the mesh that a column shows. */
  plan(model: Cloth | undefined, columns: Column[], clothOf: (column: Column) => Cloth | undefined, rig: Rig): Plan {
    const panels = model ? this.#panels(model).filter(({ face }) => model.isDrawn(face)) : [];
    return columns.flatMap((column) => {
      const cloth = clothOf(column);
      return cloth?.hasUvs ? [planOf(column, cloth, panels, rig)] : [];
    });
  }

  #panels(model: Cloth): Panel[] {
    const { uvs, sets } = model;
    if (this.#known?.uvs !== uvs || this.#known.sets !== sets) this.#known = { uvs, sets, panels: panelsOf(model) };
    return this.#known.panels;
  }
}

function planOf({ x, y, width, height, ...column }: Column, cloth: Cloth, panels: Panel[], rig: Rig): PlanColumn {
  rig.place(width / height);
  const onCanvas = (u: number, v: number) => toCanvas(new Vector3(u, v, 0).project(rig.camera), { x, y, width, height, ...column });
  const unit = onCanvas(1, 0).x - onCanvas(0, 0).x;
  const boxes = panels.map(({ name, low, high }) => {
    const size = { width: (high[0] - low[0]) * unit, height: (high[1] - low[1]) * unit };
    return { name, ...onCanvas(low[0], high[1]), ...size };
  });
  return { x, y, width, height, panels: boxes, unit: cloth.uvLength > 0 ? unit / cloth.uvLength : 0 };
}

function panelsOf(model: Cloth): Panel[] {
  if (!model.hasUvs) return [];
  const faceSets = model.sets.filter(({ kind }) => kind === "face");
  const shells = faceSets.filter(({ name }) => SHELL.test(name));
  const all = shells.length > 0 ? shells : faceSets.filter(({ name }) => name === "uvShells");
  const named = faceSets.filter(({ family }) => family !== "materialBind" && !family.startsWith("tailor"));
  return all.map((shell) => ({ name: nameOf(shell, named), face: shell.elements[0], ...placeOf(model, shell.elements) }));
}

/** The smallest face set that covers the panel, or else the number of the UV shell. */
function nameOf({ name, elements }: ElementSet, named: ElementSet[]): string {
  const covers = (set: ElementSet) => {
    const faces = new Set(set.elements);
    return elements.every((face) => faces.has(face));
  };
  const { length } = elements;
  const fits = (set: ElementSet) => set.elements.length >= length && set.elements.length < MOST_BESIDE * length;
  const covering = named.filter((set) => fits(set) && covers(set));
  const least = Math.min(...covering.map((set) => set.elements.length));
  const found = covering.find((set) => set.elements.length === least);
  return found?.name ?? `UV shell ${SHELL.exec(name)?.[1] ?? 1}`;
}

/** How far the corners reach. */
function placeOf({ faces, uvs }: Cloth, shell: Uint32Array): Pick<Panel, "low" | "high"> {
  const [low, high]: [number, number][] = [[Infinity, Infinity], [-Infinity, -Infinity]];
  for (const face of shell) {
    for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
      for (const axis of [0, 1]) {
        low[axis] = Math.min(low[axis], uvs[2 * corner + axis]);
        high[axis] = Math.max(high[axis], uvs[2 * corner + axis]);
      }
    }
  }
  return { low, high };
}
