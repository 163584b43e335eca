// What is under the pointer: the face by drawing face numbers into one pixel, its edge by distance on the screen.

import { Plane, Raycaster, Vector2, Vector3, WebGLRenderTarget } from "three";
import type { Camera, WebGLRenderer } from "three";
import type { Role } from "../server/protocol";
import type { Picked } from "./api";
import type { Cloth } from "./mesh/cloth";
import type { Place } from "./input";
import type { Column } from "./layout";
import { ownerOf } from "./mesh/shapes";
import { nextCorner } from "./mesh/topology";

/** How near the pointer is to an edge that is picked. [CSS pixels] */
const REACH = 8;

/** Where to look: one mesh in one column. */
export interface Spot {
  role: Role;
  cloth: Cloth;
  column: Column;
  camera: Camera;
  at: Place;
  flat: boolean;
}

export class Picker {
  readonly #target = new WebGLRenderTarget(1, 1);
  readonly #pixel = new Uint8Array(4);

  constructor(private readonly renderer: WebGLRenderer) {}

  /** The drawn face at the spot, or -1. Waits for the graphics card. */
  face(spot: Spot): number {
    this.#draw(spot);
    this.renderer.readRenderTargetPixels(this.#target, 0, 0, 1, 1, this.#pixel);
    return number(this.#pixel);
  }

  /** The same without a wait. */
  async faceLater(spot: Spot): Promise<number> {
    this.#draw(spot);
    const pixel = new Uint8Array(4);
    await this.renderer.readRenderTargetPixelsAsync(this.#target, 0, 0, 1, 1, pixel);
    return number(pixel);
  }

  dispose(): void {
    this.#target.dispose();
  }

  /** The whole column is drawn, moved so that the pixel at the spot is the only one in the target. */
  #draw({ cloth, column, camera, at }: Spot): void {
    const ratio = this.renderer.getPixelRatio();
    const left = Math.floor((at.x - column.x) * ratio);
    const low = Math.floor((column.height - at.y) * ratio);
    this.#target.viewport.set(-left, -low, Math.round(column.width * ratio), Math.round(column.height * ratio));
    const { solid } = cloth;
    const { material } = solid;
    solid.material = cloth.paint.pick;
    this.renderer.setRenderTarget(this.#target);
    this.renderer.setClearColor(0, 0);
    this.renderer.clear();
    this.renderer.render(solid, camera);
    this.renderer.setRenderTarget(null);
    solid.material = material;
  }
}

function number(pixel: Uint8Array): number {
  return pixel[3] === 0 ? -1 : pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
}

/** Everything about a face at the spot. */
export function describe(spot: Spot, face: number): Picked {
  const { cloth, role, at } = spot;
  const edge = nearestEdge(spot, face);
  const edgeSets = edge ? cloth.membership.ofEdge(...edge) : [];
  const sets = [...edgeSets, ...cloth.membership.ofFace(face)];
  return { role, face: ownerOf(cloth, face), edge, sets, x: at.x, y: at.y };
}

function nearestEdge(spot: Spot, face: number): [number, number] | null {
  const { faces } = spot.cloth;
  let nearest = REACH;
  let found: [number, number] | null = null;
  for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
    if (faces.shown && !faces.shown[corner]) continue;
    const next = nextCorner(faces, face, corner);
    const distance = toSegment(spot.at, onCanvas(spot, corner), onCanvas(spot, next));
    if (distance >= nearest) continue;
    nearest = distance;
    found = [faces.corners[corner], faces.corners[next]];
  }
  return found;
}

function onCanvas(spot: Spot, corner: number): Place {
  return toCanvas(placeOf(spot.cloth, corner, spot.flat).project(spot.camera), spot.column);
}

export function placeOf(cloth: Cloth, corner: number, flat: boolean): Vector3 {
  if (flat) return new Vector3(cloth.uvs[2 * corner], cloth.uvs[2 * corner + 1], 0);
  return new Vector3().fromArray(cloth.points, 4 * cloth.faces.corners[corner]);
}

/** From normalised device coordinates. */
export function toCanvas(p: Vector3, column: Column): Place {
  return { x: column.x + (p.x * 0.5 + 0.5) * column.width, y: (0.5 - p.y * 0.5) * column.height };
}

export function toDevice(at: Place, column: Column): Vector2 {
  return new Vector2(((at.x - column.x) / column.width) * 2 - 1, 1 - (at.y / column.height) * 2);
}

function toSegment(p: Place, a: Place, b: Place): number {
  const [x, y] = [b.x - a.x, b.y - a.y];
  const square = x * x + y * y;
  const t = square > 0 ? Math.min(1, Math.max(0, ((p.x - a.x) * x + (p.y - a.y) * y) / square)) : 0;
  return Math.hypot(p.x - a.x - t * x, p.y - a.y - t * y);
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
