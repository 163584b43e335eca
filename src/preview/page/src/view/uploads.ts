// The time that new buffers take, from a frame's arrival to the picture that shows them.

import type { Role } from "../server/protocol";
import type { ViewEvents } from "./api";

export class Uploads {
  /** Buffers that were not drawn yet. */
  readonly #pending = new Map<Role, { revision: number; time: number }>();

  add(role: Role, revision: number, time: number): void {
    this.#pending.set(role, { revision, time: time + (this.#pending.get(role)?.time ?? 0) });
  }

  forget(role: Role): void {
    this.#pending.delete(role);
  }

  /** They were drawn, which took this long. */
  tell(drawn: ViewEvents["drawn"], time: number): void {
    const all = [...this.#pending];
    this.#pending.clear();
    for (const [role, made] of all) drawn(role, made.revision, made.time + time);
  }
}
