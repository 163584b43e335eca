// The colours of values, and the scales that they are on.

import type { DrawnValues } from "../../server/protocol";
import type { Rgb } from "./colours";

/** From the least value, at 0, to the most, at 1. */
export interface Scale {
  least: number;
  most: number;
  /** The middle is the value to have, and the scale is logarithmic. */
  isAboutIdeal: boolean;
}

/** Of quality figures and of weights the scale is fixed, so that pictures compare. */
export function scaleOf({ name, least, most }: DrawnValues): Scale {
  if (name === "quality:length") return { least: 0.5, most: 2, isAboutIdeal: true };
  if (name === "quality:angle") return { least: 0, most: 60, isAboutIdeal: false };
  const isShare = least >= 0 && most <= 1;
  return { least: isShare ? 0 : least, most: isShare ? 1 : most, isAboutIdeal: false };
}

/** Where a value is on the scale. */
export function shareOf(value: number, { least, most, isAboutIdeal }: Scale): number {
  if (isAboutIdeal) return Math.log(Math.max(value, 1e-20) / least) / Math.log(most / least);
  return (value - least) / Math.max(most - least, 1e-20);
}

/** The value at a place of the scale. */
export function valueAt(share: number, { least, most, isAboutIdeal }: Scale): number {
  return isAboutIdeal ? least * (most / least) ** share : least + share * (most - least);
}

/** Below, at and above the ideal. [sRGB] */
export const ABOUT_IDEAL: readonly Rgb[] = [
  [0.13, 0.35, 0.72],
  [0.93, 0.92, 0.9],
  [0.76, 0.22, 0.11],
];

/** Viridis, as polynomials fitted by Matt Zucker. [sRGB] */
export const HEAT: readonly (readonly [number, number, number])[] = [
  [0.2777273272, 0.0054073445, 0.3340998053],
  [0.1050930431, 1.4046135299, 1.3845901627],
  [-0.3308618287, 0.2148475595, 0.0950951630],
  [-4.6342304989, -5.7991009734, -19.3324409563],
  [6.2282699363, 14.1799333668, 56.6905526007],
  [4.7763849977, -13.7451453774, -65.3530326334],
  [-5.4354558559, 4.6458526122, 26.3124352496],
];

/** The colour at a place of the scale. */
export function heatCss(share: number, { isAboutIdeal }: Scale): string {
  const at = Math.min(1, Math.max(0, share));
  const channels = [0, 1, 2].map((channel) => (isAboutIdeal ? aboutIdeal(at, channel) : viridis(at, channel)));
  return `rgb(${channels.map((value) => Math.round(255 * Math.min(1, Math.max(0, value)))).join(" ")})`;
}

function viridis(at: number, channel: number): number {
  return HEAT.reduceRight((sum, term) => sum * at + term[channel], 0);
}

function aboutIdeal(at: number, channel: number): number {
  const [low, middle, high] = ABOUT_IDEAL.map((colour) => colour[channel]);
  return middle + Math.abs(2 * at - 1) * ((at < 0.5 ? low : high) - middle);
}
