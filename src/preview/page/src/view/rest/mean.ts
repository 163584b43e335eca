// The mean of the samples, in numbers finer than those of the screen.

import {
  ConstantAlphaFactor,
  CustomBlending,
  HalfFloatType,
  NearestFilter,
  NoBlending,
  OneMinusConstantAlphaFactor,
  ShaderMaterial,
  WebGLRenderTarget,
} from "three";
import type { WebGLRenderer } from "three";
import { FullScreenQuad } from "three/examples/jsm/postprocessing/Pass.js";

// What is no number would stay in the mean.
const FRAGMENT = /* glsl */ `
uniform sampler2D uPicture;
void main() {
  vec4 c = texelFetch(uPicture, ivec2(gl_FragCoord.xy), 0);
  gl_FragColor = vec4(c == c ? c : vec4(0.0));
}
`;

export class Mean {
  /** The newest sample. */
  readonly sample: WebGLRenderTarget;
  readonly #sum: WebGLRenderTarget;
  readonly #add = copier(true);
  readonly #copy = copier(false);
  readonly #quad = new FullScreenQuad();
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
    this.#count += 1;
    this.#add.blendAlpha = 1 / this.#count;
    this.#draw(this.#add, this.sample, this.#sum);
  }

  /** Draws the mean on the canvas, or to a target of the same size. */
  show(target: WebGLRenderTarget | null): void {
    const ratio = this.renderer.getPixelRatio();
    if (!target) this.renderer.setViewport(0, 0, this.width / ratio, this.height / ratio);
    this.#draw(this.#copy, this.#sum, target);
  }

  #draw(material: ShaderMaterial, from: WebGLRenderTarget, to: WebGLRenderTarget | null): void {
    material.uniforms.uPicture.value = from.texture;
    this.#quad.material = material;
    this.renderer.setRenderTarget(to);
    if (to === this.#sum && this.#count === 1) this.renderer.clear();
    this.#quad.render(this.renderer);
    this.renderer.setRenderTarget(null);
  }

  dispose(): void {
    this.sample.dispose();
    this.#sum.dispose();
  }
}

/** Covers all of a target. */
function copier(adds: boolean): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
    fragmentShader: FRAGMENT,
    uniforms: { uPicture: { value: null } },
    depthTest: false,
    depthWrite: false,
    blending: adds ? CustomBlending : NoBlending,
    blendSrc: ConstantAlphaFactor,
    blendDst: OneMinusConstantAlphaFactor,
  });
}
