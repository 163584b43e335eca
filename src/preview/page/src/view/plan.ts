// What is written on flat panels: their names, and how long things are.

import { Box2, Vector2, Vector3 } from "three";
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
  /** On the UV plane. */
  box: Box2;
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
  const boxes = panels.map(({ name, box: { min, max } }) => {
    const size = { width: (max.x - min.x) * unit, height: (max.y - min.y) * unit };
    return { name, ...onCanvas(min.x, max.y), ...size };
  });
  return { x, y, width, height, panels: boxes, unit: cloth.uvLength > 0 ? unit / cloth.uvLength : 0 };
}

function panelsOf(model: Cloth): Panel[] {
  if (!model.hasUvs) return [];
  const faceSets = model.sets.filter(({ kind }) => kind === "face");
  const shells = faceSets.filter(({ name }) => SHELL.test(name));
  const all = shells.length > 0 ? shells : faceSets.filter(({ name }) => name === "uvShells");
  const named = faceSets.filter(({ family }) => family !== "materialBind" && !family.startsWith("tailor"));
  return all.map((shell) => ({ name: nameOf(shell, named), face: shell.elements[0], box: boxOf(model, shell.elements) }));
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
function boxOf({ faces, uvs }: Cloth, shell: Uint32Array): Box2 {
  const [box, corner] = [new Box2(), new Vector2()];
  for (const face of shell) {
    for (let at = faces.starts[face]; at < faces.starts[face + 1]; at++) box.expandByPoint(corner.fromArray(uvs, 2 * at));
  }
  return box;
}
