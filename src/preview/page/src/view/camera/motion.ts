// How the camera gets from one pose to another: it follows a drag with damping, and flies with ease.

import { MathUtils } from "three";

/** Target x, y, z; logarithm of the distance, or in the flat view of half the height; turn; tilt. [radians] */
export type Pose = [number, number, number, number, number, number];

/** Time in which a drag is followed by about two thirds. [ms] */
const DAMPING = 45;
const FLIGHT = 300;

export class Motion {
  readonly pose: Pose;
  #goal: Pose;
  #from: Pose;
  /** Start of the flight, or null while following. [ms] */
  #began: number | null = null;
  #last: number | null = null;

  constructor(pose: Pose) {
    this.pose = [...pose];
    this.#goal = [...pose];
    this.#from = [...pose];
  }

  /** Where the camera will be. Drags change this. */
  get goal(): Readonly<Pose> {
    return this.#goal;
  }

  follow(goal: Pose): void {
    this.#goal = goal;
    this.#began = null;
    if (calm()) this.jump(goal);
  }

  fly(goal: Pose): void {
    this.#goal = goal;
    this.#from = [...this.pose];
    this.#from[4] = nearestTurn(this.#from[4], goal[4]);
    this.#began = performance.now();
    if (calm()) this.jump(goal);
  }

  jump(goal: Pose): void {
    this.#goal = [...goal];
    this.#began = null;
    this.#set(this.#goal);
  }

  /** Moves on to this time. Returns whether there is more to come. */
  step(now: number): boolean {
    const passed = this.#last === null ? 16 : Math.min(64, now - this.#last);
    const more = this.#began === null ? this.#approach(passed) : this.#glide(now - this.#began);
    this.#last = more ? now : null;
    return more;
  }

  #approach(passed: number): boolean {
    const near = this.pose.every((value, index) => Math.abs(this.#goal[index] - value) < this.#tolerance(index));
    if (near) {
      this.#set(this.#goal);
      return false;
    }
    this.#set(mix(this.pose, this.#goal, 1 - Math.exp(-passed / DAMPING)));
    return true;
  }

  #glide(passed: number): boolean {
    this.#set(mix(this.#from, this.#goal, MathUtils.smoothstep(passed, 0, FLIGHT)));
    if (passed >= FLIGHT) this.#began = null;
    return passed < FLIGHT;
  }

  /** Less than a pixel. */
  #tolerance(index: number): number {
    return index < 3 ? 2e-4 * Math.exp(this.pose[3]) : 2e-4;
  }

  #set(pose: Readonly<Pose>): void {
    pose.forEach((value, index) => (this.pose[index] = value));
  }
}

function mix(a: Readonly<Pose>, b: Readonly<Pose>, part: number): Pose {
  return a.map((value, index) => MathUtils.lerp(value, b[index], part)) as Pose;
}

/** The same turn, at most half a round from another. */
function nearestTurn(turn: number, to: number): number {
  const round = 2 * Math.PI;
  return to + (turn - to) - round * Math.round((turn - to) / round);
}

function calm(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}
