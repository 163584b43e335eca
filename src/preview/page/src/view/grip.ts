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

/** The meshes in a column, as its camera sees them. */
export interface Sight {
  model: Cloth;
  cloth: Cloth;
  column: Column;
  camera: Camera;
}

type Ends = [number, number];

/** An edge of the mesh, its middle, and the normal there. */
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
    this.#foot = this.#cloth = null;
  }

  /** Whether it follows an edge of the model. */
  has(edge: Ends): boolean {
    return this.#elements?.edges?.some((each) => each.every((end) => edge.includes(end))) ?? false;
  }

  /** Finds a place once the camera rests, unless the one before is seen there too: near a place of the canvas, or else in the
   *  middle of the column. Returns whether there may be another. */
  settle(sight: Sight | null, near: Place | null = null): boolean {
    const state = `${sight?.camera.matrixWorld.elements} ${sight?.camera.projectionMatrix.elements} ${near?.x} ${near?.y}`;
    if (!sight || !this.#elements || (state === this.#checked && this.#cloth === sight.cloth)) return false;
    this.#checked = state;
    const known = this.#current(sight);
    if (known && !near && isOpen(sight, known) && this.#isSeen(sight, known)) return false;
    this.#stand(sight, this.#find(sight, near));
    return true;
  }

  /** Where the camera sees it. */
  seen(sight: Sight | null): Grip | null {
    const foot = sight && this.#current(sight);
    if (!foot || isOutside(sight, foot.at)) return null;
    const { model, cloth, camera } = sight;
    const [from, to] = this.#edge?.map((end) => placeOf(model, end)) ?? [];
    const left = from && to.sub(from).crossVectors(foot.normal, to).normalize();
    const unit = 1e-3 * camera.position.distanceTo(foot.at);
    const at = onCanvas(sight, foot.at);
    const way = (direction: Vector3): Vector => {
      const end = onCanvas(sight, foot.at.clone().addScaledVector(direction, unit));
      return [(end.x - at.x) / unit, (end.y - at.y) / unit];
    };
    const beside = left ? clothBeside(cloth, foot, left) : 0;
    return { ...at, left: left && way(left), cloth: beside, normal: way(foot.normal), unit: unitOf(sight, foot.at) };
  }

  /** The foot as the mesh is now: of other faces the edge that is nearest to it. */
  #current(sight: Sight): Foot | null {
    const known = this.#foot;
    if (!known || this.#cloth === sight.cloth) return known && footOf(sight.cloth, known.ends);
    this.#stand(sight, least(this.#feet(sight), ({ at }) => at.distanceTo(known.at)));
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
    const { x, y, width, height } = sight.column;
    const middle = near ?? { x: x + width / 2, y: y + height / 2 };
    const open = this.#feet(sight).filter((foot) => isOpen(sight, foot));
    const all = open.map((foot) => ({ foot, at: onCanvas(sight, foot.at) })).sort((a, b) => between(a.at, middle) - between(b.at, middle));
    const tried: Place[] = [];
    for (const { foot, at } of all) {
      if (tried.length >= TRIES) break;
      if (tried.some((other) => between(other, at) < APART)) continue;
      if (this.#isSeen(sight, foot)) return foot;
      tried.push(at);
    }
    return null;
  }

  /** At all edges of the mesh on the operator; of faces, at their first edges. */
  #feet({ model, cloth }: Sight): Foot[] {
    const { edges = [], faces = [] } = this.#carrying.of(model, cloth, this.#elements ?? {});
    const { starts, corners } = cloth.faces;
    const all = [...edges, ...faces.map((face): Ends => [corners[starts[face]], corners[starts[face] + 1]])];
    return all.map((ends) => footOf(cloth, ends));
  }

  /** Whether no other cloth is in front of it. */
  #isSeen(sight: Sight, { ends, at }: Foot): boolean {
    const { cloth } = sight;
    const spot = this.spotAt(onCanvas(sight, at));
    if (spot?.cloth !== cloth) return false;
    const near = (point: number) => placeOf(cloth, point).distanceTo(at) * unitOf(sight, at) < NEAR;
    return this.picker.look(spot).around.slice(0, 4).some((face) => hasEdge(cloth, face, ends) || pointsOf(cloth, face).some(near));
  }
}

/** 1 where all cloth is on the left of a border, -1 where it is on the right, 0 inside. */
function clothBeside(cloth: Cloth, { ends, at }: Foot, left: Vector3): -1 | 0 | 1 {
  if (cloth.edges.uses[cloth.edges.find(...ends)] !== 1) return 0;
  const face = cloth.faces.starts.findIndex((_, face) => hasEdge(cloth, face, ends));
  const middle = new Vector3();
  for (const point of pointsOf(cloth, face)) middle.add(placeOf(cloth, point).sub(at));
  return middle.dot(left) > 0 ? 1 : -1;
}

function pointsOf({ faces: { starts, corners } }: Cloth, face: number): Uint32Array {
  return corners.subarray(starts[face], starts[face + 1]);
}

function hasEdge(cloth: Cloth, face: number, ends: Ends): boolean {
  return ends.every((end) => pointsOf(cloth, face).includes(end));
}

function least<T>(all: T[], cost: (each: T) => number): T | null {
  const costs = all.map(cost);
  return all[costs.indexOf(costs.reduce((a, b) => Math.min(a, b), Infinity))] ?? null;
}

function footOf(cloth: Cloth, ends: Ends): Foot {
  const [a, b] = ends.map((point) => new Vector3().fromArray(cloth.normals, 4 * point));
  const at = placeOf(cloth, ends[0]).lerp(placeOf(cloth, ends[1]), 0.5);
  return { ends, at, normal: a.add(b).multiplyScalar(cloth.handed).normalize() };
}

/** One mesh unit across the line of sight. [CSS pixels] */
function unitOf(sight: Sight, place: Vector3): number {
  const right = new Vector3().setFromMatrixColumn(sight.camera.matrixWorld, 0);
  return between(onCanvas(sight, place), onCanvas(sight, right.add(place)));
}

/** Whether it is in view, from the front. */
function isOpen(sight: Sight, { at, normal }: Foot): boolean {
  return sight.camera.position.clone().sub(at).normalize().dot(normal) >= LEAST_FACING && !isOutside(sight, at);
}

function isOutside(sight: Sight, place: Vector3): boolean {
  const { x, y, width, height } = sight.column;
  const at = onCanvas(sight, place);
  return at.x < x + MARGIN || at.y < y + MARGIN || at.x > x + width - MARGIN || at.y > y + height - MARGIN;
}

function onCanvas({ camera, column }: Sight, place: Vector3): Place {
  return toCanvas(place.clone().project(camera), column);
}

function between(a: Place, b: Place): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
