// Markers that show through cloth: points as dots, edges as thick lines, faces tinted. Sizes are in pixels.

import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  GLSL3,
  Group,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Mesh,
  Points,
  RawShaderMaterial,
  Vector2,
  Vector3,
} from "three";
import type { IUniform, Object3D } from "three";
import type { Rgb } from "../shade/colours";
import { LINE_QUAD, LINE_REACH } from "../shade/lineShader";

const HEADER = /* glsl */ `
precision highp float;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform float uPixel;
uniform vec3 uColour;
`;

const DOT_VERTEX = /* glsl */ `${HEADER}
in vec3 position;
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = 14.0 * uPixel;
}
`;

const DOT_FRAGMENT = /* glsl */ `${HEADER}
out vec4 colour;
void main() {
  float r = length(gl_PointCoord - 0.5) * 14.0;
  float outer = clamp((6.5 - r) * uPixel + 0.5, 0.0, 1.0);
  float inner = clamp((4.6 - r) * uPixel + 0.5, 0.0, 1.0);
  colour = vec4(mix(vec3(0.08), uColour, inner), outer * mix(0.75, 1.0, inner));
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
void main() {
  lineQuad(modelViewMatrix * vec4(from, 1.0), modelViewMatrix * vec4(to, 1.0), (0.5 * uWidth + 2.0) * uPixel);
}
`;

const LINE_FRAGMENT = /* glsl */ `${HEADER}
uniform float uWidth;
out vec4 colour;
${LINE_REACH}
void main() {
  float r = lineReach() / uPixel;
  float inner = clamp((0.5 * uWidth - r) * uPixel + 0.5, 0.0, 1.0);
  float outer = clamp((0.5 * uWidth + 1.2 - r) * uPixel + 0.5, 0.0, 1.0);
  if (outer <= 0.0) discard;
  colour = vec4(mix(vec3(0.08), uColour, inner), outer * mix(0.55, 1.0, inner));
}
`;

const FILL_VERTEX = /* glsl */ `${HEADER}
in vec3 position;
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}
`;

const FILL_FRAGMENT = /* glsl */ `${HEADER}
out vec4 colour;
void main() {
  colour = vec4(uColour, 0.38);
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

export class Marks {
  readonly object = new Group();
  readonly #uniforms: Record<string, IUniform>;

  constructor(colour: Rgb, width: number) {
    this.#uniforms = {
      uView: { value: new Vector2(1, 1) },
      uPixel: { value: 1 },
      uColour: { value: new Vector3(...colour) },
      uWidth: { value: width },
    };
  }

  /** Sizes of the view. [device pixels] */
  setView(width: number, height: number, ratio: number): void {
    (this.#uniforms.uView.value as Vector2).set(width, height);
    this.#uniforms.uPixel.value = ratio;
  }

  set(shapes: Shapes): void {
    this.clear();
    const { points, segments, triangles } = shapes;
    if (triangles.length) this.#add(new Mesh(plain(triangles), this.#material(FILL_VERTEX, FILL_FRAGMENT)));
    if (segments.length) this.#add(new Mesh(quads(segments), this.#material(LINE_VERTEX, LINE_FRAGMENT)));
    if (points.length) this.#add(new Points(plain(points), this.#material(DOT_VERTEX, DOT_FRAGMENT)));
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

  #material(vertexShader: string, fragmentShader: string): RawShaderMaterial {
    return new RawShaderMaterial({
      vertexShader,
      fragmentShader,
      uniforms: this.#uniforms,
      glslVersion: GLSL3,
      side: DoubleSide,
      forceSinglePass: true,
      transparent: true,
      depthTest: false,
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
