// The garment with the options that the panel shows.

import type { KindName } from "../server/options";
import type { Domain, GarmentMessage, Group, Option, Role, Severity, Warning } from "../server/protocol";

/** A kind of operator. */
export interface Kind {
  name: KindName;
  /** The field that names its sets, and their elements. */
  sets: { field: string; of: string };
  options: Option[];
}

/** A warning with the mesh whose build found it. */
export interface Finding extends Warning {
  role: Role;
}

/** From the worst. */
export const SEVERITIES: Severity[] = ["fault", "quality", "note"];

export function findingsIn(warnings: Warning[], role: Role): Finding[] {
  return warnings.map((warning) => ({ ...warning, role }));
}

export interface Garment extends Omit<GarmentMessage, "warnings"> {
  warnings: Finding[];
  /** Options that a recipe has once, with their full keys. */
  options: Option[];
  /** Options of each fabric. */
  fabric: Option[];
  kinds: Kind[];
}

export function garmentOf(message: GarmentMessage): Garment {
  const once = message.groups.filter(({ hasInstances }) => !hasInstances);
  const options = once.flatMap((group) =>
    group.options.map((option) => ({ ...option, key: `${group.name}.${option.key}` })),
  );
  const fabric = message.groups.find(({ name }) => name === "fabric")?.options ?? [];
  const warnings = findingsIn(message.warnings, "model");
  const kinds = message.groups.filter(({ isOperator }) => isOperator).map(kindOf);
  return { ...message, warnings, options, fabric, kinds };
}

/** The length that 0 stands for, if it does. [mesh units] */
export function automaticLength(domain: Domain, garment: Garment | null): number | null {
  if (domain.type !== "length" || domain.automatic === 0) return null;
  const most = (domain.automaticMost ?? Infinity) / (garment?.metersPerUnit ?? 1);
  return Math.min(domain.automatic * (garment?.meanEdge ?? 1), most);
}

/** The option of each kind of operator that its other lengths are measured by. */
export const MEASURE = { seam: "width", fold: "thickness" } as const;

/** The length that 0 stands for in the measure of a kind. [mesh units] */
export function automaticMeasure({ name, options }: Kind, garment: Garment | null): number {
  const domain = options.find(({ key }) => key === MEASURE[name])?.domain;
  return (domain && automaticLength(domain, garment)) ?? 0;
}

function kindOf({ name, options }: Group): Kind {
  const sets = options.flatMap(({ key, domain }) =>
    domain.type === "sets" && domain.required ? [{ field: key, of: domain.of[0] }] : [],
  );
  return { name: name as KindName, sets: sets[0], options };
}
