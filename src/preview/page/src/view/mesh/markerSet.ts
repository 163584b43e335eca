// The markers on all meshes, seen in one way: in space, or on the UV plane.

import type { Role } from "../../server/protocol";
import { ACCENT, MARK, SELECTED } from "../shade/colours";
import { FAINT, Marks, THROUGH } from "./marks";

export class MarkerSet {
  readonly marks = new Marks(MARK, 4, THROUGH);
  /** The mesh that the marks are on. */
  marked: Role = "model";
  readonly glow = new Marks(ACCENT, 4, THROUGH);
  /** The selection on each mesh. */
  readonly selections: Record<Exclude<Role, "body">, Marks> = {
    model: new Marks(SELECTED, 5, FAINT),
    sim: new Marks(SELECTED, 5, FAINT),
    render: new Marks(SELECTED, 5, FAINT),
  };
  readonly all: Marks[] = [...Object.values(this.selections), this.marks, this.glow];

  /** Shows what belongs to the meshes of a column, of which the last is solid; none for null. */
  show(roles: Role[] | null): void {
    for (const each of this.all) each.object.visible = roles !== null;
    if (!roles) return;
    this.marks.object.visible = roles.includes(this.marked);
    for (const [role, marks] of Object.entries(this.selections)) marks.object.visible = role === roles.at(-1);
  }
}
