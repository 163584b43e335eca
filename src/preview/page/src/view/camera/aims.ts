// Poses of the camera for what it may be asked to frame.

import { Vector3 } from "three";
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
  /** Proportions of the columns, which all have the same pose. */
  aspects: number[];
  flat: boolean;
  /** Meshes that are drawn. */
  shown: Cloth[];
}

/** Elements on the mesh that shows them, and the proportions of its column. */
export interface Aim {
  cloth: Cloth;
  elements: Elements;
  aspect: number;
}

/** `direction` is a turn and a tilt; without it the camera keeps its own. */
export function poseOfAll({ rig, aspects, flat, shown }: Sight, direction?: [number, number]): Pose | null {
  const clouds = shown.map((cloth) => wholeOf(cloth, flat));
  return farthest(aspects.map((aspect) => rig.fit(clouds, aspect, direction)));
}

/** The pose with all in view, as near as the target and the direction allow, which stay. */
export function poseFromHere({ rig, aspects, flat, shown }: Sight): Pose | null {
  const clouds = shown.map((cloth) => wholeOf(cloth, flat));
  if (clouds.every(({ values }) => values.length === 0)) return null;
  const [x, y, z, , turn, tilt] = rig.motion.goal;
  const size = Math.max(...aspects.map((aspect) => rig.reach(clouds, aspect, rig.motion.goal)));
  return [x, y, z, size, turn, tilt];
}

export function poseOfSets({ rig, aspects, flat, shown }: Sight, names: ReadonlySet<string>): Pose | null {
  const last = shown.at(-1);
  if (!last || names.size === 0) return null;
  const places = shown.flatMap((cloth) => placesOfSets(cloth, names, flat));
  const ball = ballOf(places, last, flat);
  return ball && farthest(aspects.map((aspect) => rig.fitSphere(ball, aspect)));
}

export function poseOfMarks({ rig, space, flat }: Sight, { cloth, elements, aspect }: Aim): Pose | null {
  const ball = ballOf(placesOfShapes(shapesOf(cloth, elements, flat)), cloth, flat);
  return ball && rig.fitSphere(ball, aspect, sideOf(space, cloth, elements));
}

/** Whether nearly all of the elements are in the picture, and on the near side of the cloth. */
export function isInView({ rig, space, flat }: Sight, { cloth, elements, aspect }: Aim): boolean {
  const places = placesOfShapes(shapesOf(cloth, elements, flat));
  const normal = flat ? null : meanNormal(cloth, pointsOf(cloth, elements));
  if (normal && normal.dot(space.backOf(space.motion.goal)) < 0) return false;
  rig.place(aspect);
  const count = places.length / 3;
  let inside = 0;
  for (let at = 0; at < places.length; at += 3) inside += isInside(rig, places, at) ? 1 : 0;
  return inside >= IN_VIEW * count;
}

/** Part of what is looked for that has to be in the picture. */
const IN_VIEW = 0.9;

function isInside(rig: Rig, places: number[], at: number): boolean {
  const device = new Vector3().fromArray(places, at).project(rig.camera);
  return Math.max(Math.abs(device.x), Math.abs(device.y)) <= 1;
}

function farthest(poses: (Pose | null)[]): Pose | null {
  return poses.reduce((far, pose) => (!far || (pose && pose[3] > far[3]) ? pose : far), null);
}

/** The direction from which the cloth is seen from outside; undefined if the camera looks from there already. */
function sideOf(space: SpaceRig, cloth: Cloth, elements: Elements): [number, number] | undefined {
  const normal = meanNormal(cloth, pointsOf(cloth, elements));
  const seen = normal && normal.dot(space.backOf(space.motion.goal)) > 0.35;
  return normal && !seen ? space.directionTo(normal) : undefined;
}
