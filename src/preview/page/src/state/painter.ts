// Paints weights: for the density, for the folds, for what is smoothed, and pins. A stroke is an edit of one option.

import type { Value } from "../server/options";
import { keysWith } from "./cards";
import { fitting, valueAt } from "./recipe";
import type { Store } from "./store";

const PAINTED = /^painted\("([^"]*)", "([^"]*)"\)$/;
const PINS = "cloth.pins";

export interface Brush {
  /** The option that is painted. */
  key: string;
  /** [mesh units] */
  radius: number;
  strength: number;
  /** The primvar that a first stroke begins with, while its values are on their way. */
  primvar: string | null;
  isReady: boolean;
}

export class Painter {
  /** What the brush has: the text of the option, or of the painted one of the pins. */
  #text: string | null = null;
  #weights: Float32Array | null = null;

  constructor(private readonly store: Store) {}

  /** The options that may be painted, with their words. */
  targets(): { key: string; label: string }[] {
    const folds = this.store.state.document.stack.filter(({ kind }) => kind === "fold");
    return [
      { key: "sim.density", label: "Density" },
      ...folds.map(({ full, name }) => ({ key: `${full}.weights`, label: `Thickness of ${name}` })),
      { key: "sim.smoothWeights", label: "Smoothness" },
      { key: PINS, label: "Pins" },
    ];
  }

  toggle(): void {
    if (this.store.state.brush) this.end();
    else this.take("sim.density");
  }

  /** Paints an option from now on. */
  take(key: string): void {
    const { brush, garment } = this.store.state;
    if (!garment || this.store.state.connection !== "open") return;
    const { radius, strength } = brush ?? { radius: 3 * garment.meanEdge, strength: 0.5 };
    this.#text = null;
    this.store.show({ brush: { key, radius, strength, primvar: null, isReady: false } });
    this.follow();
  }

  end(): void {
    this.store.view?.brush(null);
    this.store.show({ brush: null });
  }

  set(changed: Partial<Pick<Brush, "radius" | "strength">>): void {
    const { brush } = this.store.state;
    if (brush) this.store.update({ brush: { ...brush, ...changed } });
    this.renew();
  }

  /** Takes the weights that the option has now, unless the brush made them. */
  follow(): void {
    const { brush, garment, document } = this.store.state;
    if (!brush || !garment) return;
    const value = valueAt(document.merged, brush.key);
    const text = Array.isArray(value) ? (value.find((each) => PAINTED.test(each)) ?? "") : String(value ?? "");
    if (text === this.#text) return;
    this.#text = text;
    const [, checksum, digits] = PAINTED.exec(text) ?? [];
    if (checksum === garment.checksum) return this.#take(decoded(digits));
    if (text === "") return this.#take(new Float32Array(garment.points).fill(brush.key.endsWith(".weights") ? 1 : 0));
    const isPrimvar = fitting(garment.primvars, "weights").some(({ name }) => name === text);
    if (isPrimvar) this.store.show({ brush: { ...brush, primvar: text, isReady: false } });
    // Weights of a set begin as those that the engine gives it.
    else this.store.selector.find(text, (elements) => text === this.#text && this.#take(this.store.view?.blended(elements) ?? null));
  }

  /** A frame of the model has come: with other faces, or with the values of a primvar. */
  arrived(isNew: boolean): void {
    if (isNew) this.#text = null;
    this.follow();
    const { primvar, isReady } = this.store.state.brush ?? {};
    if (primvar && !isReady) this.#take(this.store.view?.weightsOf(primvar) ?? null);
  }

  /** A stroke has ended. */
  painted(weights: Float32Array): void {
    const { brush, garment, document } = this.store.state;
    if (!brush || !garment) return;
    this.#weights = brush.key === PINS ? weights.map((weight) => (weight > 0.5 ? 1 : 0)) : weights.slice();
    const text = `painted("${garment.checksum}", "${encoded(this.#weights)}")`;
    const others = valueAt(document.merged, PINS);
    const pins = (Array.isArray(others) ? others : []).filter((each) => each !== this.#text);
    const value: Value = brush.key === PINS ? [...pins, text] : text;
    this.#text = text;
    this.store.setAll(keysWith(this.store.state, brush.key).map((key) => ({ key, value })));
    this.renew();
  }

  #take(weights: Float32Array | null): void {
    this.#weights = weights;
    const { brush } = this.store.state;
    if (brush && weights) this.store.show({ brush: { ...brush, primvar: null, isReady: true } });
  }

  /** Gives the brush what it has, after a change of its own or of settings. */
  renew(): void {
    const { brush, settings, garment } = this.store.state;
    if (!brush?.isReady || !this.#weights) return;
    const mirror = settings.symmetric ? (garment?.mirror?.points ?? null) : null;
    this.store.view?.brush({ weights: this.#weights.slice(), radius: brush.radius, strength: brush.strength, mirror });
  }
}

/** Two hexadecimal digits for each weight. */
function encoded(weights: Float32Array): string {
  return Array.from(weights, (weight) => Math.round(255 * weight).toString(16).padStart(2, "0")).join("");
}

function decoded(digits: string): Float32Array {
  return Float32Array.from(digits.match(/../g) ?? [], (pair) => parseInt(pair, 16) / 255);
}
