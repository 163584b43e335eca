// Pure functions on options: reading and writing. The server merges them and orders the operators.

import type { Fields, InstanceGroup, KindName, Options, Value } from "../server/options";
import type { Fault, Option, PrimvarInfo, Stacked } from "../server/protocol";
import type { Garment, Kind } from "./garment";
import type { Document } from "./state";

/** Named options: an operator or a fabric. */
export interface Instance {
  kind: InstanceGroup;
  name: string;
}

export interface Operator extends Instance {
  kind: KindName;
}

export const ORDER = "render.operators";

export function fullName({ kind, name }: Instance): string {
  return `${kind}.${name}`;
}

interface Place {
  group: keyof Options;
  instance: string | null;
  field: string;
}

function placeOf(key: string): Place {
  const parts = key.split(".");
  const group = parts[0] as keyof Options;
  return parts.length === 3
    ? { group, instance: parts[1], field: parts[2] }
    : { group, instance: null, field: parts[1] };
}

/** Names come from files, so one may be that of a property that every object has, such as `constructor`. */
function own<T>(record: Record<string, T> | undefined, name: string): T | undefined {
  return record && Object.hasOwn(record, name) ? record[name] : undefined;
}

function fieldsAt(options: Options, { group, instance }: Place): Fields | undefined {
  if (instance === null) return options[group] as Fields | undefined;
  return own(options[group] as Record<string, Fields> | undefined, instance);
}

export function valueAt(options: Options, key: string): Value | undefined {
  const place = placeOf(key);
  return own(fieldsAt(options, place), place.field);
}

export function instanceAt(options: Options, { kind, name }: Instance): Fields | undefined {
  return own(options[kind], name);
}

/** The options with other fields of an instance, or without it. */
export function withInstance(options: Options, { kind, name }: Instance, fields: Fields | undefined): Options {
  const instances = { ...options[kind] };
  if (fields) instances[name] = fields;
  else delete instances[name];
  return pruned({ ...options, [kind]: instances });
}

export function withValue(options: Options, key: string, value: Value): Options {
  const place = placeOf(key);
  const fields = { ...fieldsAt(options, place), [place.field]: value };
  return withFields(options, place, fields);
}

/** Without one value. An instance of the edits alone stays, even if it has no field left. */
export function withoutValue(edits: Options, key: string, upstream: Options): Options {
  const place = placeOf(key);
  const fields = { ...fieldsAt(edits, place) };
  delete fields[place.field];
  const keeps = Object.keys(fields).length > 0 || (place.instance !== null && !fieldsAt(upstream, place));
  return withFields(edits, place, keeps ? fields : undefined);
}

function withFields(options: Options, place: Place, fields: Fields | undefined): Options {
  if (place.instance === null) return pruned({ ...options, [place.group]: fields ?? {} });
  return withInstance(options, { kind: place.group as InstanceGroup, name: place.instance }, fields);
}

function pruned(options: Options): Options {
  return Object.fromEntries(Object.entries(options).filter(([, group]) => Object.keys(group).length > 0));
}

export function listOf(options: Options): string[] {
  return (options.render?.operators as string[] | undefined) ?? [];
}

export function setsOf(options: Options, operator: Operator, kinds: Kind[]): string[] {
  const field = kinds.find(({ name }) => name === operator.kind)?.sets.field;
  const names = field ? instanceAt(options, operator)?.[field] : undefined;
  return Array.isArray(names) ? names : [];
}

export function isEnabled(options: Options, operator: Operator): boolean {
  return instanceAt(options, operator)?.enabled !== false;
}

/** A name that no instance of the kind has yet. */
export function uniqueName(options: Options, kind: InstanceGroup, wish: string): string {
  const base = wish.replace(/[^A-Za-z0-9_:]/g, "_").replace(/^(?![A-Za-z_])/, "_");
  const taken = (name: string) => instanceAt(options, { kind, name }) !== undefined;
  let name = base;
  for (let n = 2; taken(name); n++) name = `${base}_${n}`;
  return name;
}

/** Says what is wrong with a name, or null. */
export function nameProblem(options: Options, instance: Instance, name: string): string | null {
  if (!/^[A-Za-z_][A-Za-z0-9_]*(:[A-Za-z_][A-Za-z0-9_]*)*$/.test(name)) {
    return "letters, digits and _ only, and no digit first";
  }
  const taken = name !== instance.name && instanceAt(options, { kind: instance.kind, name }) !== undefined;
  return taken ? `there is a ${instance.kind} "${name}" already` : null;
}

/** The property that 0 stands for in an option of a fabric, such as `fabric.lining.thickness`; null of other options. */
export function fabricValue(merged: Options, garment: Garment | null, key: string): number | null {
  const { group, instance, field } = placeOf(key);
  if (group !== "fabric" || instance === null || !garment) return null;
  const preset = own(merged.fabric, instance)?.preset ?? "cotton";
  const properties = own(garment.fabrics, String(preset)) as Record<string, number> | undefined;
  return own(properties, field) ?? null;
}

/** Primvars that an option of this kind may name. */
export function fitting(primvars: PrimvarInfo[], of: "uvSet" | "weights"): PrimvarInfo[] {
  return primvars.filter(({ width, interpolation, isFloat }) => {
    if (of === "uvSet") return isFloat && width === 2 && interpolation === "faceVarying";
    return isFloat && width === 1 && (interpolation === "vertex" || interpolation === "varying");
  });
}

/** Faults beside the option or operator that they are about, and those that are about nothing in the panel. */
export interface PlacedFaults {
  at: Map<string, Fault[]>;
  elsewhere: Fault[];
}

export function placeFaults(faults: Fault[], garment: Garment | null, { stack, merged }: Document): PlacedFaults {
  const keys = keysOf(garment, stack, fabricsOf(merged)).sort((a, b) => b.length - a.length);
  const placed: PlacedFaults = { at: new Map(), elsewhere: [] };
  for (const fault of faults) {
    // The longest key that fits is the most exact one.
    const key = keys.find((each) => mentions(fault.place, each));
    if (key) placed.at.set(key, [...(placed.at.get(key) ?? []), fault]);
    else placed.elsewhere.push(fault);
  }
  return placed;
}

/** The fabrics of a recipe, by name. */
export function fabricsOf(options: Options): Instance[] {
  return Object.keys(options.fabric ?? {}).map((name) => ({ kind: "fabric", name }));
}

function keysOf(garment: Garment | null, stack: Stacked[], fabrics: Instance[]): string[] {
  const own = (garment?.options ?? []).map(({ key }) => key).filter((key) => key !== ORDER);
  const ofOperators = stack.flatMap(({ kind, full }) => {
    // The switch is on the card's header, so that its faults are the card's.
    const fields = (garment?.kinds.find(({ name }) => name === kind)?.options ?? []).filter(
      ({ key }) => key !== "enabled",
    );
    return [full, ...fields.map(({ key }) => `${full}.${key}`)];
  });
  const ofFabrics = fabrics.map(fullName).flatMap((full) => [
    full,
    ...(garment?.fabric ?? []).map(({ key }) => `${full}.${key}`),
  ]);
  return [...own, ...ofOperators, ...ofFabrics];
}

function mentions(place: string, key: string): boolean {
  const forms = [key, `tailor:${key.replaceAll(".", ":")}`];
  return forms.some((form) => {
    const at = place.indexOf(form);
    return (
      at >= 0 && !/[A-Za-z0-9_]/.test(place[at - 1] ?? " ") && !/[A-Za-z0-9_]/.test(place[at + form.length] ?? " ")
    );
  });
}

/** `maxEdgeLength` as "Max edge length". */
export function labelOf(option: Option): string {
  const field = option.key.slice(option.key.lastIndexOf(".") + 1);
  const words = field.replace(/([A-Z])/g, (letter) => ` ${letter.toLowerCase()}`).replace(/\buv\b/g, "UV");
  return words[0].toUpperCase() + words.slice(1);
}
