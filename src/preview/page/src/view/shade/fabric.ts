// What cloth is made of: its colour, how rough it is, and its weave.

import type { LookInfo } from "../../server/protocol";
import type { Fabric, Weave } from "../api";
import type { ElementSet } from "../mesh/sets";
import { bytes, encode } from "./colours";
import type { Rgb } from "./colours";

/** Of cloth without a colour of its own. [sRGB] */
export const CLOTH: Rgb = [0.655, 0.692, 0.745];
export const ROUGHNESS = 0.8;

/** Numbers in the shader. */
export const WEAVES: Record<Weave, number> = { none: 0, plain: 1, twill: 2, knit: 3 };

/** Distance of two threads, or of two stitches, of coarse cloth. [metres] */
const PITCHES: Record<Weave, number> = { none: 1, plain: 0.0022, twill: 0.0018, knit: 0.004 };

/** Distance of two threads. [mesh units] */
export function pitch(weave: Weave, metersPerUnit: number): number {
  return PITCHES[weave] / Math.max(metersPerUnit, 1e-9);
}

/** The colour that was chosen. [sRGB] */
export function chosen({ colour }: Fabric): Rgb {
  const number = Number.parseInt((colour ?? "").slice(1), 16);
  return Number.isNaN(number) ? CLOTH : [(number >> 16) / 255, ((number >> 8) & 255) / 255, (number & 255) / 255];
}

/** In the fourth channel: the first is the layer of an image in place of a colour. */
export const IMAGE = 128;

/** Fills the table of faces with the looks of the model's materials: the colour or the layer of an image, and in the fourth channel
 *  the roughness, from 0 to 127. */
export function fillLooks(table: Uint8Array, sets: ElementSet[], looks: LookInfo[], layers: string[]): void {
  const row = (look: LookInfo | undefined) => rowOf(look, layers);
  const whole = row(looks.find(({ set }) => set === ""));
  for (let at = 0; at < table.length; at += 4) table.set(whole, at);
  for (const look of looks) {
    const set = sets.find(({ name, kind }) => kind === "face" && name === look.set);
    const own = row(look);
    for (const face of set?.elements ?? []) if (4 * face + 3 < table.length) table.set(own, 4 * face);
  }
}

function rowOf(look: LookInfo | undefined, layers: string[]): number[] {
  const roughness = Math.round((IMAGE - 1) * (look?.roughness ?? ROUGHNESS));
  const layer = layers.indexOf(look?.texture ?? "");
  if (layer >= 0) return [layer, 0, 0, IMAGE + roughness];
  const colour = look?.colour?.map(encode) ?? CLOTH;
  return [...colour.map(bytes), roughness];
}
