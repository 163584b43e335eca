// Lines of a constant width on the screen, and what lies in the surface.

import { Vector2 } from "three";
import type { Camera, InterleavedBufferAttribute, IUniform, Object3D } from "three";
import { LineMaterial, type LineMaterialParameters } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";

/** Size of the view that is drawn, for all lines. [CSS pixels] */
const view: IUniform<Vector2> = { value: new Vector2(1, 1) };

/** Widths are in CSS pixels. */
export function lineMaterial(parameters: LineMaterialParameters): LineMaterial {
  const material = new LineMaterial(parameters);
  material.uniforms.resolution = view;
  return material;
}

export class Lines extends LineSegments2 {
  constructor(material: LineMaterial) {
    super(new LineSegmentsGeometry(), material);
    this.frustumCulled = false;
    this.visible = false;
    // It would take the size of the canvas.
    this.onBeforeRender = () => undefined;
  }

  /** Takes both ends of each line, and their colours. As many as before go into the same buffer. */
  set(ends: Float32Array, colours?: Float32Array): void {
    const data = (this.geometry.attributes.instanceStart as InterleavedBufferAttribute | undefined)?.data;
    if (data?.array.length !== ends.length || colours) {
      this.geometry.dispose();
      this.geometry = new LineSegmentsGeometry().setPositions(ends);
      if (colours) this.geometry.setColors(colours);
    } else {
      data.array.set(ends);
      data.needsUpdate = true;
    }
    this.visible = ends.length > 0;
  }
}

/** The part of the canvas or of a picture that a camera draws. [CSS pixels] */
export interface Eye {
  camera: Camera;
  width: number;
  height: number;
}

export function setView({ width, height }: Eye): void {
  view.value.set(width, height);
}

/** Moves what lies in the surface towards the eye by some pixels at its distance, and by a share of the distance. */
export function lift(object: Object3D, { camera, height }: Eye, pixels: number, more = 0): void {
  const { elements } = camera.projectionMatrix;
  const isPerspective = elements[15] === 0;
  const share = isPerspective ? (2 * pixels) / (elements[5] * height) + more : 0;
  object.scale.setScalar(1 - share);
  object.position.copy(camera.position).multiplyScalar(share);
  if (!isPerspective) object.position.z = 0.001 * pixels;
}
