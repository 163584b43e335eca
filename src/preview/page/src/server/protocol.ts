// Messages between the page and the server (src/preview/socket.rs). Text frames are JSON; binary frames are meshes.

/** The three meshes: the garment's input cage, and the two products. */
export type Role = "model" | "sim" | "render";

export type Value = number | boolean | string | string[];

/** Options of one operator: field to value. */
export type Fields = Record<string, Value>;

/** A sparse recipe, nested as in a `.tailor` file. Only the options that somebody gave are in it. */
export interface Options {
  sim?: Fields;
  render?: Fields;
  seam?: Record<string, Fields>;
  thickness?: Record<string, Fields>;
}

/** Its kind; a place that names the option (such as `seam.side.width`), prim or file; the problem; the cure. */
export interface Fault {
  code: string;
  place: string;
  text: string;
  remedy: string;
}

/** What an option accepts. Lengths are in the mesh's own units. */
export type Domain =
  | { type: "flag" }
  | { type: "number"; least: number; most: number; step: number }
  | { type: "whole"; least: number; most: number }
  /** A length; `auto` is the length that 0 stands for, or null if 0 means no length. `most` suits a slider, larger
   *  values may be typed. */
  | { type: "length"; least: number; most: number; auto: number | null }
  | { type: "choice"; values: string[] }
  /** One name, or "" for none. */
  | { type: "name"; of: "uvSet" | "weights" }
  /** Any number of names. */
  | { type: "names"; of: "edgeSet" | "faceSet" | "operator" };

/** A row of the option table, as in `usdtailor build --help`. */
export interface Option {
  /** `sim.maxEdgeLength`, or the field alone (`width`) for an operator. */
  key: string;
  unit: string;
  meaning: string;
  default: Value;
  domain: Domain;
}

/** A kind of operator, `seam` or `thickness`. */
export interface Kind {
  name: "seam" | "thickness";
  /** The field that names the sets, and what they are. */
  sets: { field: string; of: "edgeSet" | "faceSet" };
  options: Option[];
}

export interface SetInfo {
  name: string;
  kind: "face" | "edge" | "point";
  family: string;
  count: number;
}

/** A set by name. */
export interface PickedSet {
  name: string;
  kind: "face" | "edge" | "point";
}

export interface PrimvarInfo {
  name: string;
  type: string;
  interpolation: "uniform" | "varying" | "vertex" | "faceVarying" | "constant";
  /** Numbers in one value: 1 can be shown as heat, 2 and faceVarying is a UV set. */
  width: number;
  isFloat: boolean;
}

export interface VariantSet {
  prim: string;
  set: string;
  choices: string[];
  selected: string;
}

/** First message of a connection, and again each time the stage is read anew. */
export interface GarmentMessage {
  type: "garment";
  version: string;
  /** File name without its folder, and the prim path. */
  file: string;
  prim: string;
  upAxis: "Y" | "Z";
  metersPerUnit: number;
  points: number;
  faces: number;
  meanEdge: number;
  sets: SetInfo[];
  primvars: PrimvarInfo[];
  variants: VariantSet[];
  options: Option[];
  kinds: Kind[];
  /** Where `save` suggests to write. */
  /** Files to save to. Panels that are sewn together have no layer: their options are of no prim. */
  suggested: { layer: string | null; recipe: string };
  /** Warnings of the stage and of its mesh; those of the products are in their own messages. */
  warnings: Warning[];
}

/** The shared document of all pages. Sent after each change. */
export interface StateMessage {
  type: "state";
  /** Counts the changes; meshes carry the revision that they were made from. */
  revision: number;
  /** Serial of the last edit of this page that the document includes. */
  serial: number;
  /** Options of the garment and of `--recipe`, below the edits. */
  upstream: Options;
  /** Options that were changed here. */
  edits: Options;
  canUndo: boolean;
  canRedo: boolean;
  /** True if the edits are not in a file. */
  unsaved: boolean;
  /** The earlier state that `compare` shows in place of the edits. */
  comparing: "step" | "saved" | null;
}

/** Faults of the current document or of the file on disk. The last good meshes stay. Empty when all is well. */
export interface FaultsMessage {
  type: "faults";
  /** `file`: the stage on disk cannot be read; `recipe`: an option is wrong; others: the build of that product. */
  origin: "file" | "recipe" | "sim" | "render";
  faults: Fault[];
}

export interface Warning {
  code: string;
  place: string;
  problem: string;
  remedy: string;
  names?: string[];
  /** Elements of the input cage. Edges are pairs of points. */
  elements: { points?: number[]; edges?: [number, number][]; faces?: number[] };
  amount?: number;
}

/** Figures and warnings of a product; follows its mesh. */
export interface ProductMessage {
  type: "product";
  role: "sim" | "render";
  revision: number;
  /** As in the JSON report of `build`. */
  figures: Record<string, unknown>;
  warnings: Warning[];
  /** Operators in the order in which they ran, as `seam.placket`. Of the render mesh only. */
  operators: string[];
  /** Lengths and levels that replace 0, by key: of the simulation mesh, or of the render mesh. */
  lengths: Record<string, number>;
}

/** Work that has begun (step) or ended (null). */
export interface ProgressMessage {
  type: "progress";
  role: Role;
  step: string | null;
}

/** Answer to `plan` and `save`. */
export interface SaveMessage {
  type: "save";
  path: string;
  /** `planned`: what would be written. `saved`: it is written. */
  status: "planned" | "saved" | "refused";
  /** True if the file exists, so that saving needs `overwrite`. */
  exists: boolean;
  /** The opinions, as USD text or JSON. */
  text: string;
  /** Words on what happens to the rest of an existing file; empty for a new one. */
  note: string;
  fault: Fault | null;
}

export type ServerMessage =
  | GarmentMessage
  | StateMessage
  | FaultsMessage
  | ProductMessage
  | ProgressMessage
  | SaveMessage;

export type PageMessage =
  /** Replaces the edits. Edits with the same gesture, such as one drag, are one step of undo. */
  | { type: "edit"; serial: number; gesture: string; edits: Options }
  | { type: "undo" }
  | { type: "redo" }
  /** Shows the state before the last step, or as it was last saved or else opened; null ends it. */
  | { type: "compare"; with: "step" | "saved" | null }
  /** Reads the files again. They are followed, but some network file systems do not tell of changes. */
  | { type: "reload" }
  | { type: "variant"; prim: string; set: string; choice: string }
  /** What this page draws. The server sends nothing else. */
  | { type: "view"; roles: Role[]; smooth: number; uv: boolean; values: string | null }
  | { type: "plan"; path: string }
  | { type: "save"; path: string; overwrite: boolean };

/** Header of a binary frame. Blocks that are absent are as in the last frame of the role. */
export interface MeshHeader {
  type: "mesh";
  role: Role;
  revision: number;
  /** True if faces are new: then all blocks are there that the view needs. */
  replaces: boolean;
  leftHanded: boolean;
  /** Sets of the mesh as it is drawn. The edge set `UV seams` of the model and the render mesh is none of the garment's
   *  sets: it shows where the UV set is cut. Offset and length count numbers in the block `elements`; edges are pairs. */
  sets?: { name: string; kind: "face" | "edge" | "point"; family: string; offset: number; length: number }[];
  /** The range of the block `values`, and whether a value belongs to a point, a corner or a face. */
  values?: { name: string; of: "point" | "corner" | "face"; least: number; most: number } | null;
  /** Times of the server, and `sent` as milliseconds since 1970. [ms] */
  times: { build: number; encode: number; sent: number };
  blocks: Partial<Record<BlockName, { type: "f32" | "u32" | "u8"; offset: number; length: number }>>;
}

export type BlockName =
  /** x, y, z of each point. */
  | "points"
  /** Corners of each face, and the point of each corner. */
  | "faceCounts"
  | "facePoints"
  /** For each corner 1 if the edge from it to the next corner is an edge of the mesh, 0 if refinement for display made
   *  it. Absent if all are edges. */
  | "edges"
  /** The mesh's face of each drawn face. Absent if they are the same. */
  | "faceOf"
  /** Faces that are not drawn. */
  | "holes"
  /** u, v of each corner. Length 0 if the mesh has no UV set. */
  | "uvs"
  | "values"
  /** Faces, points, or pairs of points of all sets. */
  | "elements";

/** A decoded binary frame. */
export interface MeshFrame {
  header: MeshHeader;
  f32(name: BlockName): Float32Array | undefined;
  u32(name: BlockName): Uint32Array | undefined;
  u8(name: BlockName): Uint8Array | undefined;
  /** When the frame arrived. [ms since 1970] */
  received: number;
}
