// The colours of the view. Those of sets are equally light, and neighbours in the list differ in hue.

import type { PickedSet } from "../api";

export type Rgb = readonly [number, number, number];
export type Theme = "light" | "dark";

/** Of highlighted sets, of marks, of faces that cross a body, of the selection. [sRGB] */
export const ACCENT: Rgb = [0.13, 0.75, 1];
export const MARK: Rgb = [1, 0.55, 0.1];
export const CROSSING: Rgb = [0.95, 0.1, 0.12];
export const SELECTED: Rgb = [1, 0.85, 0.1];

/** What the shaders take of a theme. [sRGB] */
export interface Look {
  top: Rgb;
  bottom: Rgb;
  /** Outline of the UV square, and the ground. */
  line: Rgb;
}

export const LOOKS: Record<Theme, Look> = {
  light: { top: [0.985, 0.985, 0.98], bottom: [0.875, 0.885, 0.895], line: [0.4, 0.43, 0.47] },
  dark: { top: [0.165, 0.175, 0.19], bottom: [0.085, 0.09, 0.1], line: [0.55, 0.6, 0.66] },
};

/** Wires of a mesh that lies over another. [sRGB] */
export const OVERLAYS: Record<string, Rgb> = {
  model: [0.85, 0.32, 0.08],
  sim: [0.0, 0.33, 0.42],
  render: [0.36, 0.22, 0.62],
  body: [0.5, 0.45, 0.42],
};

const GOLDEN_ANGLE = 137.508;

const KINDS = ["edge", "face", "point"];
const BY_NAME = new Intl.Collator("en", { numeric: true });

/** Places of the garment's sets in its sorted list. */
let places = new Map<string, number>();

/** Gives the sets of a garment their colours, which follow from the list alone and so are the same in every run. */
export function placeSets(sets: readonly PickedSet[]): void {
  places = new Map(sortSets(sets).map(({ name }, place) => [name, place]));
}

/** By kind, then by name. */
export function sortSets<T extends PickedSet>(sets: readonly T[]): T[] {
  const kind = (set: T) => KINDS.indexOf(set.kind);
  return [...sets].sort((a, b) => kind(a) - kind(b) || BY_NAME.compare(a.name, b.name));
}

/** The colour of a set. That of a set which a build made follows from its name. [sRGB] */
export function setColour(name: string): Rgb {
  const number = places.get(name) ?? numberOf(name);
  const light = [0.72, 0.66, 0.78][number % 3];
  return oklch(light, number % 2 ? 0.115 : 0.14, 25 + number * GOLDEN_ANGLE);
}

/** A number below 360. */
function numberOf(name: string): number {
  return [...name].reduce((sum, letter) => (31 * sum + (letter.codePointAt(0) ?? 0)) % 360_007, 7) % 360;
}

export function css(colour: Rgb): string {
  return `#${colour.map((value) => bytes(value).toString(16).padStart(2, "0")).join("")}`;
}

/** A channel as an integer from 0 to 255. */
export function bytes(channel: number): number {
  return Math.round(255 * Math.min(1, Math.max(0, channel)));
}

function oklch(lightness: number, chroma: number, degrees: number): Rgb {
  const hue = (degrees * Math.PI) / 180;
  const a = chroma * Math.cos(hue);
  const b = chroma * Math.sin(hue);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    encode(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    encode(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    encode(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

/** From linear to sRGB. */
export function encode(linear: number): number {
  const value = Math.min(1, Math.max(0, linear));
  return value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
}
