// The edge sets of a mesh as lines. They read their ends from the mesh's texture, so that they follow it.

import { BufferAttribute, InstancedBufferAttribute, InstancedBufferGeometry, IntType, Mesh, Sphere } from "three";
import type { RawShaderMaterial } from "three";
import { QUAD } from "./marks";
import type { Paint } from "../shade/paint";
import { HIGHLIGHTED } from "../shade/classes";
import { nextCorner } from "./topology";
import type { Edges, Faces } from "./topology";

interface Source {
  faces: Faces;
  edges: Edges;
  uvs: Float32Array;
  isDrawn(face: number): boolean;
}

export class SetLines {
  readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;

  constructor(private readonly paint: Paint) {
    this.mesh = new Mesh(emptyLines(), paint.lines);
    this.mesh.frustumCulled = false;
  }

  /** Whether the mesh lies over another one. */
  setOver(over: boolean): void {
    this.paint.uniforms.uOver.value = over;
    this.mesh.renderOrder = over ? 5 : 1;
  }

  setVisible(visible: boolean): void {
    this.mesh.visible = visible && this.mesh.geometry.instanceCount > 0;
  }

  /** Takes the edges of which the class is that of a set. Each face has its own line, as in the flat view it is
   *  elsewhere. */
  set(source: Source, classes: Uint8Array): void {
    const corners = cornersOfSets(source, classes);
    const ends = new Uint32Array(2 * corners.length);
    const uvs = new Float32Array(4 * corners.length);
    corners.forEach(([corner, next], at) => {
      ends[2 * at] = source.faces.corners[corner];
      ends[2 * at + 1] = source.faces.corners[next];
      if (source.uvs.length === 0) return;
      uvs.set(source.uvs.subarray(2 * corner, 2 * corner + 2), 4 * at);
      uvs.set(source.uvs.subarray(2 * next, 2 * next + 2), 4 * at + 2);
    });
    this.mesh.geometry.dispose();
    this.mesh.geometry = emptyLines();
    this.#add("aEnds", ends, 2);
    this.#add("aUvs", uvs, 4);
    this.#add("aClass", Uint8Array.from(corners, ([corner]) => classes[source.edges.ofCorner[corner]]), 1);
    this.mesh.geometry.instanceCount = corners.length;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
  }

  #add(name: string, array: Uint32Array | Uint8Array | Float32Array, size: number): void {
    const attribute = new InstancedBufferAttribute(array, size);
    if (!(array instanceof Float32Array)) attribute.gpuType = IntType;
    this.mesh.geometry.setAttribute(name, attribute);
  }
}

function cornersOfSets(source: Source, classes: Uint8Array): [number, number][] {
  const { faces, edges } = source;
  const found: [number, number][] = [];
  for (let face = 0; face + 1 < faces.starts.length; face++) {
    if (!source.isDrawn(face)) continue;
    for (let corner = faces.starts[face]; corner < faces.starts[face + 1]; corner++) {
      const isSet = classes[edges.ofCorner[corner]] >= HIGHLIGHTED;
      if (isSet && (!faces.shown || faces.shown[corner])) found.push([corner, nextCorner(faces, face, corner)]);
    }
  }
  return found;
}

function emptyLines(): InstancedBufferGeometry {
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute("corner", new BufferAttribute(QUAD, 2));
  geometry.setDrawRange(0, 6);
  geometry.instanceCount = 0;
  geometry.boundingSphere = new Sphere();
  return geometry;
}
