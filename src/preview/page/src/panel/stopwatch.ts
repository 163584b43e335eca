// How long it takes from an input event until the new mesh is drawn.

import type { MeshFrame, Role } from "../protocol";

/** All in milliseconds. */
export interface Timing {
  role: Role;
  revision: number;
  /** When the input event came, since 1970; null if another page or the file changed. */
  edited: number | null;
  build: number;
  encode: number;
  transfer: number;
  upload: number;
  /** From the input event if it is known, else the sum of the parts. */
  total: number;
}

const KEPT = 200;

export class Stopwatch {
  readonly timing: Timing[] = [];
  #edited = new Map<number, number>();
  #revision = -1;
  #command: number | null = null;
  #frames = new Map<Role, MeshFrame>();

  /** An undo or another message without a serial was sent. */
  command(input: number): void {
    this.#command = input;
  }

  /** A revision of the document is there; `input` is the time of the last edit of this page in it. */
  revision(revision: number, input: number | undefined): void {
    if (revision === this.#revision) return;
    this.#revision = revision;
    const edited = this.#command ?? input;
    this.#command = null;
    if (edited !== undefined) this.#edited.set(revision, edited);
    this.#edited.delete(revision - KEPT);
  }

  received(frame: MeshFrame): void {
    this.#frames.set(frame.header.role, frame);
  }

  /** Null if the frame is not known or was counted before. */
  drawn(role: Role, revision: number, upload: number): Timing | null {
    const frame = this.#frames.get(role);
    if (!frame || frame.header.revision !== revision) return null;
    this.#frames.delete(role);
    const { build, encode, sent } = frame.header.times;
    const transfer = Math.max(0, frame.received - sent);
    const edited = this.#edited.get(revision) ?? null;
    const now = performance.timeOrigin + performance.now();
    const total = edited === null ? build + encode + transfer + upload : now - edited;
    const timing = { role, revision, edited, build, encode, transfer, upload, total };
    this.timing.push(timing);
    if (this.timing.length > KEPT) this.timing.shift();
    return timing;
  }
}
