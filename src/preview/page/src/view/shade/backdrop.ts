// What is behind the mesh: a soft gradient, the ground below the garment, and the square of the UV plane.

import { BufferAttribute, BufferGeometry, GLSL3, Mesh, RawShaderMaterial, Vector2, Vector3 } from "three";
import type { IUniform } from "three";
import { LOOKS } from "./colours";
import type { Theme } from "./colours";

const SKY_VERTEX = /* glsl */ `
precision highp float;
in vec2 corner;
out float vHeight;
void main() {
  vHeight = corner.y * 0.5 + 0.5;
  gl_Position = vec4(corner, 1.0, 1.0);
}
`;

// Noise of less than one step hides the bands of a dark gradient.
const SKY_FRAGMENT = /* glsl */ `
precision highp float;
uniform vec3 uTop;
uniform vec3 uBottom;
in float vHeight;
out vec4 colour;
void main() {
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  colour = vec4(mix(uBottom, uTop, smoothstep(0.0, 1.0, vHeight)) + noise / 255.0, 1.0);
}
`;

const GROUND_VERTEX = /* glsl */ `
precision highp float;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
in vec2 corner;
out vec2 vAt;
void main() {
  vAt = corner;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(corner, 0.0, 1.0);
}
`;

const GROUND_FRAGMENT = /* glsl */ `
precision highp float;
uniform vec2 uFoot;
uniform vec3 uLine;
uniform float uShade;
in vec2 vAt;
out vec4 colour;

float grid(vec2 p) {
  vec2 w = max(fwidth(p), vec2(1e-6));
  vec2 d = abs(fract(p - 0.5) - 0.5) / w;
  vec2 fade = 1.0 - smoothstep(0.15, 0.5, w);
  vec2 line = clamp(1.0 - d, 0.0, 1.0) * fade;
  return max(line.x, line.y);
}

void main() {
  float r = length(vAt);
  float lines = 0.16 * grid(vAt * 8.0) * (1.0 - smoothstep(0.25, 0.95, r));
  vec2 foot = vAt / uFoot;
  float shadow = uShade * exp(-1.6 * dot(foot, foot));
  float alpha = lines + shadow * (1.0 - lines);
  colour = vec4(uLine * lines / max(alpha, 1e-4), alpha);
}
`;

const SQUARE_FRAGMENT = /* glsl */ `
precision highp float;
uniform vec3 uLine;
in vec2 vAt;
out vec4 colour;
void main() {
  vec2 w = fwidth(vAt);
  vec2 p = vAt * 0.51 + 0.5;
  vec2 d = min(abs(p), abs(1.0 - p)) / (w * 0.51);
  bool inside = all(greaterThan(p, -w)) && all(lessThan(p, 1.0 + w));
  float line = clamp(1.2 - min(d.x, d.y), 0.0, 1.0);
  colour = vec4(uLine, inside ? max(0.05, 0.45 * line) : 0.0);
}
`;

export class Backdrop {
  readonly sky: Mesh;
  readonly ground: Mesh;
  readonly square: Mesh;
  readonly #uniforms: Record<string, IUniform> = {
    uTop: { value: new Vector3() },
    uBottom: { value: new Vector3() },
    uLine: { value: new Vector3() },
    uFoot: { value: new Vector2(1, 1) },
    uShade: { value: 0.3 },
  };

  constructor() {
    this.sky = this.#quad(SKY_VERTEX, SKY_FRAGMENT, -3);
    this.ground = this.#quad(GROUND_VERTEX, GROUND_FRAGMENT, -2);
    this.square = this.#quad(GROUND_VERTEX, SQUARE_FRAGMENT, -2);
    this.square.position.set(0.5, 0.5, 0);
    this.square.scale.setScalar(0.51);
  }

  setTheme(theme: Theme): void {
    const { top, bottom, line } = LOOKS[theme];
    (this.#uniforms.uTop.value as Vector3).set(...top);
    (this.#uniforms.uBottom.value as Vector3).set(...bottom);
    (this.#uniforms.uLine.value as Vector3).set(...line);
    this.#uniforms.uShade.value = theme === "light" ? 0.2 : 0.42;
  }

  /** Puts the ground at the lowest place of the garment. `half` is its half size, `up` the axis of the stage. */
  setGround(centre: Vector3, half: Vector3, up: Vector3): void {
    const upright = up.y > 0.5;
    const size = 1.45 * half.length();
    this.ground.scale.setScalar(size);
    this.ground.rotation.set(upright ? -Math.PI / 2 : 0, 0, 0);
    this.ground.position.copy(centre).addScaledVector(up, -half.dot(up));
    (this.#uniforms.uFoot.value as Vector2).set(half.x / size, (upright ? half.z : half.y) / size);
  }

  #quad(vertexShader: string, fragmentShader: string, order: number): Mesh {
    const corners = new Float32Array([-1, -1, 1, -1, 1, 1, -1, -1, 1, 1, -1, 1]);
    const material = new RawShaderMaterial({
      vertexShader,
      fragmentShader,
      uniforms: this.#uniforms,
      glslVersion: GLSL3,
      transparent: true,
      depthWrite: false,
      depthTest: order !== -3,
    });
    const geometry = new BufferGeometry().setAttribute("corner", new BufferAttribute(corners, 2));
    geometry.setDrawRange(0, 6);
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.renderOrder = order;
    return mesh;
  }
}
