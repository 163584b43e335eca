// Operators that were made of a selection, which an undo brings back.

import type { Options } from "../server/options";
import { fullName, instanceAt, type Operator } from "./recipe";
import type { Selection } from "./selection";

export class Made {
  readonly #all = new Map<string, { operator: Operator; selection: Selection }>();

  note(operator: Operator, selection: Selection): void {
    this.#all.set(fullName(operator), { operator, selection });
  }

  clear(): void {
    this.#all.clear();
  }

  /** The selection of the operator that is in the first options alone. */
  between(options: Options, others: Options): Selection | null {
    for (const { operator, selection } of this.#all.values()) {
      if (instanceAt(options, operator) && !instanceAt(others, operator)) return selection;
    }
    return null;
  }
}
