// Draws the picture at rest: one sample in a frame of animation, and none while the graphics card has work to do.

import type { WebGLRenderer } from "three";
import { Mean } from "./mean";
import { sampleAt, SAMPLES } from "./samples";
import type { Sample } from "./samples";

/** Time without a change after which the picture is at rest: at least so long [ms], and so many times as long as a sample takes.
 *  Edits of a drag come that far apart where drawing is slow, and a sample between two of them would hold up the next. */
const REST = 150;
const REST_SAMPLES = 3;
/** Samples from which on their mean is better than a plain picture. */
const ENOUGH = 4;
/** Time that the samples of a picture may take: without a graphics card, one of them may need a second. [ms] */
const PATIENCE = 3000;

/** Draws one sample in parts, after each of which the graphics card is waited for. */
export type Draw = (mean: Mean, sample: Sample) => Generator<void>;

export class Still {
  /** Samples in the picture on the canvas; 0 for a plain one. */
  count = 0;
  #next = 0;
  /** Samples of this picture. */
  #total = SAMPLES;
  /** What is left of the sample that is being drawn. */
  #parts: Generator<void> | null = null;
  #isDraft = false;
  /** When the last sample began, 0 for none of this picture, and how long one takes. [ms] */
  #began = 0;
  #duration = 0;
  #timer = 0;
  #frame = 0;
  #fence: WebGLSync | null = null;
  #mean: Mean | null = null;

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly draw: Draw,
    /** Draws a plain picture in place of a draft. */
    private readonly sharpen: () => void,
    /** Hears whether the picture on the canvas is the last one. */
    private readonly tell: (isFinal: boolean) => void,
  ) {}

  /** A plain picture was drawn, and the next one may be the same. */
  restart(isDraft: boolean): void {
    this.stop();
    this.#isDraft = isDraft;
    const rest = Math.max(REST, (isDraft ? 1 : REST_SAMPLES) * this.#duration);
    const fits = Mean.fits(this.renderer);
    this.tell(!fits);
    if (fits) this.#timer = window.setTimeout(() => this.#await(), rest);
  }

  stop(): void {
    clearTimeout(this.#timer);
    cancelAnimationFrame(this.#frame);
    this.count = 0;
    this.#next = 0;
    this.#began = 0;
    this.#parts = null;
  }

  /** Draws what is left of `count` samples at once. Without the means for it, the canvas is as it was. */
  finish(count = SAMPLES): void {
    if (!Mean.fits(this.renderer)) return;
    clearTimeout(this.#timer);
    cancelAnimationFrame(this.#frame);
    // Lights of another count are spread otherwise.
    if (count !== this.#total) this.#next = 0;
    this.#total = count;
    this.#parts = null;
    while (this.#next < count) this.#add();
    this.#show();
  }

  #await(): void {
    this.#frame = requestAnimationFrame(() => this.#step());
  }

  #step(): void {
    if (!this.#isIdle()) return this.#await();
    if (this.#isDraft) {
      this.#isDraft = false;
      this.sharpen();
      this.#watch();
      return this.#await();
    }
    if (this.#next === 0) this.#total = Math.max(ENOUGH, Math.min(SAMPLES, Math.floor(PATIENCE / this.#duration)));
    if (!this.#add()) return this.#await();
    if (this.#next >= ENOUGH) this.#show();
    if (this.#next < this.#total) this.#await();
  }

  /** Draws the next part of a sample. Returns whether it was the last one. */
  #add(): boolean {
    const mean = this.#sized();
    if (!this.#parts) {
      if (this.#next === 0) mean.restart();
      this.#began = performance.now();
      this.#parts = this.draw(mean, sampleAt(this.#next, this.#total));
    }
    const isDone = this.#parts.next().done === true;
    this.#watch();
    if (!isDone) return false;
    mean.add();
    this.#next += 1;
    this.#parts = null;
    return true;
  }

  #watch(): void {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.#fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  }

  #show(): void {
    this.#mean?.show(null);
    this.count = this.#next;
    this.tell(this.#next >= this.#total);
  }

  /** Whether the last part is done, so that a change has to wait for one at most. */
  #isIdle(): boolean {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (!this.#fence || gl.isContextLost()) return true;
    if (gl.getSyncParameter(this.#fence, gl.SYNC_STATUS) !== gl.SIGNALED) return false;
    gl.deleteSync(this.#fence);
    this.#fence = null;
    // The last sample of a picture is not watched to its end.
    if (!this.#parts && this.#began > 0) this.#duration = performance.now() - this.#began;
    return true;
  }

  #sized(): Mean {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = this.renderer.getContext();
    if (this.#mean?.width === width && this.#mean.height === height) return this.#mean;
    this.#mean?.dispose();
    this.#next = 0;
    this.#parts = null;
    this.#mean = new Mean(this.renderer, width, height);
    return this.#mean;
  }
}
