// A camera with its pose: in space it orbits a target; in the flat view it looks down on the UV plane.

import { OrthographicCamera, PerspectiveCamera, Sphere, Vector2, Vector3 } from "three";
import { Motion } from "./motion";
import type { Pose } from "./motion";
import type { Side } from "../api";
import type { UpAxis } from "../../server/options";

/** Half of the angle that the shorter side of the view spans. [radians] */
const HALF_ANGLE = (14 * Math.PI) / 180;
/** Part of the view that is filled. */
const FILL = 0.86;
/** The same above the middle, where the tool bar is. */
const FILL_TOP = 0.76;
const MOST_TILT = Math.PI / 2 - 0.001;

/** What the camera should show: positions as x, y, z, or as x, y, with a stride. */
export interface Cloud {
  values: ArrayLike<number>;
  stride: number;
}

export abstract class Rig {
  readonly motion: Motion;
  abstract readonly camera: PerspectiveCamera | OrthographicCamera;
  /** Half of the shorter side of the view at a distance of 1. */
  protected abstract readonly half: number;
  /** How much nearer places are larger: 1, or 0 without perspective. */
  protected abstract readonly deep: 0 | 1;
  /** Sphere around all that is drawn. */
  protected centre = new Vector3();
  protected radius = 1;

  constructor(pose: Pose) {
    this.motion = new Motion(pose);
  }

  setBounds(centre: Vector3, radius: number): void {
    this.centre.copy(centre);
    this.radius = Math.max(radius, 1e-6);
  }

  /** Sets the camera to the pose for a view of these proportions. */
  abstract place(aspect: number): void;

  /** The pose that shows these points, seen from the same side or with a turn and a tilt; null without points. Exact: for each
   *  side of the view, the point that lies farthest out decides. */
  fit(clouds: Cloud[], aspect: number, direction?: [number, number]): Pose | null {
    const [turn, tilt] = direction ?? [this.motion.goal[4], this.motion.goal[5]];
    const { right, up, back } = this.axes(turn, tilt);
    const { below, above, beside } = this.#room(aspect);
    let [left, rightmost, low, high] = [-Infinity, -Infinity, -Infinity, -Infinity];
    let [deepest, nearest] = [Infinity, -Infinity];
    eachPlace(clouds, (place) => {
      const [x, y, z] = [place.dot(right), place.dot(up), place.dot(back)];
      const depth = this.deep * z;
      rightmost = Math.max(rightmost, x + depth * beside);
      left = Math.max(left, -x + depth * beside);
      high = Math.max(high, y + depth * above);
      low = Math.max(low, -y + depth * below);
      nearest = Math.max(nearest, z);
      deepest = Math.min(deepest, z);
    });
    if (nearest < deepest) return null;
    const eye = Math.max((rightmost + left) / (2 * beside), (high + low) / (above + below));
    const middle = (nearest + deepest) / 2;
    // Halfway between the heights at which the highest and the lowest point are at their ends of the view.
    const height = (high - eye * above + (eye * below - low)) / 2;
    const target = right.multiplyScalar((rightmost - left) / 2).add(up.multiplyScalar(height)).addScaledVector(back, middle);
    return [target.x, target.y, target.z, Math.log(Math.max(eye - this.deep * middle, 1e-6)), turn, tilt];
  }

  /** The least size of a pose (its fourth number) that shows these points with the target and the direction as they are. */
  reach(clouds: Cloud[], aspect: number, [x, y, z, , turn, tilt]: Readonly<Pose>): number {
    const { right, up, back } = this.axes(turn, tilt);
    const { below, above, beside } = this.#room(aspect);
    const target = new Vector3(x, y, z);
    let distance = 1e-6;
    eachPlace(clouds, (place) => {
      const offset = place.sub(target);
      const height = offset.dot(up);
      const across = Math.max(Math.abs(offset.dot(right)) / beside, height / above, -height / below);
      distance = Math.max(distance, this.deep * offset.dot(back) + across);
    });
    return Math.log(distance);
  }

  /** The sphere as six points, so that small things are shown with what is around them. */
  fitSphere({ center, radius }: Sphere, aspect: number, direction?: [number, number]): Pose | null {
    const offsets = [radius, 0, 0, -radius, 0, 0, 0, radius, 0, 0, -radius, 0, 0, 0, radius, 0, 0, -radius];
    const middle = center.toArray();
    return this.fit([{ values: offsets.map((offset, at) => middle[at % 3] + offset), stride: 3 }], aspect, direction);
  }

  /** Drags the target plane by a part of the view's height. */
  pan(dx: number, dy: number, aspect: number): void {
    const pose: Pose = [...this.motion.goal];
    const { right, up } = this.axes(pose[4], pose[5]);
    const height = 2 * this.halfHeight(pose[3], aspect);
    const by = right.multiplyScalar(-dx * height).add(up.multiplyScalar(dy * height));
    this.motion.follow([pose[0] + by.x, pose[1] + by.y, pose[2] + by.z, pose[3], pose[4], pose[5]]);
  }

  /** Scales the pose about a fixed place. */
  zoom(factor: number, about: Vector3): void {
    const [x, y, z, size, turn, tilt] = this.motion.goal;
    const next = Math.min(Math.log(40 * this.radius), Math.max(Math.log(this.radius / 2000), size + Math.log(factor)));
    const place = new Vector3(x, y, z).sub(about).multiplyScalar(Math.exp(next - size)).add(about);
    this.motion.follow([place.x, place.y, place.z, next, turn, tilt]);
  }

  /** The place on the plane through the target, from normalised device coordinates. */
  onTargetPlane(pointer: Vector2, aspect: number): Vector3 {
    const [x, y, z, size, turn, tilt] = this.motion.goal;
    const { right, up } = this.axes(turn, tilt);
    const half = this.halfHeight(size, aspect);
    return new Vector3(x, y, z).addScaledVector(right, pointer.x * half * aspect).addScaledVector(up, pointer.y * half);
  }

  protected halfHeight(size: number, aspect: number): number {
    return Math.exp(size) * this.tangent(aspect);
  }

  /** A narrow view shows the same breadth. */
  protected tangent(aspect: number): number {
    return this.half / Math.min(1, aspect);
  }

  #room(aspect: number): { below: number; above: number; beside: number } {
    const below = this.tangent(aspect) * FILL;
    return { below, above: this.tangent(aspect) * FILL_TOP, beside: below * aspect };
  }

  protected abstract axes(turn: number, tilt: number): { right: Vector3; up: Vector3; back: Vector3 };
}

const place = new Vector3();

function eachPlace(clouds: Cloud[], visit: (place: Vector3) => void): void {
  for (const { values, stride } of clouds) {
    for (let at = 0; at + stride <= values.length; at += stride) {
      visit(place.set(values[at], values[at + 1], stride > 2 ? values[at + 2] : 0));
    }
  }
}

export class SpaceRig extends Rig {
  readonly camera = new PerspectiveCamera();
  protected readonly half = Math.tan(HALF_ANGLE);
  protected readonly deep = 1;
  #axis: UpAxis = "Y";

  constructor() {
    super([0, 0, 0, 1, ...THREE_QUARTER]);
  }

  setUp(axis: UpAxis): void {
    this.#axis = axis;
  }

  get up(): Vector3 {
    return this.#turned(new Vector3(0, 1, 0));
  }

  place(aspect: number): void {
    const [x, y, z, size, turn, tilt] = this.motion.pose;
    const distance = Math.exp(size);
    const { back } = this.axes(turn, tilt);
    const { camera } = this;
    camera.up.copy(this.up);
    camera.position.set(x, y, z).addScaledVector(back, distance);
    camera.lookAt(x, y, z);
    camera.fov = (2 * Math.atan(this.tangent(aspect)) * 180) / Math.PI;
    camera.aspect = aspect;
    const depth = camera.position.clone().sub(this.centre).dot(back);
    camera.far = Math.max(depth + 1.6 * this.radius, distance * 0.1);
    camera.near = Math.max(depth - 1.6 * this.radius, Math.min(distance, this.radius) * 0.02);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  orbit(dx: number, dy: number): void {
    const [x, y, z, size, turn, tilt] = this.motion.goal;
    const next = Math.min(MOST_TILT, Math.max(-MOST_TILT, tilt + dy));
    this.motion.follow([x, y, z, size, turn - dx, next]);
  }

  /** The turn and the tilt that look against a direction. */
  directionTo(out: Vector3): [number, number] {
    const v = this.#axis === "Y" ? out : new Vector3(out.x, out.z, -out.y);
    return [Math.atan2(v.x, v.z), Math.max(-1.2, Math.min(1.2, Math.asin(Math.max(-1, Math.min(1, v.y)))))];
  }

  backOf(pose: Readonly<Pose>): Vector3 {
    return this.axes(pose[4], pose[5]).back;
  }

  /** A sphere around what is in view near the target. */
  inView(): Sphere {
    const [x, y, z, size] = this.motion.pose;
    const { aspect } = this.camera;
    return new Sphere(new Vector3(x, y, z), 1.15 * this.halfHeight(size, aspect) * Math.hypot(1, aspect));
  }

  protected axes(turn: number, tilt: number): { right: Vector3; up: Vector3; back: Vector3 } {
    const [st, ct, sp, cp] = [Math.sin(turn), Math.cos(turn), Math.sin(tilt), Math.cos(tilt)];
    return {
      right: this.#turned(new Vector3(ct, 0, -st)),
      up: this.#turned(new Vector3(-st * sp, cp, -ct * sp)),
      back: this.#turned(new Vector3(st * cp, sp, ct * cp)),
    };
  }

  /** From Y up to the axis of the stage; the front of a garment looks along +Z, or -Y if Z is up. */
  #turned(v: Vector3): Vector3 {
    return this.#axis === "Y" ? v : v.set(v.x, -v.z, v.y);
  }
}

export class FlatRig extends Rig {
  readonly camera = new OrthographicCamera();
  protected readonly half = 1;
  protected readonly deep = 0;

  constructor() {
    super([0.5, 0.5, 0, Math.log(0.6), 0, 0]);
  }

  place(aspect: number): void {
    const [x, y, , size] = this.motion.pose;
    const half = this.halfHeight(size, aspect);
    const { camera } = this;
    Object.assign(camera, { left: -half * aspect, right: half * aspect, top: half, bottom: -half, near: 0, far: 20 });
    camera.position.set(x, y, 10);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  protected axes(): { right: Vector3; up: Vector3; back: Vector3 } {
    return { right: new Vector3(1, 0, 0), up: new Vector3(0, 1, 0), back: new Vector3(0, 0, 1) };
  }
}

/** Turn and tilt of the first view. */
export const THREE_QUARTER: [number, number] = [0.44, 0.13];

/** Turn and tilt of each side. */
export const SIDES: Record<Side, [number, number]> = {
  front: [0, 0],
  side: [Math.PI / 2, 0],
  back: [Math.PI, 0],
  top: [0, MOST_TILT],
  "three-quarter": THREE_QUARTER,
};
