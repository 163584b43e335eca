// Markers on cloth: points as dots, edges as thick lines, faces tinted. Sizes are in pixels.

import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  GLSL3,
  GreaterDepth,
  Group,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  LessEqualDepth,
  Mesh,
  Points,
  RawShaderMaterial,
  Vector2,
  Vector3,
} from "three";
import type { DepthModes, IUniform, Object3D } from "three";
import type { Rgb } from "../shade/colours";
import { LINE_QUAD, LINE_REACH } from "../shade/lineShader";

const HEADER = /* glsl */ `
precision highp float;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform float uPixel;
uniform float uStrength;
uniform vec3 uColour;
`;

// Nearer to the eye by a few pixels, as marks lie in the surface.
const NEARER = /* glsl */ `
vec4 nearer(vec4 view, float height) {
  if (projectionMatrix[3][3] != 0.0) return view + vec4(0.0, 0.0, 0.01, 0.0);
  float bias = 6.0 * uPixel * -view.z / (projectionMatrix[1][1] * height);
  view.xyz *= 1.0 - bias / max(length(view.xyz), 2.0 * bias);
  return view;
}
`;

const DOT_VERTEX = /* glsl */ `${HEADER}
uniform vec2 uView;
in vec3 position;
${NEARER}
void main() {
  gl_Position = projectionMatrix * nearer(modelViewMatrix * vec4(position, 1.0), uView.y);
  gl_PointSize = 14.0 * uPixel;
}
`;

const DOT_FRAGMENT = /* glsl */ `${HEADER}
out vec4 colour;
void main() {
  float r = length(gl_PointCoord - 0.5) * 14.0;
  float outer = clamp((6.5 - r) * uPixel + 0.5, 0.0, 1.0);
  float inner = clamp((4.6 - r) * uPixel + 0.5, 0.0, 1.0);
  colour = vec4(mix(vec3(0.08), uColour, inner), uStrength * outer * mix(0.75, 1.0, inner));
}
`;

const LINE_VERTEX = /* glsl */ `
precision highp float;
uniform mat4 modelViewMatrix;
uniform float uPixel;
uniform float uWidth;
in vec3 from;
in vec3 to;
${LINE_QUAD}
${NEARER}
void main() {
  vec4 a = nearer(modelViewMatrix * vec4(from, 1.0), uView.y);
  vec4 b = nearer(modelViewMatrix * vec4(to, 1.0), uView.y);
  lineQuad(a, b, (0.5 * uWidth + 2.0) * uPixel);
}
`;

// The rims of all lines are below the lines, so that the joints of short ones are not seen.
const LINE_FRAGMENT = /* glsl */ `${HEADER}
uniform float uWidth;
uniform bool uRim;
out vec4 colour;
${LINE_REACH}
void main() {
  float r = lineReach() / uPixel;
  float cover = clamp((0.5 * uWidth + (uRim ? 1.2 : 0.0) - r) * uPixel + 0.5, 0.0, 1.0);
  if (cover <= 0.0) discard;
  colour = uRim ? vec4(vec3(0.08), 0.55 * uStrength * cover) : vec4(uColour, uStrength * cover);
}
`;

const FILL_VERTEX = /* glsl */ `${HEADER}
uniform vec2 uView;
in vec3 position;
${NEARER}
void main() {
  gl_Position = projectionMatrix * nearer(modelViewMatrix * vec4(position, 1.0), uView.y);
}
`;

const FILL_FRAGMENT = /* glsl */ `${HEADER}
out vec4 colour;
void main() {
  colour = vec4(uColour, 0.38 * uStrength);
}
`;

/** Corners of a line's quad. */
export const QUAD = new Float32Array([0, -1, 1, -1, 1, 1, 0, -1, 1, 1, 0, 1]);

/** Places as x, y, z; of segments both ends, of triangles three corners. */
export interface Shapes {
  points: number[];
  segments: number[];
  triangles: number[];
}

/** How much of marks is seen behind cloth: all, or little. */
export const THROUGH = 1;
export const FAINT = 0.12;

export class Marks {
  readonly object = new Group();
  readonly #uniforms: Record<string, IUniform>;

  constructor(
    colour: Rgb,
    width: number,
    private readonly behind: number,
  ) {
    this.#uniforms = {
      uView: { value: new Vector2(1, 1) },
      uPixel: { value: 1 },
      uColour: { value: new Vector3(...colour) },
      uWidth: { value: width },
    };
  }

  setColour(colour: Rgb): void {
    (this.#uniforms.uColour.value as Vector3).set(...colour);
  }

  /** Sizes of the view. [device pixels] */
  setView(width: number, height: number, ratio: number): void {
    (this.#uniforms.uView.value as Vector2).set(width, height);
    this.#uniforms.uPixel.value = ratio;
  }

  set(shapes: Shapes): void {
    this.clear();
    const { points, segments, triangles } = shapes;
    for (const depth of this.behind === THROUGH ? [null] : [GreaterDepth, LessEqualDepth]) {
      const material = (vertex: string, fragment: string, rim = false) => this.#material(vertex, fragment, depth, rim);
      if (triangles.length) this.#add(new Mesh(plain(triangles), material(FILL_VERTEX, FILL_FRAGMENT)));
      if (segments.length) this.#add(new Mesh(quads(segments), material(LINE_VERTEX, LINE_FRAGMENT, true)));
      if (segments.length) this.#add(new Mesh(quads(segments), material(LINE_VERTEX, LINE_FRAGMENT)));
      if (points.length) this.#add(new Points(plain(points), material(DOT_VERTEX, DOT_FRAGMENT)));
    }
  }

  clear(): void {
    for (const child of [...this.object.children] as Mesh<BufferGeometry, RawShaderMaterial>[]) {
      child.geometry.dispose();
      child.material.dispose();
      this.object.remove(child);
    }
  }

  #add(object: Object3D): void {
    object.frustumCulled = false;
    object.renderOrder = 10 + this.object.children.length;
    this.object.add(object);
  }

  /** `depth` chooses what is before the cloth, or behind it; null is both. */
  #material(
    vertexShader: string,
    fragmentShader: string,
    depth: DepthModes | null,
    isRim: boolean,
  ): RawShaderMaterial {
    return new RawShaderMaterial({
      vertexShader,
      fragmentShader,
      uniforms: { ...this.#uniforms, uStrength: { value: depth === GreaterDepth ? this.behind : 1 }, uRim: { value: isRim } },
      glslVersion: GLSL3,
      side: DoubleSide,
      forceSinglePass: true,
      transparent: true,
      depthTest: depth !== null,
      depthFunc: depth ?? LessEqualDepth,
      depthWrite: false,
    });
  }
}

function plain(places: number[]): BufferGeometry {
  return new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
}

function quads(segments: number[]): InstancedBufferGeometry {
  const geometry = new InstancedBufferGeometry();
  const ends = new Float32Array(segments);
  const every = (first: number): Float32Array => ends.filter((_, at) => at % 6 >= first && at % 6 < first + 3);
  geometry.setAttribute("corner", new BufferAttribute(QUAD, 2));
  geometry.setDrawRange(0, 6);
  geometry.setAttribute("from", new InstancedBufferAttribute(every(0), 3));
  geometry.setAttribute("to", new InstancedBufferAttribute(every(3), 3));
  geometry.instanceCount = segments.length / 6;
  return geometry;
}
