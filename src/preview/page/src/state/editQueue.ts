// Sends edits, at most one in the time of a frame, and knows which answers of the server are older than what was sent.

import type { Options } from "../server/options";
import type { PageMessage } from "../server/protocol";

interface Pending {
  edits: Options;
  gesture: string;
  /** Time of the input event. [ms since 1970] */
  input: number;
}

/** Shortest time between two messages. A picture that is slow to draw does not hold them back. [ms] */
const PAUSE = 16;

export class EditQueue {
  #serial = 0;
  #pending: Pending | null = null;
  #inputs = new Map<number, number>();
  #sent = -Infinity;

  constructor(private readonly send: (message: PageMessage) => void) {}

  push(edits: Options, gesture: string, input: number): void {
    // The last state of one gesture must not vanish in the next one, since undo goes back to it.
    if (this.#pending && this.#pending.gesture !== gesture) this.flush();
    const wait = this.#sent + PAUSE - performance.now();
    if (!this.#pending && wait > 0) setTimeout(() => this.flush(), wait);
    this.#pending = { edits, gesture, input };
    if (wait <= 0) this.flush();
  }

  flush(): void {
    if (!this.#pending) return;
    const { edits, gesture, input } = this.#pending;
    this.#pending = null;
    this.#sent = performance.now();
    this.#serial += 1;
    this.#inputs.set(this.#serial, input);
    this.#inputs.delete(this.#serial - 200);
    this.send({ type: "edit", serial: this.#serial, gesture, edits });
  }

  /** Whether a document with this serial lacks edits that were made here. */
  isBehind(serial: number): boolean {
    return this.#pending !== null || serial < this.#serial;
  }

  inputOf(serial: number): number | undefined {
    return this.#inputs.get(serial);
  }

  /** A new connection counts from the start. */
  reset(): void {
    this.#serial = 0;
    this.#pending = null;
    this.#inputs.clear();
  }
}
