// The cameras of both views. Each frames the whole garment again when the view changes, until the artist moves it.

import { poseFromHere, poseOfAll } from "./aims";
import type { Sight } from "./aims";
import type { Pose } from "./motion";
import { FlatRig, SpaceRig, THREE_QUARTER } from "./rig";
import type { Rig } from "./rig";

export class Cameras {
  readonly space = new SpaceRig();
  readonly flat = new FlatRig();
  /** Rigs that the artist has not moved. */
  readonly #untouched = new Set<Rig>([this.space, this.flat]);
  /** Rigs that have shown the whole garment. */
  readonly #framed = new Set<Rig>();

  of(flat: boolean): Rig {
    return flat ? this.flat : this.space;
  }

  /** Moves both on to this time. Returns whether there is more to come. */
  step(now: number): boolean {
    return [this.space, this.flat].map(({ motion }) => motion.step(now)).includes(true);
  }

  /** The artist moves a camera. */
  touch(rig: Rig): void {
    this.#untouched.delete(rig);
  }

  /** Flies to a part, so that the whole is not framed again by itself. */
  flyTo(rig: Rig, pose: Pose | null): void {
    if (!pose) return;
    this.touch(rig);
    rig.motion.fly(pose);
  }

  /** Flies to where the whole is in view. A change of the view may frame it again. */
  flyToWhole(sight: Sight): void {
    const pose = poseOfAll(sight);
    if (pose) sight.rig.motion.fly(pose);
  }

  /** Shows the whole at once, the first time and while the artist has not moved the camera. */
  frame(sight: Sight): void {
    const { rig } = sight;
    if (!this.#untouched.has(rig) && this.#framed.has(rig)) return;
    const pose = poseOfAll(sight, THREE_QUARTER);
    if (!pose) return;
    rig.motion.jump(pose);
    this.#framed.add(rig);
  }

  /** A camera that was not moved stays where it looks, and goes as near as shows everything in the columns. */
  fit(sight: Sight): void {
    const { rig } = sight;
    if (!this.#framed.has(rig)) return this.frame(sight);
    const pose = this.#untouched.has(rig) ? poseFromHere(sight) : null;
    if (pose) rig.motion.jump(pose);
  }
}
