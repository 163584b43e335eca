// The place of the garment on the way of the fit: asks for one after the last one has come.

import type { FitMessage } from "../server/protocol";
import type { Marked } from "../view/api";
import type { Store } from "./store";

export class Way {
  #isAsked = false;
  /** What was asked for while another was on its way. */
  #next: number | null = null;

  constructor(private readonly store: Store) {}

  show(share: number): void {
    if (this.#isAsked) {
      this.#next = share;
      return;
    }
    this.#isAsked = share !== this.store.state.fit?.share;
    if (this.#isAsked) this.store.send({ type: "fit", share });
  }

  receive(fit: FitMessage): void {
    this.store.update({ fit });
    this.#isAsked = false;
    const next = this.#next;
    this.#next = null;
    if (next !== null) this.show(next);
    // A warning that is marked stays so.
    if (!this.store.state.marked) this.store.view?.mark(marksOf(fit), false);
  }

  /** The server forgets what was asked for when the connection is lost, and a garment that is read anew may have no way. */
  reset(): void {
    this.#isAsked = false;
    this.#next = null;
    this.store.update({ fit: null });
  }
}

function marksOf({ crossings }: FitMessage): Marked | null {
  return crossings.length > 0 ? { role: "model", elements: { faces: crossings }, isCrossing: true } : null;
}
