// Where the cameras go: each way in which the meshes are seen, in space or on the UV plane, has its own.

import type { Role } from "../server/protocol";
import type { Side } from "./api";
import { isInView, poseOfAll, poseOfMarks, poseOfSets } from "./camera/aims";
import type { Aim, Sight } from "./camera/aims";
import { Cameras } from "./camera/cameras";
import { SIDES } from "./camera/rig";
import { aspectOf } from "./layout";
import type { Column } from "./layout";
import type { Cloth } from "./mesh/cloth";
import type { Elements } from "./mesh/shapes";
import type { Stage } from "./stage";

/** Elements of a mesh. */
export interface Part {
  role: Role;
  elements: Elements;
}

export class Director {
  readonly cameras = new Cameras();

  constructor(
    private readonly stage: Stage,
    private readonly columns: () => Column[],
    private readonly shown: () => Cloth[],
  ) {}

  /** For each way in which the meshes are seen now, whether it is the UV plane. */
  get ways(): boolean[] {
    return [...new Set(this.columns().map(({ flat }) => flat))];
  }

  /** Shows the whole after a change of the columns, from where the camera is. */
  fit(): void {
    for (const sight of this.#sights) this.cameras.fit(sight);
  }

  /** Shows the whole, the first time and while the artist has not moved the camera. */
  begin(): void {
    for (const sight of this.#sights) this.cameras.frame(sight);
  }

  /** Flies to the part, or else to the sets, or else to where everything is in view. */
  frame(part: Part | null, sets: ReadonlySet<string>): void {
    for (const sight of this.#sights) {
      const aim = part && this.#aimAt(sight, part);
      const pose = (aim && poseOfMarks(sight, aim)) ?? poseOfSets(sight, sets);
      if (pose) this.cameras.flyTo(sight.rig, pose);
      else this.cameras.flyToWhole(sight);
    }
  }

  look(side: Side): void {
    for (const sight of this.#sights) this.cameras.flyTo(sight.rig, poseOfAll(sight, SIDES[side]));
  }

  flyTo(part: Part): void {
    for (const sight of this.#sights) {
      const aim = this.#aimAt(sight, part);
      this.cameras.flyTo(sight.rig, aim && poseOfMarks(sight, aim));
    }
  }

  /** Flies to the part where it is out of view. */
  reveal(part: Part): void {
    for (const sight of this.#sights) {
      const aim = this.#aimAt(sight, part);
      if (aim && !isInView(sight, aim)) this.cameras.flyTo(sight.rig, poseOfMarks(sight, aim));
    }
  }

  get #sights(): Sight[] {
    return this.ways.map((flat) => ({
      rig: this.cameras.of(flat),
      space: this.cameras.space,
      aspects: this.#columnsOf(flat).map(aspectOf),
      flat,
      shown: this.shown(),
    }));
  }

  /** Elements of a mesh, seen in its column or else in the first one. */
  #aimAt({ flat }: Sight, { role, elements }: Part): Aim | null {
    const cloth = this.stage.cloths.get(role);
    const all = this.#columnsOf(flat);
    const column = all.find(({ roles }) => roles.includes(role)) ?? all[0];
    return cloth ? { cloth, elements, aspect: aspectOf(column) } : null;
  }

  #columnsOf(flat: boolean): Column[] {
    return this.columns().filter((column) => column.flat === flat);
  }
}
