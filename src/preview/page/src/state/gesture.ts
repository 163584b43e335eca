// Gestures: changes of one drag, or of one run of arrow keys, share one.

/** Longest pause in a run of key presses. [ms] */
const PAUSE = 500;

/** Keeps the gestures of pages apart. */
const PAGE = Math.random().toString(36).slice(2, 8);

export class Gestures {
  #count = 0;
  #lastKey = -Infinity;
  #isDown = false;
  /** Time of the last input event. [ms since 1970] */
  input = performance.timeOrigin;

  constructor() {
    const listen = (type: string, act: (event: Event) => unknown) =>
      addEventListener(
        type,
        (event) => {
          this.input = performance.timeOrigin + event.timeStamp;
          act(event);
        },
        { capture: true, passive: true },
      );
    listen("pointerdown", () => {
      this.next();
      this.#isDown = true;
    });
    // The focus that a press brings comes after the slider's first input.
    listen("focusin", () => this.#isDown || this.next());
    listen("pointercancel", () => (this.#isDown = false));
    listen("pointerup", () => (this.#isDown = false));
    listen("input", () => undefined);
    listen("change", () => undefined);
    listen("keydown", (event) => {
      // A page that draws slowly gets the repeats of a held key late.
      const isHeld = event instanceof KeyboardEvent && event.repeat;
      if (!isHeld && event.timeStamp - this.#lastKey > PAUSE) this.next();
      this.#lastKey = event.timeStamp;
    });
  }

  /** The gesture that goes on. */
  get current(): string {
    return `${PAGE}-${this.#count}`;
  }

  /** A new gesture, for changes that are a step each. */
  next(): string {
    this.#count += 1;
    return this.current;
  }
}
