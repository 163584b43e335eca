// Options of recipes as the page holds them.

export type Value = number | boolean | string | string[];

/** Options of one operator: field to value. */
export type Fields = Record<string, Value>;

export type KindName = "seam" | "fold";

/** Groups of options with instances. */
export type InstanceGroup = KindName | "fabric";

/** A sparse recipe, nested as in a `.tailor` file. Only the options that somebody gave are in it. */
export interface Options {
  sim?: Fields;
  render?: Fields;
  seam?: Record<string, Fields>;
  fold?: Record<string, Fields>;
  cloth?: Fields;
  fit?: Fields;
  lod?: Fields;
  fabric?: Record<string, Fields>;
}

/** The axis of a stage that points up. */
export type UpAxis = "Y" | "Z";

/** Presets of each kind of operator, by name. */
export type Presets = Partial<Record<KindName, Record<string, Fields>>>;
