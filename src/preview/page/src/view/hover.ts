// Watches what the pointer rests on. One look is under way at a time, and none while the camera moves.

import type { Picked, ViewEvents } from "./api";
import type { Place } from "./input";
import { describe } from "./picking";
import type { Picker, Spot } from "./picking";

export class Hover {
  #at: Place | null = null;
  #looking = false;
  #again = false;
  #frame = 0;
  #last = "";
  #sets = "";
  /** The face at the pointer, and the place where it was found. */
  #found: { at: Place; face: number } | null = null;

  constructor(
    private readonly picker: Picker,
    private readonly spotAt: (at: Place) => Spot | null,
    private readonly tell: ViewEvents["hover"],
    private readonly warm: (sets: string[]) => void,
  ) {}

  moveTo(at: Place | null): void {
    this.#at = at;
    if (at) this.look();
    else this.#set(null);
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

  /** The drawn face at a spot, or -1; known already if the pointer rests there. */
  faceAt(spot: Spot): number {
    const { x, y } = spot.at;
    if (this.#found && this.#found.at.x === x && this.#found.at.y === y) return this.#found.face;
    return this.picker.face(spot);
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
    const face = await this.picker.faceLater(spot).catch(() => -1);
    this.#looking = false;
    if (this.#at) this.#take(spot, face);
    if (this.#again) this.look();
    this.#again = false;
  }

  #take(spot: Spot, face: number): void {
    this.#found = { at: spot.at, face };
    this.#set(face >= 0 && face < spot.cloth.faceCount ? describe(spot, face) : null);
  }

  #set(picked: Picked | null): void {
    const key = picked ? `${picked.role} ${picked.face} ${picked.edge?.join("-") ?? ""}` : "";
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
