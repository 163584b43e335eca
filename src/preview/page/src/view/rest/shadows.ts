// Depth of the cloth as the light sees it, which says what lies in its shadow.

import {
  DepthTexture,
  Matrix4,
  OrthographicCamera,
  Quaternion,
  RedFormat,
  UnsignedIntType,
  Vector3,
  Vector4,
  WebGLRenderTarget,
} from "three";
import type { Camera, IUniform, Sphere, WebGLRenderer } from "three";
import type { Cloth } from "../mesh/cloth";
import { LIGHT_AXIS, LIGHTS } from "./samples";
import type { Sample } from "./samples";

/** Width of a map. [pixels] */
const WIDTH = 1024;
/** How much of the light is gone where all of it is held off. */
const STRENGTH = 0.62;
/** Distance of the planes of a map, as a part of the radius of all cloth. */
const DEPTH = 2.02;
/** The widest blur of the edge of a shadow, likewise. */
const BLUR = 0.06;

export class Shadows {
  readonly #maps = [...Array(LIGHTS)].map(depthMap);
  readonly #camera = new OrthographicCamera();
  readonly uniforms: Record<string, IUniform> = {
    uShade: { value: 0 },
    uLights: { value: [...Array(LIGHTS)].map(() => new Vector3(0, 0, 1)) },
    uLightAxis: { value: LIGHT_AXIS },
    uLightMatrices: { value: [...Array(LIGHTS)].map(() => new Matrix4()) },
    uLightMaps: { value: this.#maps.map((map) => map.depthTexture) },
    uLightSpan: { value: new Vector4() },
    uNoise: { value: 0 },
  };

  constructor(private readonly renderer: WebGLRenderer) {
    // Shaders refuse maps that are not there yet.
    for (const map of this.#maps) renderer.initRenderTarget(map);
  }

  /** Draws the maps of a sample, one in each step. `view` is what the eye sees of all cloth. */
  *cast(cloth: Cloth, { number, lights, shade }: Sample, eye: Camera, all: Sphere, view: Sphere): Generator<void> {
    const ball = view.radius < all.radius ? view : all;
    for (const [at, light] of lights.entries()) {
      this.#aim(light.clone().transformDirection(eye.matrixWorld), all, ball);
      this.#draw(this.#maps[at], cloth);
      (this.uniforms.uLights.value as Vector3[])[at].copy(light);
      const matrix = (this.uniforms.uLightMatrices.value as Matrix4[])[at];
      matrix.multiplyMatrices(this.#camera.projectionMatrix, this.#camera.matrixWorldInverse).multiply(eye.matrixWorld);
      yield;
    }
    const width = 2 * ball.radius;
    (this.uniforms.uLightSpan.value as Vector4).set(width / WIDTH, width, DEPTH * all.radius, BLUR * all.radius);
    this.uniforms.uNoise.value = number;
    this.uniforms.uShade.value = STRENGTH * shade;
  }

  /** All cloth is between the planes, since what is out of view has shadows too. */
  #aim(light: Vector3, all: Sphere, { center, radius }: Sphere): void {
    const camera = this.#camera;
    const depth = all.center.clone().sub(center).dot(light);
    camera.position.copy(center).addScaledVector(light, depth + 0.5 * DEPTH * all.radius);
    camera.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), light));
    Object.assign(camera, { left: -radius, right: radius, top: radius, bottom: -radius });
    Object.assign(camera, { near: 0, far: DEPTH * all.radius });
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  #draw(map: WebGLRenderTarget, { solid, paint }: Cloth): void {
    this.renderer.setRenderTarget(map);
    this.renderer.clear(false, true, false);
    const { material } = solid;
    solid.material = paint.depth;
    this.renderer.render(solid, this.#camera);
    solid.material = material;
  }
}

function depthMap(): WebGLRenderTarget {
  const depthTexture = new DepthTexture(WIDTH, WIDTH, UnsignedIntType);
  return new WebGLRenderTarget(WIDTH, WIDTH, { depthTexture, format: RedFormat });
}
