// What is behind the mesh: a soft gradient, the ground below the garment, and the square of the UV plane.

import {
  BufferGeometry,
  Color,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineLoop,
  LineSegments,
  MathUtils,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  RingGeometry,
  Vector3,
} from "three";
import { LOOKS } from "./colours";
import type { Theme } from "./colours";

/** Squares of the ground from its middle to its rim. */
const SQUARES = 8;
/** Rows of the gradient. */
const ROWS = 16;
const BEHIND = { transparent: true, depthWrite: false } as const;

export class Backdrop {
  readonly sky: Mesh;
  readonly ground = new Group();
  readonly square = new Group();
  readonly #line = new LineBasicMaterial({ ...BEHIND, vertexColors: true });
  readonly #rim = new LineBasicMaterial({ ...BEHIND, opacity: 0.45 });
  readonly #fill = new MeshBasicMaterial({ ...BEHIND, opacity: 0.05 });
  readonly #shade = new MeshBasicMaterial({ ...BEHIND, color: 0, vertexColors: true });
  readonly #foot: Mesh;

  constructor() {
    // Noise of less than one step hides the bands of a dark gradient.
    const sky = new MeshBasicMaterial({ vertexColors: true, dithering: true, depthTest: false, depthWrite: false });
    this.sky = new Mesh(new PlaneGeometry(2, 2, 1, ROWS), sky);
    this.sky.frustumCulled = false;
    this.#foot = new Mesh(faded(new RingGeometry(0, 2, 48, 12), (far) => Math.exp(-1.6 * far * far)), this.#shade);
    this.ground.add(this.#foot, new LineSegments(gridOf(), this.#line));
    const plane = new PlaneGeometry().translate(0.5, 0.5, 0);
    const corners = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0];
    const border = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(corners, 3));
    this.square.add(new Mesh(plane, this.#fill), new LineLoop(border, this.#rim));
    [...this.ground.children, ...this.square.children].forEach((each, at) => (each.renderOrder = at - 4));
  }

  setTheme(theme: Theme): void {
    const { top, bottom, line } = LOOKS[theme];
    for (const { color } of [this.#line, this.#rim, this.#fill]) color.setRGB(...line);
    this.#shade.opacity = theme === "light" ? 0.2 : 0.42;
    const [low, high] = [new Color(...bottom), new Color(...top)];
    const rows = [...Array(ROWS + 1).keys()].flatMap((row) => {
      const colour = high.clone().lerp(low, MathUtils.smoothstep(row / ROWS, 0, 1)).toArray();
      return [...colour, ...colour];
    });
    this.sky.geometry.setAttribute("color", new Float32BufferAttribute(rows, 3));
  }

  /** Puts the ground at the lowest place of the garment. `half` is its half size, `up` the axis of the stage. */
  setGround(centre: Vector3, half: Vector3, up: Vector3): void {
    const upright = up.y > 0.5;
    const size = 1.45 * half.length();
    this.ground.scale.setScalar(size);
    this.ground.rotation.set(upright ? -Math.PI / 2 : 0, 0, 0);
    this.ground.position.copy(centre).addScaledVector(up, -half.dot(up));
    this.#foot.scale.set(half.x / size, (upright ? half.z : half.y) / size, 1);
  }
}

/** Squares that fade towards the rim. */
function gridOf(): BufferGeometry {
  const steps = [...Array(2 * SQUARES + 1).keys()].map((step) => step / SQUARES - 1);
  const along = steps.flatMap((x) => steps.slice(1).flatMap((y) => [x, y - 1 / SQUARES, 0, x, y, 0]));
  const across = along.map((_, at) => along[[at + 1, at - 1, at][at % 3]]);
  const grid = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([...along, ...across], 3));
  return faded(grid, (far) => 0.2 * (1 - MathUtils.smoothstep(far, 0.25, 0.95)));
}

/** Gives places the opacity that follows from the distance from the middle. */
function faded(geometry: BufferGeometry, opacity: (far: number) => number): BufferGeometry {
  const { array } = geometry.getAttribute("position");
  const colours = [...Array(array.length / 3).keys()].flatMap((at) => [1, 1, 1, opacity(Math.hypot(array[3 * at], array[3 * at + 1]))]);
  return geometry.setAttribute("color", new Float32BufferAttribute(colours, 4));
}
