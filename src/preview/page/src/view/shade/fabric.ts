// What cloth is made of: its colour or an image, how rough it is, and its relief.

import { TextureLoader, Vector3 } from "three";
import type { IUniform, Texture } from "three";
import type { LookInfo } from "../../server/protocol";
import type { Fabric, Weave } from "../api";
import type { ElementSet } from "../mesh/sets";
import { bytes, encode } from "./colours";
import type { Rgb } from "./colours";
import { reliefOf, repeated, sizeOfWeave } from "./relief";

/** Of cloth without a colour of its own. [sRGB] */
export const CLOTH: Rgb = [0.655, 0.692, 0.745];
export const ROUGHNESS = 0.8;

/** Edge of an image on the cloth. [m] */
export const IMAGE_SIZE = 0.1;

/** The fabric that was chosen, in the shaders. */
export class Chosen {
  readonly uniforms = {
    uOwnColour: { value: true },
    uColour: { value: new Vector3(...CLOTH) },
    uRoughness: { value: -1 },
    uFabric: { value: null as Texture | null },
    uFabricSize: { value: 1 },
    uRelief: { value: null as Texture | null },
    uReliefSize: { value: 1 },
    uHasHeights: { value: false },
  } satisfies Record<string, IUniform>;
  /** Made or loaded once, by weave or address. */
  readonly #maps = new Map<string, Texture>();

  /** Takes a fabric for meshes of this unit. `then` is called when an image has arrived, to take it again. */
  set(fabric: Fabric, metersPerUnit: number, then: () => void): void {
    const { colour, roughness, weave, image, relief, size = IMAGE_SIZE } = fabric;
    this.#drop([image, relief, weave]);
    const { uniforms } = this;
    const units = (metres: number) => metres / Math.max(metersPerUnit, 1e-9);
    uniforms.uOwnColour.value = colour === null && !image;
    uniforms.uColour.value.set(...chosen(fabric));
    uniforms.uRoughness.value = roughness ?? -1;
    uniforms.uFabric.value = image ? this.#loaded(image, then) : null;
    uniforms.uFabricSize.value = units(size);
    uniforms.uHasHeights.value = !relief;
    uniforms.uReliefSize.value = units(relief ? size : sizeOfWeave(weave));
    uniforms.uRelief.value = relief ? this.#loaded(relief, then) : this.#woven(weave);
  }

  #drop(used: (string | null | undefined)[]): void {
    for (const [key, map] of this.#maps) {
      if (used.includes(key)) continue;
      map.dispose();
      this.#maps.delete(key);
    }
  }

  #woven(weave: Weave): Texture | null {
    if (weave === "none") return null;
    const map = this.#maps.get(weave) ?? reliefOf(weave);
    this.#maps.set(weave, map);
    return map;
  }

  #loaded(address: string, then: () => void): Texture | null {
    const known = this.#maps.get(address);
    if (known) return known.image ? known : null;
    this.#maps.set(address, new TextureLoader().load(address, (map) => (repeated(map), then())));
    return null;
  }

  /** What the shader of cloth needs code for. */
  get codes(): { FABRIC: boolean; RELIEF: boolean } {
    return { FABRIC: this.uniforms.uFabric.value !== null, RELIEF: this.uniforms.uRelief.value !== null };
  }
}

/** The colour that was chosen. [sRGB] */
function chosen({ colour }: Fabric): Rgb {
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
