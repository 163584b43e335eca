// The place of an operator at which its handles are drawn: an edge of the render mesh on it, which is seen.

import { Line3, Vector3 } from "three";
import type { Camera } from "three";
import type { Grip, Vector } from "./api";
import type { Place } from "./input";
import type { Column } from "./layout";
import type { Cloth } from "./mesh/cloth";
import type { Elements } from "./mesh/shapes";
import { Carrying, placeOf } from "./mesh/sources";
import { toCanvas } from "./picking";
import type { Picker, Spot } from "./picking";

/** A grip is this far from the sides of its column, at least. [CSS pixels] */
const MARGIN = 64;
/** The cosine of the angle to the eye from which on cloth is looked at too much from the side. */
const LEAST_FACING = 0.2;
/** Places that are tried at most, and their least distance. [CSS pixels] */
const TRIES = 12;
const APART = 48;

/** Cloth that is seen this near to the place is the cloth there. [CSS pixels] */
const NEAR = 8;

/** The column in which it is, with what it sees. */
export interface Sight {
  model: Cloth;
  cloth: Cloth;
  column: Column;
  camera: Camera;
}

type Ends = [number, number];

/** An edge of the mesh, the place of its middle, and the normal there. */
interface Foot {
  ends: Ends;
  at: Vector3;
  normal: Vector3;
}

export class Gripper {
  #elements: Elements | null = null;
  #foot: Foot | null = null;
  /** The mesh of the foot, and the edge of the model there. */
  #cloth: Cloth | null = null;
  #edge: Ends | null = null;
  #checked = "";
  readonly #carrying = new Carrying();

  constructor(
    private readonly picker: Picker,
    private readonly spotAt: (at: Place) => Spot | null,
  ) {}

  /** Elements of the model that the operator follows; null ends it. */
  set(elements: Elements | null): void {
    this.#elements = elements;
    this.#foot = null;
    this.#cloth = null;
  }

  /** Whether it follows an edge of the model. */
  has([a, b]: Ends): boolean {
    return this.#elements?.edges?.some(([c, d]) => (a === c && b === d) || (a === d && b === c)) ?? false;
  }

  /** Finds a place once the camera rests, unless the one before is seen there too. `near` is where it is looked for, else in the
   *  middle of the column. Returns whether there may be another. */
  settle(sight: Sight | null, near: Place | null = null): boolean {
    const { camera } = sight ?? {};
    const state = `${camera?.matrixWorld.elements} ${camera?.projectionMatrix.elements} ${near?.x} ${near?.y}`;
    if (!sight || !this.#elements || (state === this.#checked && this.#cloth === sight.cloth)) return false;
    this.#checked = state;
    const known = this.#current(sight);
    if (known && !near && this.#isSeen(sight, known)) return false;
    this.#stand(sight, this.#find(sight, near));
    return true;
  }

  /** Where the camera sees it. */
  seen(sight: Sight | null): Grip | null {
    const foot = sight && this.#current(sight);
    if (!foot || isOutside(sight, foot.at)) return null;
    const { model, cloth, column, camera } = sight;
    const [from, to] = this.#edge?.map((end) => placeOf(model, end)) ?? [];
    const left = from && to.sub(from).crossVectors(foot.normal, to).normalize();
    const unit = 1e-3 * camera.position.distanceTo(foot.at);
    const at = onCanvas(sight, foot.at);
    const way = (direction: Vector3): Vector => {
      const end = onCanvas(sight, foot.at.clone().addScaledVector(direction, unit));
      return [(end.x - at.x) / unit, (end.y - at.y) / unit];
    };
    const { x, y, width, height } = column;
    return {
      ...at,
      column: { x, y, width, height },
      left: left && way(left),
      cloth: left ? clothBeside(cloth, foot, left) : 0,
      normal: way(foot.normal),
      unit: unitOf(sight, foot.at),
    };
  }

  /** The foot as the mesh is now: of other faces the edge that is nearest to it. */
  #current(sight: Sight): Foot | null {
    const known = this.#foot;
    if (!known || this.#cloth === sight.cloth) return known && footOf(sight.cloth, known.ends);
    const all = this.#ends(sight).map((ends) => footOf(sight.cloth, ends));
    this.#stand(sight, least(all, ({ at }) => at.distanceTo(known.at)));
    return this.#foot;
  }

  #stand({ model, cloth }: Sight, foot: Foot | null): void {
    this.#foot = foot;
    this.#cloth = cloth;
    const line = ([a, b]: Ends) => new Line3(placeOf(model, a), placeOf(model, b));
    const far = (edge: Ends, { at }: Foot) => line(edge).closestPointToPoint(at, true, new Vector3()).distanceTo(at);
    this.#edge = foot && least(this.#elements?.edges ?? [], (edge) => far(edge, foot));
  }

  #find(sight: Sight, near: Place | null): Foot | null {
    const { column } = sight;
    const middle = near ?? { x: column.x + column.width / 2, y: column.y + column.height / 2 };
    const all = this.#ends(sight).flatMap((ends) => {
      const foot = footOf(sight.cloth, ends);
      const { x, y } = onCanvas(sight, foot.at);
      return isAside(sight, foot) || isOutside(sight, foot.at) ? [] : [{ foot, x, y, far: Math.hypot(x - middle.x, y - middle.y) }];
    });
    all.sort((a, b) => a.far - b.far);
    const tried: Place[] = [];
    for (const each of all) {
      if (tried.length >= TRIES) break;
      if (tried.some(({ x, y }) => Math.hypot(x - each.x, y - each.y) < APART)) continue;
      if (this.#isSeen(sight, each.foot)) return each.foot;
      tried.push(each);
    }
    return null;
  }

  /** Edges of the mesh on the operator; of faces, their first edges. */
  #ends({ model, cloth }: Sight): Ends[] {
    const { edges = [], faces = [] } = this.#carrying.of(model, cloth, this.#elements ?? {});
    const { starts, corners } = cloth.faces;
    return [...edges, ...faces.map((face): Ends => [corners[starts[face]], corners[starts[face] + 1]])];
  }

  #isSeen(sight: Sight, foot: Foot): boolean {
    if (isAside(sight, foot) || isOutside(sight, foot.at)) return false;
    const { cloth } = sight;
    const spot = this.spotAt(onCanvas(sight, foot.at));
    if (spot?.cloth !== cloth) return false;
    const { starts, corners } = cloth.faces;
    const near = (point: number) => placeOf(cloth, point).distanceTo(foot.at) * unitOf(sight, foot.at) < NEAR;
    const isNear = (face: number) => hasEdge(cloth, face, foot.ends) || corners.subarray(starts[face], starts[face + 1]).some(near);
    return this.picker.look(spot).around.slice(0, 4).some(isNear);
  }
}

/** 1 where all cloth is on the left of a border, -1 where it is on the right, 0 inside. */
function clothBeside(cloth: Cloth, { ends, at }: Foot, left: Vector3): -1 | 0 | 1 {
  const { starts, corners } = cloth.faces;
  if (cloth.edges.uses[cloth.edges.find(...ends)] !== 1) return 0;
  const face = starts.findIndex((_, face) => hasEdge(cloth, face, ends));
  const middle = new Vector3();
  for (const point of corners.subarray(starts[face], starts[face + 1])) middle.add(placeOf(cloth, point).sub(at));
  return middle.dot(left) > 0 ? 1 : -1;
}

function hasEdge({ faces: { starts, corners } }: Cloth, face: number, ends: Ends): boolean {
  const own = corners.subarray(starts[face], starts[face + 1]);
  return ends.every((end) => own.includes(end));
}

function least<T>(all: T[], cost: (each: T) => number): T | null {
  const costs = all.map(cost);
  return all[costs.indexOf(Math.min(...costs))] ?? null;
}

function footOf(cloth: Cloth, ends: Ends): Foot {
  const [a, b] = ends;
  const normalAt = (point: number) => new Vector3().fromArray(cloth.normals, 4 * point);
  const normal = normalAt(a).add(normalAt(b)).multiplyScalar(cloth.handed).normalize();
  return { ends, at: placeOf(cloth, a).lerp(placeOf(cloth, b), 0.5), normal };
}

/** One mesh unit across the line of sight. [CSS pixels] */
function unitOf(sight: Sight, place: Vector3): number {
  const { x, y } = onCanvas(sight, place);
  const beside = onCanvas(sight, place.clone().add(new Vector3().setFromMatrixColumn(sight.camera.matrixWorld, 0)));
  return Math.hypot(beside.x - x, beside.y - y);
}

function isAside({ camera }: Sight, { at, normal }: Foot): boolean {
  return camera.position.clone().sub(at).normalize().dot(normal) < LEAST_FACING;
}

function isOutside(sight: Sight, place: Vector3): boolean {
  const { x, y, width, height } = sight.column;
  const at = onCanvas(sight, place);
  return at.x < x + MARGIN || at.y < y + MARGIN || at.x > x + width - MARGIN || at.y > y + height - MARGIN;
}

function onCanvas({ camera, column }: Sight, place: Vector3): Place {
  return toCanvas(place.clone().project(camera), column);
}
