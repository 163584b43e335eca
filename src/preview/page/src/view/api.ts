// The interface of the view. `view/index.ts` implements it.

import type { MeshFrame } from "../server/frame";
import type { Column } from "./layout";
import type { UpAxis } from "../server/options";
import type { Elements, GarmentMessage, Role, SetInfo } from "../server/protocol";

/** A side from which the garment is seen. */
export type Side = "front" | "side" | "back" | "top" | "three-quarter";
/** One mesh large and the others small beside it; all in columns beside one another; all in one place. */
export type Layout = "large" | "side" | "over";
/** The colour of faces. `values` is a painted primvar or a quality figure, as heat. */
export type Shading = "cloth" | "faceSets" | "checker" | "values";

export type Weave = "none" | "plain" | "twill" | "knit";

/** What cloth is made of. */
export interface Fabric {
  /** As `#rrggbb`; null is the model's own. */
  colour: string | null;
  /** In place of the colour, as a data URL. */
  image?: string | null;
  /** A normal map in place of the weave, as a data URL. */
  relief?: string | null;
  /** Edge of both images on the cloth. [m] */
  size?: number;
  /** From 0 to 1; null is the model's own. */
  roughness: number | null;
  weave: Weave;
}

export interface ViewOptions {
  /** Meshes that are drawn, in this order. */
  roles: Role[];
  layout: Layout;
  /** The mesh that is large, if it is drawn. */
  large: Role;
  shading: Shading;
  fabric: Fabric;
  /** Edges of the mesh. */
  wires: boolean;
  /** Edge sets and seams, each in its colour. */
  edgeSets: boolean;
  /** The UV panels, flat: in place of the meshes in space, or with the large one beside them. */
  flat: boolean;
  /** Layers shade one another in the picture at rest. */
  shadows: boolean;
  /** The body under the garment, where meshes are in space. */
  body: boolean;
  theme: "light" | "dark";
}

/** A set by name. */
export type PickedSet = Pick<SetInfo, "name" | "kind">;

/** Elements of the model that are marked on one of the meshes. */
export interface Marked {
  role: Role;
  elements: Elements;
  /** Whether they cross a body. */
  isCrossing?: boolean;
}

/** What may be shown alone: the panel of a face of the model, faces, panels that touch other elements, a face set. */
export type Isolated = Pick<Picked, "face"> | Elements | string;

/** What is under the pointer, on any mesh. */
export interface Picked {
  role: Role;
  /** The face of the model that is drawn there. */
  face: number;
  /** The nearest edge of the model as a pair of points, if the pointer is within a few pixels of it. */
  edge: [number, number] | null;
  /** Sets of the edge of the mesh that is there, then sets of the face. */
  sets: PickedSet[];
  /** Place on the canvas. [CSS pixels] */
  x: number;
  y: number;
}

/** What a click takes, as a path of SVG in a column. [CSS pixels] */
export interface Outline extends Pick<Column, "x" | "y" | "width" | "height"> {
  path: string;
}

/** [CSS pixels] */
export type Vector = [number, number];

/** A place of an operator on the render mesh for its handles, as the camera sees it. [CSS pixels] */
export interface Grip {
  x: number;
  y: number;
  /** The way of one mesh unit to the left of the edges; null of faces. */
  left: Vector | null;
  /** 1 where all cloth is on the left, -1 where it is on the right, 0 where it is on both sides. */
  cloth: -1 | 0 | 1;
  /** The way of one mesh unit along the normal. */
  normal: Vector;
  /** One mesh unit across the line of sight. */
  unit: number;
}

/** What a click does with the selection. `path` adds the shortest path from the last pick. */
export type PickHow = "replace" | "add" | "remove" | "path";

/** Paints on the points of the model. */
export interface Brush {
  /** Of each point, from 0 to 1. Strokes change them. */
  weights: Float32Array<ArrayBuffer>;
  /** [mesh units] */
  radius: number;
  /** Share of the way to the wanted weight at the middle of a dab. */
  strength: number;
  /** The point on the other side of each point, which is painted too; null for one side. */
  mirror: number[] | null;
}

export interface ViewEvents {
  /** The pointer rests on something else than before, or it is drawn elsewhere; null is nothing. */
  hover(picked: Picked | null, outlines: Outline[]): void;
  /** A click that is not a drag. */
  click(picked: Picked | null, how: PickHow): void;
  /** The flat panels were drawn elsewhere, or the meshes are in space again. */
  plan(plan: Plan): void;
  /** The grip is seen elsewhere, or is no longer. */
  grip(grip: Grip | null): void;
  /** A stroke of the brush has ended. */
  painted(weights: Float32Array): void;
  /** Whether the picture is the last one, or a better one comes. */
  final(isFinal: boolean): void;
  /** A frame was drawn with new buffers: their role and revision, and the time to make and upload them. [ms] */
  drawn(role: Role, revision: number, upload: number): void;
}

/** A part of the canvas. [CSS pixels] */
export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** The flat panels of a mesh in its column. [CSS pixels] */
export interface PlanColumn extends Box {
  /** The panels with their boxes. */
  panels: ({ name: string } & Box)[];
  /** One mesh unit on the surface, or 0 if the scale of the UVs is not known. */
  unit: number;
}

/** All columns with flat panels; empty in space. */
export type Plan = PlanColumn[];

/** Numbers for tests and for the figures panel. */
export interface ViewStats {
  points: number;
  faces: number;
  /** Sum of all coordinates, which changes when points move. */
  checksum: number;
  /** Its lower corner. [mesh units] */
  least: number[];
}

export interface View {
  /** Whether a body is drawn where meshes are in space. */
  hasBody(): boolean;
  /** Replaces or updates a mesh. The camera frames the first one. */
  update(frame: MeshFrame): void;
  /** Forgets a mesh that is no longer sent. */
  remove(role: Role): void;
  setOptions(options: ViewOptions): void;
  /** Up axis of the stage; the camera stands upright on it. */
  setUp(axis: UpAxis): void;
  /** Looks of the model's materials, its sets, which get their colours, its number of points, and metres in one of its units. */
  setGarment(garment: Pick<GarmentMessage, "looks" | "sets" | "points" | "metersPerUnit">): void;
  /** Moves the camera so that the marked or highlighted elements, or else everything, fill the view. */
  frame(): void;
  /** Moves the camera to a side of the garment, with all of it in view; flat panels have one side. */
  look(side: Side): void;
  /** Highlights sets by name on all meshes; an empty list ends it. */
  highlight(sets: string[]): void;
  /** Marks elements of the model on a mesh, visible through cloth, and flies there once it is drawn; null ends it. */
  mark(marked: Marked | null, flies?: boolean): void;
  /** Number of connected places of what is marked. */
  placeCount(): number;
  /** Flies to one of them. */
  flyToPlace(at: number): void;
  /** Draws selected elements of the model on all meshes, faint behind cloth; null ends it. */
  select(elements: Elements | null): void;
  /** Finds a place on the render mesh at elements of the model that is seen, for handles there; null ends it. */
  grip(elements: Elements | null): void;
  /** Paints with the pointer, and shows the weights as heat on the model; null ends it. */
  brush(brush: Brush | null): void;
  /** The values of a primvar that the model shows as heat; null if it shows another one. */
  weightsOf(name: string): Float32Array<ArrayBuffer> | null;
  /** The weights that the engine gives a set, for its elements. */
  blended(elements: Elements | null): Float32Array<ArrayBuffer> | null;
  /** Flies to elements of the model, or to one of its sets, if they are out of view or on the far side. */
  reveal(what: Elements | string): void;
  /** Hides all but this in all meshes, or shows all for null. Returns whether something is hidden. */
  isolate(what: Isolated | null): boolean;
  /** Splits each column at a part of its breadth: on the left the meshes as they are when the split begins, on the right
   *  as they become. Null ends it. */
  split(share: number | null): void;
  /** The colour of a set, as CSS, so that the panel shows the same. */
  colourOf(set: string): string;
  /** Edge sets with a line on the meshes that are shown, sorted by name. */
  edgeSets(): string[];
  /** The picture at rest as PNG at the device's resolution. */
  screenshot(): Promise<Blob>;
  /** The view as PNG of a size in pixels, without the ground and what is behind it. */
  clearPicture(width: number, height: number): Promise<Blob>;
  /** The garment as it turns once about itself, as WebM. The camera is back where it was then. */
  turntable(seconds: number): Promise<Blob>;
  /** Edge of a square of the checker, or 0 if the scale of the UVs is not known. [m] */
  square(): number;
  /** How many values of the mesh that heat is of are in each of equal parts of its scale; null without values. */
  histogram(parts: number): number[] | null;
  /** Flies to the face with the worst quality that heat shows. Returns whether a mesh on view has one. */
  flyToWorst(): boolean;
  stats(role: Role): ViewStats | null;
  /** Samples in the picture on the canvas: 0 while anything changes. */
  samples(): number;
  /** Where the camera is bound: the target in space, the direction that it looks along, and the distance. For tests. */
  aim(): { target: number[]; direction: number[]; distance: number };
  /** Place of a point of a mesh on the canvas, or null if it is not drawn or off the canvas; on its flat panels, or in
   *  space beside them. For tests. [CSS pixels] */
  project(role: Role, point: number, flat?: boolean): { x: number; y: number } | null;
}
