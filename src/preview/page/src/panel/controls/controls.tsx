// Controls that know nothing of the recipe.

import type { CSSProperties, TargetedKeyboardEvent } from "preact";
import { useId, useState } from "preact/hooks";
import { evaluate } from "./expression";
import { Icon, type IconName } from "./icons";
import { shown, snapped } from "./numbers";

interface Described {
  id?: string;
  label: string;
  describedBy?: string;
  invalid?: boolean;
}

export interface Range {
  least: number;
  most: number;
  step: number;
}

interface SliderProps extends Described {
  value: number;
  range: Range;
  /** A length that 0 stands for, shown as a tick. */
  ghost?: number | null;
  change(value: number): void;
}

export function Slider({ label, describedBy, invalid, value, range, ghost, change }: SliderProps) {
  const { least, most, step } = range;
  const share = (at: number) => Math.min(1, Math.max(0, (at - least) / (most - least)));
  const origin = share(Math.max(least, Math.min(0, most)));
  const fill = [origin, share(value)].sort((a, b) => a - b);
  const style = { "--from": fill[0], "--to": fill[1], "--origin": origin, "--ghost": share(ghost ?? 0) };
  const keys = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    const direction = arrowOf(event.key);
    if (!event.shiftKey || direction === 0) return;
    event.preventDefault();
    change(snapped(Math.min(most, Math.max(least, value + 10 * step * direction)), step));
  };
  return (
    <span class="slider" style={style as CSSProperties}>
      {least < 0 && <i class="slider-origin" />}
      {ghost ? <i class="slider-ghost" /> : null}
      <input
        type="range"
        aria-label={label}
        aria-describedby={describedBy}
        aria-invalid={invalid}
        min={least}
        max={most}
        step={step}
        value={value}
        onInput={({ currentTarget }) => change(snapped(currentTarget.valueAsNumber, step))}
        onKeyDown={keys}
      />
    </span>
  );
}

function arrowOf(key: string): number {
  if (key === "ArrowUp" || key === "ArrowRight") return 1;
  return key === "ArrowDown" || key === "ArrowLeft" ? -1 : 0;
}

interface NumberProps extends Described {
  value: number;
  unit: string;
  /** The length of a mesh unit, of a length; units may be typed then. */
  metres: number | null;
  step: number;
  /** Nearest value that may be typed. */
  clamp(value: number): number;
  /** Shown in place of 0. */
  auto?: string | null;
  change(value: number, how: "step" | "continuous"): void;
}

/** A field that takes a number, a sum of numbers, or a length with a unit, on Enter or when it is left. Arrow keys step, by ten with shift. */
export function NumberField(props: NumberProps) {
  const { label, describedBy, invalid, value, unit, metres, step, clamp, auto, change } = props;
  const [draft, setDraft] = useState<string | null>(null);
  const isAuto = auto !== null && auto !== undefined && value === 0;
  const parsed = draft === null ? value : evaluate(draft, metres);
  const commit = () => {
    if (draft !== null && parsed !== null && clamp(parsed) !== value) change(clamp(parsed), "step");
    setDraft(null);
  };
  const keys = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    if (event.key === "Enter") {
      commit();
      // The keys of the view would else go into the field.
      event.currentTarget.blur();
    }
    if (event.key === "Escape" && draft !== null) {
      event.stopPropagation();
      setDraft(null);
    }
    if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
    event.preventDefault();
    const by = arrowOf(event.key) * step * (event.shiftKey ? 10 : 1);
    setDraft(null);
    change(clamp(snapped((parsed ?? value) + by, step)), "continuous");
  };
  return (
    <span class={`number ${isAuto ? "is-auto" : ""}`}>
      <input
        type="text"
        inputMode="decimal"
        role="spinbutton"
        autocomplete="off"
        spellcheck={false}
        aria-label={`${label}, number`}
        aria-describedby={describedBy}
        aria-invalid={invalid || parsed === null}
        aria-valuenow={value}
        aria-valuetext={isAuto ? `automatic, ${auto} ${unit}` : `${shown(value)} ${unit}`}
        data-clean={draft === null ? "" : undefined}
        placeholder={isAuto ? `auto ${auto}` : undefined}
        value={draft ?? (isAuto ? "" : shown(value))}
        onInput={({ currentTarget }) => setDraft(currentTarget.value)}
        onFocus={({ currentTarget }) => currentTarget.select()}
        onBlur={commit}
        onKeyDown={keys}
      />
      {unit && <span class="unit">{unit}</span>}
    </span>
  );
}

interface SwitchProps extends Described {
  on: boolean;
  change(on: boolean): void;
}

export function Switch({ label, describedBy, invalid, on, change }: SwitchProps) {
  return (
    <input
      type="checkbox"
      role="switch"
      class="switch"
      aria-label={label}
      aria-describedby={describedBy}
      aria-invalid={invalid}
      checked={on}
      onChange={({ currentTarget }) => change(currentTarget.checked)}
    />
  );
}

interface SegmentsProps<T extends string | number> extends Described {
  value: T;
  choices: { value: T; label: string; icon?: IconName; hint?: string }[];
  change(value: T): void;
}

/** One of a few. A choice with an icon shows its label as a tooltip. */
export function Segments<T extends string | number>({ label, describedBy, value, choices, change }: SegmentsProps<T>) {
  // Cards have options of the same name, and radio buttons of one name are one group.
  const group = useId();
  return (
    <span class="segments" role="radiogroup" aria-label={label} aria-describedby={describedBy}>
      {choices.map((choice) => (
        <label key={choice.value} title={choice.hint ?? (choice.icon ? choice.label : undefined)}>
          <input
            type="radio"
            name={group}
            aria-label={choice.label}
            checked={choice.value === value}
            onChange={() => change(choice.value)}
          />
          <span>{choice.icon ? <Icon name={choice.icon} /> : choice.label}</span>
        </label>
      ))}
    </span>
  );
}

interface SelectProps extends Described {
  value: string;
  groups: { label?: string; choices: { value: string; label: string }[] }[];
  change(value: string): void;
}

export function Select({ label, describedBy, invalid, value, groups, change }: SelectProps) {
  const options = (choices: SelectProps["groups"][number]["choices"]) =>
    choices.map((choice) => (
      <option key={choice.value} value={choice.value}>
        {choice.label}
      </option>
    ));
  return (
    <span class="select">
      <select
        aria-label={label}
        aria-describedby={describedBy}
        aria-invalid={invalid}
        value={value}
        onChange={({ currentTarget }) => change(currentTarget.value)}
      >
        {groups.map(({ label, choices }) =>
          label ? <optgroup label={label}>{options(choices)}</optgroup> : options(choices),
        )}
      </select>
      <Icon name="down" />
    </span>
  );
}

interface ToggleProps {
  label: string;
  icon: IconName;
  on: boolean;
  hint?: string;
  change(on: boolean): void;
}

export function Toggle({ label, icon, on, hint, change }: ToggleProps) {
  return (
    <button
      type="button"
      class="icon-button"
      aria-label={label}
      aria-pressed={on}
      title={hint ?? label}
      onClick={() => change(!on)}
    >
      <Icon name={icon} />
    </button>
  );
}

interface IconButtonProps {
  label: string;
  icon: IconName;
  hint?: string;
  disabled?: boolean;
  class?: string;
  act(): void;
}

export function IconButton({ label, icon, hint, disabled, class: name, act }: IconButtonProps) {
  return (
    <button
      type="button"
      class={`icon-button ${name ?? ""}`}
      aria-label={label}
      title={hint ?? label}
      disabled={disabled}
      onClick={act}
    >
      <Icon name={icon} />
    </button>
  );
}
