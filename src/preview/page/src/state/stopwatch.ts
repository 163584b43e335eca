// How long it takes from an input event until the new mesh is drawn.

import type { MeshFrame } from "../server/frame";
import type { Role } from "../server/protocol";

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
  /** From the input event until the buffers were replaced, if it is known. */
  replaced: number | null;
  /** From the input event if it is known, else the sum of the parts. */
  total: number;
}

const KEPT = 200;

export class Stopwatch {
  readonly timing: Timing[] = [];
  #edited = new Map<number, number>();
  #revision = -1;
  #command: number | null = null;
  /** Revisions that were counted. A later frame of one comes from the view, not from an edit. */
  #counted = new Map<Role, number>();
  #frames = new Map<Role, { frame: MeshFrame; replaced: number }>();

  /** An undo or another message without a serial was sent. */
  command(): void {
    this.#command = performance.timeOrigin + performance.now();
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

  /** The view took a frame. */
  replaced(frame: MeshFrame): void {
    this.#frames.set(frame.header.role, { frame, replaced: performance.timeOrigin + performance.now() });
  }

  /** Null if the frame is not known or was counted before. */
  drawn(role: Role, revision: number, upload: number): Timing | null {
    const known = this.#frames.get(role);
    if (!known || known.frame.header.revision !== revision) return null;
    const { frame } = known;
    this.#frames.delete(role);
    const { build, encode, sent } = frame.header.times;
    const transfer = Math.max(0, frame.received - sent);
    const edited = this.#counted.get(role) === revision ? null : (this.#edited.get(revision) ?? null);
    this.#counted.set(role, revision);
    const now = performance.timeOrigin + performance.now();
    const total = edited === null ? build + encode + transfer + upload : now - edited;
    const replaced = edited === null ? null : known.replaced - edited;
    const timing = { role, revision, edited, build, encode, transfer, upload, replaced, total };
    this.timing.push(timing);
    if (this.timing.length > KEPT) this.timing.shift();
    return timing;
  }
}
