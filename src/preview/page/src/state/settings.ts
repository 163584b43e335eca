// How the garment is shown. Kept in the browser, since it is the artist's taste and no part of the recipe.

import type { GarmentMessage, Role } from "../server/protocol";
import type { Fabric, Layout, Shading, ViewOptions } from "../view/api";
import { ROLES } from "../view/layout";

export interface Settings {
  roles: Role[];
  layout: Layout;
  /** The mesh that is large in the layout of that name. */
  large: Role;
  shading: Shading;
  fabric: Fabric;
  /** What heat shows: a primvar, `quality:angle` or `quality:length`. */
  values: string | null;
  wires: boolean;
  edgeSets: boolean;
  flat: boolean;
  shadows: boolean;
  /** The body under the garment. */
  body: boolean;
  /** Both sides of a symmetric garment are selected and edited at once. */
  symmetric: boolean;
  /** Refinements for display. */
  smooth: number;
  theme: "light" | "dark";
  /** Whether the strip with the figures is open. */
  figures: boolean;
  /** The steps to a first seam are hidden. */
  knowsSteps: boolean;
}

export const ROLE_NAMES: Record<Role, string> = { model: "Model", sim: "Simulation", render: "Render", body: "Body" };

const KEY = "usdtailor.preview";

const DEFAULTS: Settings = {
  roles: ROLES,
  layout: "large",
  large: "render",
  shading: "cloth",
  fabric: { colour: null, roughness: null, weave: "none" },
  values: null,
  wires: true,
  edgeSets: false,
  flat: false,
  shadows: true,
  body: true,
  symmetric: true,
  smooth: 0,
  theme: "light",
  figures: false,
  knowsSteps: false,
};

export function loadSettings(): Settings {
  const theme = prefersDark().matches ? "dark" : "light";
  const stored = read();
  return { ...DEFAULTS, theme, ...stored, roles: stored.roles?.length ? stored.roles : ROLES };
}

/** Follows the system's theme until one is chosen here. */
export function onSystemTheme(act: (theme: "light" | "dark") => void): void {
  prefersDark().addEventListener("change", ({ matches }) => {
    if (!read().theme) act(matches ? "dark" : "light");
  });
}

export function saveSettings(changed: Partial<Settings>): void {
  try {
    localStorage.setItem(KEY, JSON.stringify({ ...read(), ...changed }));
  } catch {
    // Private windows refuse storage, and images may not fit; the choice then lasts as long as the page.
  }
}

function read(): Partial<Settings> {
  try {
    const stored: unknown = JSON.parse(localStorage.getItem(KEY) ?? "{}");
    return typeof stored === "object" && stored !== null ? (stored as Partial<Settings>) : {};
  } catch {
    return {};
  }
}

function prefersDark(): MediaQueryList {
  return matchMedia("(prefers-color-scheme: dark)");
}

export function viewOptions(settings: Settings): ViewOptions {
  const { roles, layout, large, shading, fabric, wires, edgeSets, flat, shadows, body, theme } = settings;
  return { roles, layout, large, shading, fabric, wires, edgeSets, flat, shadows, body, theme };
}

export interface HeatChoice {
  name: string;
  label: string;
  unit: string;
}

export const QUALITIES: HeatChoice[] = [
  { name: "quality:angle", label: "Smallest angle", unit: "°" },
  { name: "quality:length", label: "Length against target", unit: "×" },
];

export function paintedChoices(garment: GarmentMessage | null): HeatChoice[] {
  const painted = (garment?.primvars ?? []).filter((each) => each.width === 1 && each.interpolation !== "constant");
  // Floats are what artists paint; integers mostly number things.
  const sorted = [...painted.filter(({ isFloat }) => isFloat), ...painted.filter(({ isFloat }) => !isFloat)];
  return sorted.map(({ name }) => ({ name, label: name, unit: "" }));
}
