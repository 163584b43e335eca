// The mean of the samples, in numbers finer than those of the screen.

import {
  BufferAttribute,
  BufferGeometry,
  Camera,
  ConstantAlphaFactor,
  CustomBlending,
  GLSL3,
  HalfFloatType,
  Mesh,
  NearestFilter,
  NoBlending,
  OneMinusConstantAlphaFactor,
  RawShaderMaterial,
  WebGLRenderTarget,
} from "three";
import type { WebGLRenderer } from "three";

const VERTEX = /* glsl */ `
precision highp float;
in vec2 corner;
void main() {
  gl_Position = vec4(corner, 0.0, 1.0);
}
`;

// What is no number would stay in the mean.
const FRAGMENT = /* glsl */ `
precision highp float;
uniform sampler2D uPicture;
out vec4 colour;
void main() {
  vec4 c = texelFetch(uPicture, ivec2(gl_FragCoord.xy), 0);
  colour = vec4(c == c ? c : vec4(0.0));
}
`;

export class Mean {
  /** The newest sample. */
  readonly sample: WebGLRenderTarget;
  readonly #sum: WebGLRenderTarget;
  readonly #add = quad(true);
  readonly #copy = quad(false);
  readonly #camera = new Camera();
  #count = 0;

  /** Sizes in device pixels. */
  constructor(
    private readonly renderer: WebGLRenderer,
    readonly width: number,
    readonly height: number,
  ) {
    const options = { type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter } as const;
    this.sample = new WebGLRenderTarget(width, height, options);
    this.#sum = new WebGLRenderTarget(width, height, { ...options, depthBuffer: false });
  }

  /** Whether the graphics card can draw and blend such numbers. */
  static fits(renderer: WebGLRenderer): boolean {
    return renderer.extensions.has("EXT_color_buffer_float");
  }

  restart(): void {
    this.#count = 0;
  }

  /** Adds what was drawn to `sample`. */
  add(): void {
    const { renderer } = this;
    renderer.setRenderTarget(this.#sum);
    if (this.#count === 0) renderer.clear();
    this.#count += 1;
    this.#add.material.blendAlpha = 1 / this.#count;
    this.#add.material.uniforms.uPicture.value = this.sample.texture;
    renderer.render(this.#add, this.#camera);
    renderer.setRenderTarget(null);
  }

  /** Draws the mean on the canvas, or to a target of the same size. */
  show(target: WebGLRenderTarget | null): void {
    const { renderer } = this;
    renderer.setRenderTarget(target);
    if (!target) renderer.setViewport(0, 0, this.width / renderer.getPixelRatio(), this.height / renderer.getPixelRatio());
    this.#copy.material.uniforms.uPicture.value = this.#sum.texture;
    renderer.render(this.#copy, this.#camera);
    renderer.setRenderTarget(null);
  }

  dispose(): void {
    this.sample.dispose();
    this.#sum.dispose();
  }
}

/** Covers all of a target. */
function quad(adds: boolean): Mesh<BufferGeometry, RawShaderMaterial> {
  const material = new RawShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    glslVersion: GLSL3,
    uniforms: { uPicture: { value: null } },
    depthTest: false,
    depthWrite: false,
    blending: adds ? CustomBlending : NoBlending,
    blendSrc: ConstantAlphaFactor,
    blendDst: OneMinusConstantAlphaFactor,
  });
  const corners = new BufferAttribute(new Float32Array([-1, -1, 3, -1, -1, 3]), 2);
  const geometry = new BufferGeometry().setAttribute("corner", corners);
  geometry.setDrawRange(0, 3);
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}
