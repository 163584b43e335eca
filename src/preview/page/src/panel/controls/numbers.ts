// Numbers as they are shown and set by sliders.

import type { GarmentMessage } from "../../server/protocol";

/** Values of files are 32-bit, so that more digits are noise. */
export function neat(value: number): number {
  return Number(value.toPrecision(6));
}

export function shown(value: number): string {
  return String(neat(value));
}

/** A length that nobody typed, such as one that was worked out. */
export function rounded(value: number): string {
  return String(Number(value.toPrecision(3)));
}

export function count(value: unknown): string {
  return typeof value === "number" ? value.toLocaleString("en") : "–";
}

export function percent(value: unknown): string {
  return typeof value === "number" ? `${shown(Number((value * 100).toFixed(value < 0.01 ? 2 : 1)))} %` : "–";
}

export function degrees(value: unknown): string {
  return typeof value === "number" ? `${value.toFixed(1)}°` : "–";
}

export function milliseconds(value: number): string {
  return value < 10 ? `${value.toFixed(1)} ms` : `${Math.round(value)} ms`;
}

/** A step of 1, 2 or 5 times a power of ten that divides the range into about 200. */
export function niceStep(range: number): number {
  const raw = range / 200;
  const power = 10 ** Math.floor(Math.log10(raw));
  const factor = [1, 2, 5, 10].find((each) => each * power >= raw * 0.999) ?? 10;
  return Number((factor * power).toPrecision(6));
}

export function snapped(value: number, step: number): number {
  return Number((Math.round(value / step) * step).toPrecision(10));
}

/** A length [m] or an area [m²], in centimetres below one metre. */
export function lengthOrArea(size: number, isArea: boolean): string {
  const power = isArea ? "²" : "";
  return size < 1 ? `${rounded(size * (isArea ? 1e4 : 100))} cm${power}` : `${rounded(size)} m${power}`;
}

const LENGTHS: [number, string][] = [
  [1, "m"],
  [0.01, "cm"],
  [0.001, "mm"],
  [0.1, "dm"],
  [0.0254, "in"],
  [0.3048, "ft"],
];

function lengthUnit(garment: GarmentMessage | null): string {
  const metres = garment?.metersPerUnit ?? 0;
  return LENGTHS.find(([size]) => Math.abs(metres / size - 1) < 1e-3)?.[1] ?? "units";
}

const UNITS: Record<string, string> = {
  degrees: "°",
  factor: "×",
  levels: "levels",
  rounds: "rounds",
  "samples per face": "/ face",
  m: "m",
  "kg/m2": "kg/m²",
  "N/m": "N/m",
  "N m": "N m",
};

/** A short form of an option's unit, which may be empty. */
export function unitOf(unit: string, garment: GarmentMessage | null): string {
  return unit.includes("mesh unit") ? lengthUnit(garment) : (UNITS[unit] ?? "");
}

/** The direction of an arrow key; 0 of other keys. */
export function arrowOf(key: string): number {
  if (key === "ArrowUp" || key === "ArrowRight") return 1;
  return key === "ArrowDown" || key === "ArrowLeft" ? -1 : 0;
}
