// The place of the garment on the way of the fit: asks for one after the last one has come.

import type { FitMessage } from "../server/protocol";
import { findingsIn } from "./garment";
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

  receive({ warning, ...place }: FitMessage): void {
    const { fit, marked } = this.store.state;
    const [finding = null] = findingsIn(warning ? [warning] : [], "model");
    const isMarked = marked !== null && marked === fit?.finding;
    this.store.update({ fit: { ...place, finding }, ...(isMarked ? { marked: finding } : {}) });
    this.#isAsked = false;
    const next = this.#next;
    this.#next = null;
    if (next !== null) this.show(next);
    this.mark();
  }

  /** Marks what crosses the body on the large mesh. Another warning that is marked stays so. */
  mark(): void {
    const { fit, marked, settings } = this.store.state;
    if (!fit || (marked && marked !== fit.finding)) return;
    const elements = fit.finding?.elements;
    this.store.view?.mark(elements ? { role: settings.large, elements, isCrossing: true } : null, false);
  }

  /** The server forgets what was asked for when the connection is lost, and a garment that is read anew may have no way. */
  reset(): void {
    this.#isAsked = false;
    this.#next = null;
    const { fit, marked } = this.store.state;
    if (fit?.finding && !marked) this.store.view?.mark(null);
    this.store.update({ fit: null });
  }
}
