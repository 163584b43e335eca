// A mesh on the graphics card. Triangles are static and point into textures, so that a frame with new positions sends
// those only.

import { Box3, BufferAttribute, BufferGeometry, Group, Mesh, Sphere } from "three";
import type { DataTexture, ShaderMaterial } from "three";
import type { MeshFrame } from "../../server/frame";
import type { LookInfo, MeshHeader } from "../../server/protocol";
import { computeNormals } from "./normals";
import type { Paint } from "../shade/paint";
import { copyPoints } from "./points";
import { BORDER, HIDDEN } from "../shade/classes";
import { edgeClasses, fillFaces, Membership, namesDrawn, readSets } from "./sets";
import { squareOf } from "../shade/checker";
import { scaleOf } from "../shade/heat";
import { fillLooks } from "../shade/fabric";
import { SetLines } from "./setLines";
import { sourceOf } from "./sources";
import type { ElementSet } from "./sets";
import { byteTexture, floatTexture, integers } from "./textures";
import { sharesOf } from "./values";
import type { MeshValues } from "./values";
import { Edges, startsOf, triangulate } from "./topology";
import type { Faces, Triangles } from "./topology";

/** What a mesh takes of a frame. */
export interface Content extends Pick<MeshFrame, "f32" | "u32" | "u8"> {
  header: Pick<MeshHeader, "leftHanded" | "sets" | "values">;
}

/** One topology of one role. */
export class Cloth {
  /** The triangles and the lines of sets. */
  readonly object = new Group();
  readonly solid: Mesh<BufferGeometry, ShaderMaterial>;
  readonly lines = new SetLines(this);
  readonly edges: Edges;
  readonly pointCount: number;
  /** x, y, z and an unused number of each point. */
  readonly points: Float32Array;
  readonly normals: Float32Array;
  readonly faces: Faces;
  /** -1 if faces run the other way round, so that normals point inwards. */
  readonly handed: 1 | -1;
  readonly triangles: Triangles;
  box = new Box3();
  /** u, v of each corner, or empty. */
  uvs: Float32Array = new Float32Array(0);
  /** Mean length on the surface of one unit of UV, or 0 if it is not known. */
  uvLength = 0;
  uvRange = 1;
  /** The model's face of each face before refinement for display; null for the model. */
  sources: Uint32Array | null = null;
  /** What heat shows. */
  values: MeshValues | null = null;
  sets: ElementSet[] = [];
  membership: Membership;
  /** Faces of the model whose parts alone are drawn; null for all. */
  #isolated: ReadonlySet<number> | null = null;
  #highlighted: ReadonlySet<string> = new Set();
  readonly #pointTexture: DataTexture;
  readonly #normalTexture: DataTexture;
  readonly #faceTexture: DataTexture;
  readonly #lookTexture: DataTexture;
  #looks: LookInfo[] = [];
  /** Addresses of the images that are there. */
  #layers: string[] = [];
  /** Known once they are asked for. */
  #lined: string[] | null = null;
  readonly #geometry = new BufferGeometry();

  constructor(
    frame: Content,
    readonly paint: Paint,
  ) {
    const points = frame.f32("points") ?? new Float32Array(0);
    this.handed = frame.header.leftHanded ? -1 : 1;
    this.pointCount = points.length / 3;
    this.faces = {
      starts: startsOf(frame.u32("faceCounts") ?? new Uint32Array(0)),
      corners: (frame.u32("facePoints") ?? new Uint32Array(0)).slice(),
      shown: frame.u8("edges")?.slice() ?? null,
      owner: frame.u32("faceOf")?.slice() ?? null,
    };
    this.#pointTexture = floatTexture(this.pointCount);
    this.#normalTexture = floatTexture(this.pointCount);
    this.#faceTexture = byteTexture(this.faceCount);
    this.#lookTexture = byteTexture(this.faceCount);
    this.points = (this.#pointTexture.image.data as Float32Array).subarray(0, 4 * this.pointCount);
    this.normals = (this.#normalTexture.image.data as Float32Array).subarray(0, 4 * this.pointCount);
    this.edges = new Edges(this.faces, this.pointCount);
    this.membership = new Membership([], this.edges);
    this.#setPoints(points);
    this.triangles = triangulate(this.faces, this.points, frame.u32("holes"));
    this.#bind();
    this.#addAttributes();
    this.solid = new Mesh(this.#geometry, this.paint.solid);
    this.solid.frustumCulled = false;
    this.object.add(this.solid, this.lines.object);
    this.#setRest(frame);
    if (!frame.header.sets) this.#paintSets();
  }

  get faceCount(): number {
    return this.faces.starts.length - 1;
  }

  get hasUvs(): boolean {
    return this.uvs.length > 0;
  }

  /** Takes the blocks of a frame that keeps the faces. */
  update(frame: Content): void {
    const points = frame.f32("points");
    if (points && points.length === 3 * this.pointCount) this.#setPoints(points);
    this.#setRest(frame);
  }

  /** Takes the UVs alone, if it has none and they fit: a mesh that is kept may have come without them. */
  takeUvs(frame: Content): void {
    const uvs = frame.f32("uvs");
    if (!uvs || this.hasUvs || uvs.length !== 2 * this.faces.corners.length) return;
    this.#setUvs(uvs);
    this.#paintSets();
  }

  /** Takes the looks of the model's materials. */
  setLooks(looks: LookInfo[], layers: string[]): void {
    this.#looks = looks;
    this.#layers = layers;
    this.#paintLooks();
  }

  /** The colours of sets are others. */
  recolour(): void {
    this.#paintSets();
  }

  /** Names of the edge sets that have a line. */
  drawnEdgeSets(): string[] {
    this.#lined ??= namesDrawn(this.edges, this.sets);
    return this.#lined;
  }

  /** Sets the squares of the checker to a length on the surface; without a scale there are 32 over the UVs. */
  setSquare(length: number): void {
    const known = this.uvLength > 0 && length > 0;
    this.paint.uniforms.uSquares.value = known ? this.uvLength / length : 1 / squareOf(this.uvRange);
  }

  highlight(names: ReadonlySet<string>): void {
    const had = this.sets.some((set) => this.#highlighted.has(set.name));
    const has = this.sets.some((set) => names.has(set.name));
    this.#highlighted = names;
    if (had || has) this.#paintSets();
  }

  /** Draws the parts of these faces of the model alone, or all for null. */
  isolate(faces: ReadonlySet<number> | null): void {
    if (faces === null && this.#isolated === null) return;
    this.#isolated = faces;
    const kept: number[] = [];
    this.triangles.faces.forEach((face, triangle) => {
      if (this.isDrawn(face)) kept.push(3 * triangle, 3 * triangle + 1, 3 * triangle + 2);
    });
    this.#geometry.setIndex(faces && new BufferAttribute(new Uint32Array(kept), 1));
    this.#geometry.setDrawRange(0, faces ? kept.length : this.triangles.corners.length);
    this.#paintSets();
  }

  get isIsolated(): boolean {
    return this.#isolated !== null;
  }

  isDrawn(face: number): boolean {
    return this.#isolated === null || this.#isolated.has(sourceOf(this, face));
  }

  /** Thickens the first of these edge sets that the mesh has. */
  setHot(names: string[]): void {
    const set = this.sets.find(({ name, kind }) => kind === "edge" && name === names[0]);
    this.lines.setHot(set ? set.edgeClass : -1);
  }

  dispose(): void {
    this.#geometry.dispose();
    this.lines.dispose();
    for (const map of [this.#pointTexture, this.#normalTexture, this.#faceTexture, this.#lookTexture]) map.dispose();
  }

  #setPoints(points: Float32Array): void {
    this.box = copyPoints(points, this.points);
    computeNormals(this.points, this.faces, this.normals);
    this.lines.follow();
    this.#pointTexture.needsUpdate = true;
    this.#normalTexture.needsUpdate = true;
  }

  /** All but the points and the faces. */
  #setRest(frame: Content): void {
    const { header } = frame;
    const sources = frame.u32("sources");
    if (sources) this.sources = sources.length > 0 ? sources.slice() : null;
    if (sources && this.#isolated) this.isolate(this.#isolated);
    const uvs = frame.f32("uvs");
    if (uvs) this.#setUvs(uvs);
    if (uvs && !header.sets) this.#paintSets();
    if (header.sets) {
      this.sets = readSets(header.sets, frame.u32("elements"));
      this.membership = new Membership(this.sets, this.edges);
      this.#lined = null;
      this.#paintLooks();
      this.#paintSets();
    }
    const values = frame.f32("values");
    if (header.values && values) this.#setValues({ ...header.values, numbers: values.slice() });
    if (header.values === null) this.#dropValues();
    this.paint.uniforms.uHasValues.value = this.#geometry.hasAttribute("aValue");
  }

  #setUvs(uvs: Float32Array): void {
    this.uvs = uvs.length === 2 * this.faces.corners.length ? uvs.slice() : new Float32Array(0);
    this.paint.uniforms.uHasUv.value = this.hasUvs;
    this.uvRange = rangeOf(this.uvs);
    this.uvLength = lengthOfUv(this.uvs, this.points, this.faces);
    this.paint.uniforms.uUvLength.value = this.uvLength || 1;
    if (!this.hasUvs) return;
    const array = this.#attribute("aUv", 2);
    const { corners } = this.triangles;
    for (let at = 0; at < corners.length; at++) {
      array[2 * at] = this.uvs[2 * corners[at]];
      array[2 * at + 1] = this.uvs[2 * corners[at] + 1];
    }
  }

  /** Shows values of its own, or none for null. */
  showValues(values: MeshValues | null): void {
    if (values) this.#setValues(values);
    else this.#dropValues();
    this.paint.uniforms.uHasValues.value = values !== null;
  }

  #setValues(values: MeshValues): void {
    this.values = values;
    this.paint.uniforms.uAboutIdeal.value = scaleOf(values).isAboutIdeal;
    const shares = sharesOf(values);
    const array = this.#attribute("aValue", 1);
    const { corners, faces } = this.triangles;
    for (let at = 0; at < corners.length; at++) {
      const corner = corners[at];
      array[at] = shares[{ point: this.faces.corners[corner], corner, face: faces[(at / 3) | 0] }[values.of]];
    }
  }

  #dropValues(): void {
    this.values = null;
    this.#geometry.deleteAttribute("aValue");
  }

  #paintLooks(): void {
    fillLooks(this.#lookTexture.image.data as Uint8Array, this.sets, this.#looks, this.#layers);
    this.#lookTexture.needsUpdate = true;
  }

  #paintSets(): void {
    fillFaces(this.#faceTexture.image.data as Uint8Array, this.sets, this.#highlighted);
    this.#faceTexture.needsUpdate = true;
    const classes = edgeClasses(this.edges, this.sets, this.#highlighted);
    const attribute = this.#geometry.getAttribute("aEdges") as BufferAttribute;
    this.#fillEdges(attribute.array as Uint8Array, classes);
    attribute.needsUpdate = true;
    this.lines.set(classes);
  }

  /** Classes of the edges of each triangle: first to second corner, second to third, third to first. */
  #fillEdges(array: Uint8Array, classes: Uint8Array): void {
    const { corners, faces } = this.triangles;
    const { starts, shown } = this.faces;
    const classAt = (face: number, from: number, to: number): number => {
      const next = from + 1 < starts[face + 1] ? from + 1 : starts[face];
      if (to !== next || (shown && !shown[from])) return HIDDEN;
      const edge = this.edges.ofCorner[from];
      return classes[edge] | (this.edges.uses[edge] === 1 ? BORDER : 0);
    };
    for (let triangle = 0; triangle < faces.length; triangle++) {
      const face = faces[triangle];
      const a = corners[3 * triangle];
      const b = corners[3 * triangle + 1];
      const c = corners[3 * triangle + 2];
      const ab = classAt(face, a, b);
      const bc = classAt(face, b, c);
      const ca = classAt(face, c, a);
      for (let at = 12 * triangle; at < 12 * triangle + 12; at += 4) {
        array[at] = ab;
        array[at + 1] = bc;
        array[at + 2] = ca;
      }
    }
  }

  #addAttributes(): void {
    const { corners, faces } = this.triangles;
    const points = new Uint32Array(corners.length);
    const owners = new Uint32Array(corners.length);
    for (let at = 0; at < corners.length; at++) {
      points[at] = this.faces.corners[corners[at]];
      owners[at] = faces[(at / 3) | 0];
    }
    this.#geometry.setAttribute("aPoint", integers(points, 1));
    this.#geometry.setAttribute("aFace", integers(owners, 1));
    this.#geometry.setAttribute("aEdges", integers(new Uint8Array(4 * corners.length), 4));
    this.#geometry.setDrawRange(0, corners.length);
    // It is not there to be computed, as positions are in a texture.
    this.#geometry.boundingSphere = new Sphere();
  }

  /** The array of a float attribute, which is made when first needed. */
  #attribute(name: string, size: number): Float32Array {
    const known = this.#geometry.getAttribute(name) as BufferAttribute | undefined;
    const attribute = known ?? new BufferAttribute(new Float32Array(size * this.triangles.corners.length), size);
    if (!known) this.#geometry.setAttribute(name, attribute);
    attribute.needsUpdate = true;
    return attribute.array as Float32Array;
  }

  /** The materials of the role draw this mesh from now on. */
  #bind(): void {
    const { uniforms } = this.paint;
    uniforms.uPoints.value = this.#pointTexture;
    uniforms.uNormals.value = this.#normalTexture;
    uniforms.uFaces.value = this.#faceTexture;
    uniforms.uLooks.value = this.#lookTexture;
    uniforms.uHanded.value = this.handed;
    uniforms.uHasUv.value = false;
  }
}

/** From the least to the largest coordinate, or 1 if there is none. */
function rangeOf(uvs: Float32Array): number {
  let [least, most] = [Infinity, -Infinity];
  for (const value of uvs) {
    if (value < least) least = value;
    if (value > most) most = value;
  }
  return most > least ? most - least : 1;
}

/** Length in space of one unit of UV, by the first edge of each face; 0 without UVs. */
function lengthOfUv(uvs: Float32Array, points: Float32Array, faces: Faces): number {
  let [space, flat] = [0, 0];
  for (let face = 0; face + 1 < faces.starts.length && uvs.length > 0; face++) {
    const corner = faces.starts[face];
    const [a, b] = [4 * faces.corners[corner], 4 * faces.corners[corner + 1]];
    space += Math.hypot(points[a] - points[b], points[a + 1] - points[b + 1], points[a + 2] - points[b + 2]);
    flat += Math.hypot(uvs[2 * corner] - uvs[2 * corner + 2], uvs[2 * corner + 1] - uvs[2 * corner + 3]);
  }
  return flat > 0 ? space / flat : 0;
}
