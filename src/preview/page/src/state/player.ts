// Plays the cache: asks for frames by the clock, each after the last one has come.

import type { ShotMessage } from "../server/protocol";
import type { Store } from "./store";

export class Player {
  /** The frame that was asked for and has not come. */
  #asked: number | null = null;
  /** The frame and the time at which playing began. [ms] */
  #start = { frame: 0, time: 0 };
  /** A frame that was asked for while another was on its way. */
  #next: number | null | undefined = undefined;

  constructor(private readonly store: Store) {}

  get #shot(): ShotMessage | null {
    return this.store.state.shot;
  }

  toggle(): void {
    if (this.store.state.isPlaying) return this.pause();
    const shot = this.#shot;
    if (!shot || shot.fault) return;
    const isLast = shot.frame === shot.frames - 1;
    this.#start = { frame: isLast ? 0 : (shot.frame ?? 0), time: performance.now() };
    this.store.update({ isPlaying: true });
    this.#ask(this.#start.frame);
  }

  pause(): void {
    this.store.update({ isPlaying: false });
  }

  /** Shows a frame, or the meshes at bind. */
  show(frame: number | null): void {
    this.pause();
    this.#ask(frame);
  }

  step(by: number): void {
    const shot = this.#shot;
    if (!shot || shot.fault) return;
    this.show(Math.min(shot.frames - 1, Math.max(0, (shot.frame ?? 0) + by)));
  }

  receive(shot: ShotMessage): void {
    this.store.update({ shot, ...(shot.fault ? { isPlaying: false } : {}) });
    if (this.#asked !== null && shot.frame !== this.#asked && !shot.fault) return;
    this.#asked = null;
    if (this.#next !== undefined) return this.#ask(this.#next);
    if (this.store.state.isPlaying) requestAnimationFrame(() => this.#advance());
  }

  /** The server forgets what was asked for when the connection is lost. */
  reset(): void {
    this.#asked = null;
    this.#next = undefined;
    this.store.update({ shot: null, isPlaying: false });
  }

  /** The frame of the clock, in a loop. */
  #advance(): void {
    const shot = this.#shot;
    if (!shot || !this.store.state.isPlaying) return;
    const { frame, time } = this.#start;
    const passed = Math.floor(((performance.now() - time) * shot.rate) / 1000);
    const now = (frame + passed) % shot.frames;
    if (now === shot.frame) requestAnimationFrame(() => this.#advance());
    else this.#ask(now);
  }

  #ask(frame: number | null): void {
    if (this.#asked !== null) {
      this.#next = frame;
      return;
    }
    this.#next = undefined;
    if (frame === this.#shot?.frame && !this.store.state.isPlaying) return;
    this.#asked = frame;
    this.store.send({ type: "pose", frame });
    if (frame === this.#shot?.frame) this.receive(this.#shot);
  }
}
