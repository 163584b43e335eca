// Controls that know nothing of the recipe.

import type { ComponentChildren } from "preact";
import { useId, useRef } from "preact/hooks";
import { Icon, type IconName } from "./icons";

export interface Described {
  id?: string;
  label: string;
  describedBy?: string;
  invalid?: boolean;
}

interface SwitchProps extends Described {
  on: boolean;
  /** Whether several values stand behind it, which differ. */
  mixed?: boolean;
  change(on: boolean): void;
}

export function Switch({ label, describedBy, invalid, on, mixed, change }: SwitchProps) {
  return (
    <input
      type="checkbox"
      role="switch"
      class="switch"
      aria-label={label}
      aria-describedby={describedBy}
      aria-invalid={invalid}
      checked={on}
      indeterminate={mixed}
      onChange={({ currentTarget }) => change(currentTarget.checked)}
    />
  );
}

interface SegmentsProps<T extends string | number> extends Described {
  value: T;
  mixed?: boolean;
  choices: { value: T; label: string; icon?: IconName; hint?: string }[];
  change(value: T): void;
}

/** One of a few. A choice with an icon shows its label as a tooltip. */
export function Segments<T extends string | number>({ label, describedBy, value, mixed, choices, change }: SegmentsProps<T>) {
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
            checked={!mixed && choice.value === value}
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
    choices.map((choice) => <option key={choice.value} value={choice.value}>{choice.label}</option>);
  const byHand = useRef(false);
  return (
    <span class="select">
      <select
        aria-label={label}
        aria-describedby={describedBy}
        aria-invalid={invalid}
        value={value}
        onPointerDown={() => (byHand.current = true)}
        onKeyDown={() => (byHand.current = false)}
        onChange={({ currentTarget }) => {
          change(currentTarget.value);
          // A list with the focus takes letters as choices, which are keys of the view for a hand that has left it.
          if (byHand.current) currentTarget.blur();
        }}
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

export function Toggle({ on, change, ...button }: ToggleProps) {
  return <IconButton {...button} pressed={on} act={() => change(!on)} />;
}

interface ButtonProps {
  children: ComponentChildren;
  hint?: string;
  disabled?: boolean;
  class?: string;
  act(): void;
}

export function Button({ children, hint, disabled, class: name = "", act }: ButtonProps) {
  return <button type="button" class={`button ${name}`} title={hint} disabled={disabled} onClick={act}>{children}</button>;
}

interface IconButtonProps {
  label: string;
  icon: IconName;
  hint?: string;
  disabled?: boolean;
  class?: string;
  pressed?: boolean;
  act(): void;
}

export function IconButton({ label, icon, hint, disabled, class: name, pressed, act }: IconButtonProps) {
  return (
    <button
      type="button"
      class={`icon-button ${name ?? ""}`}
      aria-label={label}
      aria-pressed={pressed}
      title={hint ?? label}
      disabled={disabled}
      onClick={act}
    >
      <Icon name={icon} />
    </button>
  );
}
