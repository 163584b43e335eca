// Poses of the camera for what it may be asked to frame.

import type { Cloth } from "../mesh/cloth";
import { ballOf, meanNormal, placesOfSets, placesOfShapes, wholeOf } from "./framing";
import type { Pose } from "./motion";
import type { Rig, SpaceRig } from "./rig";
import { pointsOf, shapesOf } from "../mesh/shapes";
import type { Elements } from "../mesh/shapes";

/** What there is to frame, and with which camera. */
export interface Sight {
  rig: Rig;
  space: SpaceRig;
  aspect: number;
  flat: boolean;
  /** Meshes that are drawn. */
  shown: Cloth[];
  model: Cloth | undefined;
}

/** `direction` is a turn and a tilt; without it the camera keeps its own. */
export function poseOfAll({ rig, aspect, flat, shown }: Sight, direction?: [number, number]): Pose | null {
  const clouds = shown.map((cloth) => wholeOf(cloth, flat));
  return rig.fit(clouds, aspect, direction);
}

export function poseOfSets({ rig, aspect, flat, shown }: Sight, names: ReadonlySet<string>): Pose | null {
  const last = shown.at(-1);
  if (!last || names.size === 0) return null;
  const places = shown.flatMap((cloth) => placesOfSets(cloth, names, flat));
  const ball = ballOf(places, last, flat);
  return ball && rig.fitSphere(ball.centre, ball.radius, aspect);
}

export function poseOfMarks(sight: Sight, elements: Elements | null): Pose | null {
  const { rig, aspect, flat, model } = sight;
  if (!model || !elements) return null;
  const ball = ballOf(placesOfShapes(shapesOf(model, elements, flat)), model, flat);
  return ball && rig.fitSphere(ball.centre, ball.radius, aspect, sideOf(sight.space, model, elements));
}

/** The direction from which the cloth is seen from outside; undefined if the camera looks from there already. */
function sideOf(space: SpaceRig, model: Cloth, elements: Elements): [number, number] | undefined {
  const normal = meanNormal(model, pointsOf(model, elements));
  const seen = normal && normal.dot(space.backOf(space.motion.goal)) > 0.35;
  return normal && !seen ? space.directionTo(normal) : undefined;
}
