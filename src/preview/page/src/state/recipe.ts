// Pure functions on options: reading and writing. The server merges them and orders the operators.

import type { Fields, KindName, Options, Value } from "../server/options";
import type { Fault, Option, PrimvarInfo, Stacked } from "../server/protocol";
import type { Garment, Kind } from "./garment";

export interface Operator {
  kind: KindName;
  name: string;
}

export const ORDER = "render.operators";

export function fullName({ kind, name }: Operator): string {
  return `${kind}.${name}`;
}

interface Place {
  group: keyof Options;
  operator: string | null;
  field: string;
}

function placeOf(key: string): Place {
  const parts = key.split(".");
  const group = parts[0] as keyof Options;
  return parts.length === 3
    ? { group, operator: parts[1], field: parts[2] }
    : { group, operator: null, field: parts[1] };
}

/** Names come from files, so one may be that of a property that every object has, such as `constructor`. */
function own<T>(record: Record<string, T> | undefined, name: string): T | undefined {
  return record && Object.hasOwn(record, name) ? record[name] : undefined;
}

function fieldsAt(options: Options, { group, operator }: Place): Fields | undefined {
  if (operator === null) return options[group] as Fields | undefined;
  return own(options[group] as Record<string, Fields> | undefined, operator);
}

export function valueAt(options: Options, key: string): Value | undefined {
  const place = placeOf(key);
  return own(fieldsAt(options, place), place.field);
}

export function operatorAt(options: Options, { kind, name }: Operator): Fields | undefined {
  return own(options[kind], name);
}

/** The options with other fields of an operator, or without it. */
export function withOperator(options: Options, { kind, name }: Operator, fields: Fields | undefined): Options {
  const operators = { ...options[kind] };
  if (fields) operators[name] = fields;
  else delete operators[name];
  return pruned({ ...options, [kind]: operators });
}

export function withValue(options: Options, key: string, value: Value): Options {
  const place = placeOf(key);
  const fields = { ...fieldsAt(options, place), [place.field]: value };
  return withFields(options, place, fields);
}

/** Without one value. An operator of the edits alone stays, even if it has no field left. */
export function withoutValue(edits: Options, key: string, upstream: Options): Options {
  const place = placeOf(key);
  const fields = { ...fieldsAt(edits, place) };
  delete fields[place.field];
  const keeps = Object.keys(fields).length > 0 || (place.operator !== null && !fieldsAt(upstream, place));
  return withFields(edits, place, keeps ? fields : undefined);
}

function withFields(options: Options, place: Place, fields: Fields | undefined): Options {
  if (place.operator === null) return pruned({ ...options, [place.group]: fields ?? {} });
  return withOperator(options, { kind: place.group as KindName, name: place.operator }, fields);
}

function pruned(options: Options): Options {
  return Object.fromEntries(Object.entries(options).filter(([, group]) => Object.keys(group).length > 0));
}

export function listOf(options: Options): string[] {
  return (options.render?.operators as string[] | undefined) ?? [];
}

export function setsOf(options: Options, operator: Operator, kinds: Kind[]): string[] {
  const field = kinds.find(({ name }) => name === operator.kind)?.sets.field;
  const names = field ? operatorAt(options, operator)?.[field] : undefined;
  return Array.isArray(names) ? names : [];
}

export function isEnabled(options: Options, operator: Operator): boolean {
  return operatorAt(options, operator)?.enabled !== false;
}

/** A name that no operator of the kind has yet. */
export function uniqueName(options: Options, kind: KindName, wish: string): string {
  const base = wish.replace(/[^A-Za-z0-9_:]/g, "_").replace(/^(?![A-Za-z_])/, "_");
  const taken = (name: string) => operatorAt(options, { kind, name }) !== undefined;
  let name = base;
  for (let n = 2; taken(name); n++) name = `${base}_${n}`;
  return name;
}

/** Says what is wrong with a name, or null. */
export function nameProblem(options: Options, operator: Operator, name: string): string | null {
  if (!/^[A-Za-z_][A-Za-z0-9_]*(:[A-Za-z_][A-Za-z0-9_]*)*$/.test(name)) {
    return "letters, digits and _ only, and no digit first";
  }
  const taken = name !== operator.name && operatorAt(options, { kind: operator.kind, name }) !== undefined;
  return taken ? `there is a ${operator.kind} "${name}" already` : null;
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

export function placeFaults(faults: Fault[], garment: Garment | null, stack: Stacked[]): PlacedFaults {
  const keys = keysOf(garment, stack).sort((a, b) => b.length - a.length);
  const placed: PlacedFaults = { at: new Map(), elsewhere: [] };
  for (const fault of faults) {
    // The longest key that fits is the most exact one.
    const key = keys.find((each) => mentions(fault.place, each));
    if (key) placed.at.set(key, [...(placed.at.get(key) ?? []), fault]);
    else placed.elsewhere.push(fault);
  }
  return placed;
}

function keysOf(garment: Garment | null, stack: Stacked[]): string[] {
  const own = (garment?.options ?? []).map(({ key }) => key).filter((key) => key !== ORDER);
  const ofOperators = stack.flatMap(({ kind, full }) => {
    // The switch is on the card's header, so that its faults are the card's.
    const fields = (garment?.kinds.find(({ name }) => name === kind)?.options ?? []).filter(
      ({ key }) => key !== "enabled",
    );
    return [full, ...fields.map(({ key }) => `${full}.${key}`)];
  });
  return [...own, ...ofOperators];
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
