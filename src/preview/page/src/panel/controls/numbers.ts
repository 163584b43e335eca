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

/** The unit in which lengths are shown. */
export interface LengthUnit {
  word: string;
  metres: number;
  /** Mesh units in one of it. */
  size: number;
}

/** Millimetres for a garment that is in them, else centimetres. */
export function lengthUnit(garment: GarmentMessage | null): LengthUnit {
  const own = garment?.metersPerUnit || 0.01;
  const is = (metres: number) => Math.abs(own / metres - 1) < 1e-3;
  const unit = is(0.001) ? { word: "mm", metres: 0.001 } : { word: "cm", metres: 0.01 };
  return { ...unit, size: is(unit.metres) ? 1 : unit.metres / own };
}

/** A length of mesh units in a unit, without the noise of 32 bits. */
export function inUnit(length: number, { size }: LengthUnit): number {
  return size === 1 ? length : neat(length / size);
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
  return unit.includes("mesh unit") ? lengthUnit(garment).word : (UNITS[unit] ?? "");
}

/** The direction of an arrow key; 0 of other keys. */
export function arrowOf(key: string): number {
  if (key === "ArrowUp" || key === "ArrowRight") return 1;
  return key === "ArrowDown" || key === "ArrowLeft" ? -1 : 0;
}
