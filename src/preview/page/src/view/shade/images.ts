// Images of materials, as the layers of one texture.

import { DataArrayTexture } from "three";
import type { IUniform } from "three";
import type { LookInfo } from "../../server/protocol";
import { bytes } from "./colours";
import { CLOTH } from "./fabric";
import { repeated } from "./relief";

/** All layers have one size. [pixels] */
const SIDE = 1024;
/** Those beyond are left out. */
const MOST = 16;

export class Images {
  readonly uniform: IUniform<DataArrayTexture | null> = { value: null };
  /** Addresses of the layers that are there. */
  layers: string[] = [];
  #wanted = "";

  /** Loads the images of looks. Resolves to whether there are other layers than before. */
  async load(looks: LookInfo[]): Promise<boolean> {
    const addresses = [...new Set(looks.flatMap(({ texture }) => texture ?? []))].slice(0, MOST);
    const wanted = addresses.join(" ");
    if (wanted === this.#wanted) return false;
    this.#wanted = wanted;
    const found = await Promise.all(addresses.map((address) => pixelsOf(address).catch(plain)));
    // A newer request replaced this one.
    if (this.#wanted !== wanted) return false;
    this.uniform.value?.dispose();
    this.uniform.value = found.length > 0 ? arrayOf(found) : null;
    this.layers = addresses;
    return true;
  }
}

/** The lowest row comes first, as V does. */
async function pixelsOf(address: string): Promise<Uint8ClampedArray> {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: ${response.status}`);
  const size = { resizeWidth: SIDE, resizeHeight: SIDE, resizeQuality: "high" as const };
  const bitmap = await createImageBitmap(await response.blob(), { ...size, imageOrientation: "flipY" });
  const context = new OffscreenCanvas(SIDE, SIDE).getContext("2d");
  if (!context) throw new Error("no canvas");
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return context.getImageData(0, 0, SIDE, SIDE).data;
}

/** Cloth without an image. */
function plain(): Uint8ClampedArray {
  const pixels = new Uint8ClampedArray(4 * SIDE * SIDE);
  for (let at = 0; at < pixels.length; at += 4) pixels.set([...CLOTH.map(bytes), 255], at);
  return pixels;
}

function arrayOf(layers: Uint8ClampedArray[]): DataArrayTexture {
  const data = new Uint8Array(4 * SIDE * SIDE * layers.length);
  layers.forEach((pixels, layer) => data.set(pixels, layer * 4 * SIDE * SIDE));
  return repeated(new DataArrayTexture(data, SIDE, SIDE, layers.length));
}
