// The relief of woven and knitted cloth as a normal map, of which the fourth channel is the height.

import { DataTexture, LinearFilter, LinearMipmapLinearFilter, RepeatWrapping } from "three";
import type { Texture } from "three";
import type { Weave } from "../api";
import { bytes } from "./colours";

/** Threads along the edge of the map, after which all weaves repeat. */
const THREADS = 4;
/** Edge of the map. [pixels] */
const SIDE = 256;
/** Height of a thread against its breadth. */
const STEEPNESS = 0.35;

/** Distance of two threads, or of two stitches, of coarse cloth. [m] */
const PITCHES: Record<Weave, number> = { none: 1, plain: 0.0022, twill: 0.0018, knit: 0.004 };

/** Edge of the map of a weave on the cloth. [m] */
export function sizeOfWeave(weave: Weave): number {
  return THREADS * PITCHES[weave];
}

/** Height of a place, of which one thread or stitch is one unit; from 0 to 1. */
function heightAt(weave: Weave, x: number, y: number): number {
  const [u, v] = [x - Math.floor(x), y - Math.floor(y)];
  const thread = (across: number, along: number) => Math.sin(Math.PI * across) * (0.45 + 0.55 * Math.sin(Math.PI * along));
  const cell = Math.floor(x) + Math.floor(y);
  if (weave === "plain") return cell % 2 === 0 ? thread(u, v) : thread(v, u);
  if (weave === "twill") return cell % 4 < 2 ? thread(u, v) : 0.75 * thread(v, u);
  const legs = Math.abs(u - 0.5);
  return Math.sqrt(Math.sin(Math.PI * ((v + 1.1 * legs) % 1))) * Math.sin(2 * Math.PI * legs);
}

export function reliefOf(weave: Weave): Texture {
  const data = new Uint8Array(4 * SIDE * SIDE);
  const step = THREADS / SIDE;
  for (let row = 0; row < SIDE; row++) {
    for (let column = 0; column < SIDE; column++) {
      const [x, y] = [column * step, row * step];
      const height = heightAt(weave, x, y);
      const slopes = [heightAt(weave, x + step, y), heightAt(weave, x, y + step)].map((next) => (STEEPNESS * (next - height)) / step);
      const length = Math.hypot(...slopes, 1);
      const normal = [-slopes[0], -slopes[1], 1].map((part) => bytes(0.5 + part / length / 2));
      data.set([...normal, bytes(height)], 4 * (row * SIDE + column));
    }
  }
  return repeated(new DataTexture(data, SIDE, SIDE));
}

export function repeated<T extends Texture>(texture: T): T {
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.magFilter = LinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}
