// Watches what the pointer rests on. One look is under way at a time, and none while the camera moves.

import type { Picked } from "./api";
import type { Place } from "./input";
import { describe, NOTHING } from "./picking";
import type { Picker, Seen, Spot } from "./picking";

export class Hover {
  #at: Place | null = null;
  /** How often the pointer left. A look that began before that is of an earlier place. */
  #left = 0;
  #looking = false;
  #again = false;
  #frame = 0;
  #last = "null";
  #sets = "";
  /** What is at the pointer, and the place where it was found. */
  #found: { at: Place; seen: Seen } | null = null;

  constructor(
    private readonly picker: Picker,
    private readonly spotAt: (at: Place) => Spot | null,
    private readonly tell: (picked: Picked | null) => void,
    private readonly warm: (sets: string[]) => void,
  ) {}

  moveTo(at: Place | null): void {
    this.#at = at;
    if (at) return this.look();
    this.#left += 1;
    this.#set(null);
  }

  /** The picture changed, so what was found holds no longer. */
  forget(): void {
    this.#found = null;
  }

  /** Looks again in the next frame. */
  look(): void {
    if (!this.#at) return;
    this.#frame ||= requestAnimationFrame(() => {
      this.#frame = 0;
      void this.#look();
    });
  }

  /** What is drawn at a spot; known already if the pointer rests there. */
  seenAt(spot: Spot): Seen {
    const { x, y } = spot.at;
    if (this.#found && this.#found.at.x === x && this.#found.at.y === y) return this.#found.seen;
    return this.picker.look(spot);
  }

  async #look(): Promise<void> {
    if (this.#looking) {
      this.#again = true;
      return;
    }
    const at = this.#at;
    const spot = at && this.spotAt(at);
    if (!at || !spot) return this.#set(null);
    this.#looking = true;
    const left = this.#left;
    const seen = await this.picker.lookLater(spot).catch(() => NOTHING);
    this.#looking = false;
    if (this.#at && left === this.#left) this.#take(spot, seen);
    if (this.#again) this.look();
    this.#again = false;
  }

  #take(spot: Spot, seen: Seen): void {
    this.#found = { at: spot.at, seen };
    this.#set(seen.face < 0 ? null : describe(spot, seen));
  }

  #set(picked: Picked | null): void {
    const key = JSON.stringify(picked && { ...picked, x: 0, y: 0 });
    if (key !== this.#last) {
      this.#last = key;
      this.tell(picked);
    }
    const all = picked?.sets.filter(({ kind }) => kind === "edge").map(({ name }) => name) ?? [];
    // Of a set and its pieces, the piece is what is under the pointer.
    const sets = all.filter((name) => !all.some((other) => other.startsWith(`${name}.`)));
    if (sets.join() === this.#sets) return;
    this.#sets = sets.join();
    this.warm(sets);
  }
}
