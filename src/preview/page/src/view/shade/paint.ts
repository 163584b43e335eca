// The materials of one role. They outlive its meshes, as a program is compiled anew when its last material goes.

import { DoubleSide, GLSL3, ShaderMaterial, Vector3 } from "three";
import type { IUniform } from "three";
import type { Role } from "../../server/protocol";
import { CLOTH_FRAGMENT, CLOTH_VERTEX } from "./clothShader";
import { OVERLAYS } from "./colours";

export class Paint {
  /** What the mesh sets, and what all meshes share. */
  readonly uniforms: Record<string, IUniform>;
  readonly solid: ShaderMaterial;
  /** The same with shadows, for pictures at rest: their code would slow moving ones. */
  readonly shaded: ShaderMaterial;
  /** Wires over another mesh. */
  readonly overlay: ShaderMaterial;
  /** Numbers of faces in place of colours. */
  readonly pick: ShaderMaterial;
  /** Depth alone, as the light sees it. */
  readonly depth: ShaderMaterial;

  constructor(role: Role, shared: Record<string, IUniform>) {
    this.uniforms = { ...shared, ...ownUniforms(role) };
    const level = { ...this.uniforms, uOverlay: { value: false }, uBias: { value: 0 } };
    const over = { ...this.uniforms, uOverlay: { value: true } };
    this.solid = cloth({ uniforms: level, polygonOffsetFactor: 1 });
    this.shaded = cloth({ uniforms: level, defines: { SHADOWS: true }, polygonOffsetFactor: 1 });
    this.overlay = cloth({ uniforms: over, transparent: true, depthWrite: false });
    this.pick = cloth({ uniforms: level, defines: { PICK: true } });
    this.depth = cloth({ uniforms: level, defines: { DEPTH: true }, colorWrite: false });
  }

  /** Which code cloth needs: it would slow other cloth. */
  setCodes(codes: Codes): void {
    for (const material of [this.solid, this.shaded]) {
      for (const [name, is] of Object.entries(codes)) {
        if (name in material.defines === is) continue;
        if (is) material.defines[name] = true;
        else delete material.defines[name];
        material.needsUpdate = true;
      }
    }
  }
}

/** Code for the images of the model's materials, for a chosen image and for a relief. */
export type Codes = Record<"IMAGES" | "FABRIC" | "RELIEF", boolean>;

function ownUniforms(role: Role): Record<string, IUniform> {
  return {
    uPoints: { value: null },
    uNormals: { value: null },
    uFaces: { value: null },
    uLooks: { value: null },
    uUvLength: { value: 1 },
    uHasUv: { value: false },
    uHasValues: { value: false },
    uSquares: { value: 32 },
    uAboutIdeal: { value: false },
    uHanded: { value: 1 },
    uWireColour: { value: new Vector3(...OVERLAYS[role]) },
  };
}

function cloth(parameters: ConstructorParameters<typeof ShaderMaterial>[0]): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader: CLOTH_VERTEX,
    fragmentShader: CLOTH_FRAGMENT,
    glslVersion: GLSL3,
    side: DoubleSide,
    forceSinglePass: true,
    ...parameters,
  });
}
