// What is under the pointer: faces by drawing their numbers into a few pixels, the edge by distance on the screen.

import { Line3, Plane, Raycaster, Vector2, Vector3, WebGLRenderTarget } from "three";
import type { Camera, WebGLRenderer } from "three";
import type { Role } from "../server/protocol";
import type { Picked } from "./api";
import type { Cloth } from "./mesh/cloth";
import type { Place } from "./input";
import type { Column } from "./layout";
import { cageCorners, sourceOf } from "./mesh/sources";
import { nextCorner } from "./mesh/topology";

/** How near the pointer is to an edge that is picked. [CSS pixels] */
const REACH = 8;
/** How far faces are looked for around the pointer. [CSS pixels] */
const AROUND = 6;
/** An edge may be this much farther from the pointer than one behind it. [CSS pixels] */
const FRONT = 3;
/** Share of an edge's distance behind another that counts as distance on the screen. */
const DEPTH = 0.1;
/** Faces around the pointer of which the edges are looked at. */
const MOST_FACES = 24;

/** Where to look: one mesh in one column. */
export interface Spot {
  role: Role;
  cloth: Cloth;
  /** The model, of which the elements are picked, and the number of its own points. */
  model: Cloth;
  points: number;
  column: Column;
  camera: Camera;
  at: Place;
  flat: boolean;
}

/** Faces as they are drawn. */
export interface Seen {
  /** The face at the spot, or -1. */
  face: number;
  /** Faces around it, the nearest first. */
  around: number[];
}

export const NOTHING: Seen = { face: -1, around: [] };

export class Picker {
  readonly #target = new WebGLRenderTarget(1, 1);

  constructor(private readonly renderer: WebGLRenderer) {}

  /** What is drawn at and around the spot. Waits for the graphics card. */
  look(spot: Spot): Seen {
    const pixels = this.#draw(spot);
    this.renderer.readRenderTargetPixels(this.#target, 0, 0, this.#side, this.#side, pixels);
    return seen(pixels, this.#side);
  }

  /** The same without a wait. */
  async lookLater(spot: Spot): Promise<Seen> {
    const pixels = this.#draw(spot);
    const side = this.#side;
    await this.renderer.readRenderTargetPixelsAsync(this.#target, 0, 0, side, side, pixels);
    return seen(pixels, side);
  }

  dispose(): void {
    this.#target.dispose();
  }

  get #side(): number {
    return 2 * Math.ceil(AROUND * this.renderer.getPixelRatio()) + 1;
  }

  /** The whole column is drawn, moved so that the pixels around the spot are the only ones in the target. */
  #draw({ cloth, column, camera, at }: Spot): Uint8Array {
    const ratio = this.renderer.getPixelRatio();
    const side = this.#side;
    const half = (side - 1) / 2;
    const left = Math.floor((at.x - column.x) * ratio);
    const low = Math.floor((column.y + column.height - at.y) * ratio);
    this.#target.setSize(side, side);
    this.#target.viewport.set(half - left, half - low, Math.round(column.width * ratio), Math.round(column.height * ratio));
    const { solid } = cloth;
    const { material } = solid;
    solid.material = cloth.paint.pick;
    this.renderer.setRenderTarget(this.#target);
    this.renderer.setClearColor(0, 0);
    this.renderer.clear();
    this.renderer.render(solid, camera);
    this.renderer.setRenderTarget(null);
    solid.material = material;
    return new Uint8Array(4 * side * side);
  }
}

function seen(pixels: Uint8Array, side: number): Seen {
  const half = (side - 1) / 2;
  const nearest = new Map<number, number>();
  for (let index = 0; index < side * side; index++) {
    const face = number(pixels, 4 * index);
    const far = Math.hypot((index % side) - half, Math.floor(index / side) - half);
    if (face >= 0 && far <= half && far < (nearest.get(face) ?? Infinity)) nearest.set(face, far);
  }
  const around = [...nearest].sort((a, b) => a[1] - b[1]).map(([face]) => face);
  return { face: number(pixels, 4 * half * (side + 1)), around };
}

function number(pixels: Uint8Array, at: number): number {
  return pixels[at + 3] === 0 ? -1 : pixels[at] + 256 * pixels[at + 1] + 65536 * pixels[at + 2] - 1;
}

/** The element of the model below a face that is seen at the spot, or else around it, and the sets of the mesh there. */
export function describe(spot: Spot, { face, around }: Seen): Picked | null {
  const { cloth, model, role, at } = spot;
  const faces = [face, ...around].filter((each) => each >= 0 && each < cloth.faceCount).slice(0, MOST_FACES);
  if (faces.length === 0) return null;
  const edge = frontEdge(spot, cloth, faces.map((each) => drawnCorners(cloth, each)));
  const below = [...new Set(faces.map((each) => sourceOf(cloth, each)))];
  const isCage = cloth === model && !model.faces.owner;
  const picked = isCage ? edge : frontEdge(spot, model, below.map((each) => pairs(cageCorners(model, each, spot.points))));
  const edgeSets = edge ? cloth.membership.ofEdge(...edge) : [];
  const sets = [...edgeSets, ...cloth.membership.ofFace(faces[0])];
  return { role, face: below[0], edge: picked, sets, x: at.x, y: at.y };
}

/** Corners at both ends of an edge. */
type Ends = [number, number];

/** The edges of a face that are drawn. */
function drawnCorners({ faces }: Cloth, face: number): Ends[] {
  const corners = Array.from({ length: faces.starts[face + 1] - faces.starts[face] }, (_, at) => faces.starts[face] + at);
  return corners.filter((corner) => !faces.shown || faces.shown[corner]).map((corner) => [corner, nextCorner(faces, face, corner)]);
}

function pairs(corners: number[]): Ends[] {
  return corners.map((corner, at) => [corner, corners[(at + 1) % corners.length]]);
}

interface NearEdge {
  ends: [number, number];
  /** To the pointer. [CSS pixels] */
  distance: number;
  /** From the eye, in pixels at that distance. [CSS pixels] */
  depth: number;
}

/** The edge at the pointer: of edges that are about as near to it, the one in front. At grazing angles there are several. */
function frontEdge(spot: Spot, cloth: Cloth, edges: Ends[][]): [number, number] | null {
  if (spot.flat && !cloth.hasUvs) return null;
  const near = edges.flat().flatMap((ends) => edgeNear(spot, cloth, ends));
  const front = Math.min(...near.map(({ depth }) => depth));
  const cost = ({ distance, depth }: NearEdge) => distance + Math.min(FRONT, DEPTH * (depth - front));
  return near.reduce<NearEdge | null>((best, edge) => (best && cost(best) <= cost(edge) ? best : edge), null)?.ends ?? null;
}

function edgeNear(spot: Spot, cloth: Cloth, [corner, next]: Ends): NearEdge[] {
  const [a, b] = [corner, next].map((each) => placeOf(cloth, each, spot.flat));
  const segment = new Line3(onCanvas(spot, a), onCanvas(spot, b));
  const pointer = new Vector3(spot.at.x, spot.at.y, 0);
  const share = segment.closestPointToPointParameter(pointer, true);
  const distance = segment.at(share, new Vector3()).distanceTo(pointer);
  const ends: Ends = [cloth.faces.corners[corner], cloth.faces.corners[next]];
  return distance < REACH ? [{ ends, distance, depth: depthOf(spot, a.lerp(b, share)) }] : [];
}

function depthOf({ camera, column }: Spot, place: Vector3): number {
  const depth = -place.applyMatrix4(camera.matrixWorldInverse).z;
  const perspective = camera.projectionMatrix.elements[15] === 0;
  const breadth = (2 / camera.projectionMatrix.elements[5]) * (perspective ? depth : 1);
  return (depth * column.height) / breadth;
}

function onCanvas(spot: Spot, place: Vector3): Vector3 {
  const { x, y } = toCanvas(place.clone().project(spot.camera), spot.column);
  return new Vector3(x, y, 0);
}

export function placeOf(cloth: Cloth, corner: number, flat: boolean): Vector3 {
  if (flat) return new Vector3(cloth.uvs[2 * corner], cloth.uvs[2 * corner + 1], 0);
  return new Vector3().fromArray(cloth.points, 4 * cloth.faces.corners[corner]);
}

/** From normalised device coordinates. */
export function toCanvas(p: Vector3, column: Column): Place {
  return { x: column.x + (p.x * 0.5 + 0.5) * column.width, y: column.y + (0.5 - p.y * 0.5) * column.height };
}

export function toDevice(at: Place, column: Column): Vector2 {
  return new Vector2(((at.x - column.x) / column.width) * 2 - 1, 1 - ((at.y - column.y) / column.height) * 2);
}

/** The place on a face under the pointer. */
export function onFace(spot: Spot, face: number): Vector3 | null {
  const { faces } = spot.cloth;
  const first = faces.starts[face];
  const [a, b, c] = [0, 1, 2].map((step) => placeOf(spot.cloth, first + step, spot.flat));
  const plane = new Plane().setFromCoplanarPoints(a, b, c);
  const caster = new Raycaster();
  caster.setFromCamera(toDevice(spot.at, spot.column), spot.camera);
  return caster.ray.intersectPlane(plane, new Vector3());
}
