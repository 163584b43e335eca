// The samples of a picture at rest: each is moved by a part of a pixel, and lit from another direction.

import { Vector3 } from "three";

export const SAMPLES = 16;
/** Directions of light in one sample. */
export const LIGHTS = 4;
/** The middle of the light, which comes from above and from the left of the eye. [view space] */
export const LIGHT_AXIS = new Vector3(-0.38, 0.62, 0.69).normalize();

export interface Sample {
  number: number;
  /** Part of a pixel by which the picture is moved. */
  jitter: [number, number];
  /** Directions to the light, spread evenly over the half sphere around the axis. [view space] */
  lights: Vector3[];
  /** Shadows are faint in the first samples, so that they fade in. The mean is 1. */
  shade: number;
}

/** Sample `number` of a picture of `count`. */
export function sampleAt(number: number, count = SAMPLES): Sample {
  const jitter: [number, number] = [radical(number + 1, 2) - 0.5, radical(number + 1, 3) - 0.5];
  const lights = [...Array(LIGHTS).keys()].map((light) => direction(number + light * count, count * LIGHTS));
  return { number, jitter, lights, shade: (2 * (number + 1)) / (count + 1) };
}

const GOLDEN = (1 + Math.sqrt(5)) / 2;

/** A spiral of points over the half sphere, in an order in which the first few are far apart. */
function direction(number: number, count: number): Vector3 {
  const at = Math.floor(radical(number, 2) * count);
  const height = (at + 0.5) / count;
  const across = Math.sqrt(1 - height * height);
  const turn = (2 * Math.PI * at) / GOLDEN;
  const side = new Vector3(0, 1, 0).cross(LIGHT_AXIS).normalize();
  const upward = new Vector3().crossVectors(LIGHT_AXIS, side);
  return new Vector3()
    .addScaledVector(side, across * Math.cos(turn))
    .addScaledVector(upward, across * Math.sin(turn))
    .addScaledVector(LIGHT_AXIS, height);
}

/** The digits of a number after the point, in reverse. */
function radical(number: number, base: number): number {
  let sum = 0;
  for (let rest = number, share = 1 / base; rest > 0; rest = Math.floor(rest / base), share /= base) {
    sum += (rest % base) * share;
  }
  return sum;
}
