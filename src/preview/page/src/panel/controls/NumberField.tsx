// A field for a number that is typed, stepped by keys, or dragged.

import type { TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useRef, useState } from "preact/hooks";
import type { Described } from "./controls";
import { evaluate } from "./expression";
import { arrowOf, shown, snapped } from "./numbers";
import { drags, follow, ownMouse } from "./pointer";

interface NumberProps extends Described {
  value: number;
  /** Whether several numbers stand behind it, which differ. */
  mixed?: boolean;
  unit: string;
  /** The length of a mesh unit, of a length; units may be typed then. */
  metres: number | null;
  step: number;
  /** Step of a drag with Shift. */
  fine: number;
  /** Nearest value that may be typed. */
  clamp(value: number): number;
  /** The number that 0 stands for. */
  auto?: number | null;
  /** That number, shown in place of 0. */
  autoText?: string;
  change(value: number, how: "step" | "continuous"): void;
}

/** Way after which a press is a drag. [pixels] */
const SLACK = 3;
/** Way of one step. [pixels] */
const PIXELS = 2;

/** Takes a number, a sum of numbers, or a length with a unit, on Enter or when it is left. Arrow keys step, by ten with Shift.
 *  A drag to the side changes the number, a click edits it. */
export function NumberField(props: NumberProps) {
  const { label, describedBy, invalid, value, mixed, unit, metres, step, fine, clamp, auto, autoText, change } = props;
  const [draft, setDraft] = useState<string | null>(null);
  const latest = useRef(change);
  latest.current = change;
  const isAuto = auto !== null && auto !== undefined && value === 0 && !mixed;
  const parsed = draft === null ? value : evaluate(draft, metres);
  const commit = () => {
    if (draft !== null && parsed !== null && (mixed || clamp(parsed) !== value)) change(clamp(parsed), "step");
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
  const press = (event: TargetedPointerEvent<HTMLInputElement>) => {
    const field = event.currentTarget;
    if (!drags(event) || field === document.activeElement) return;
    let [at, last, travelled] = [isAuto ? auto : value, value, 0];
    const moved = (way: number, isFine: boolean) => {
      travelled += Math.abs(way);
      at += (way / PIXELS) * step;
      const next = clamp(snapped(at, isFine ? fine : step));
      // Beyond a limit the way back begins at once.
      if (Math.abs(at - next) > 2 * step) at = next;
      if (travelled < SLACK || next === last) return;
      last = next;
      // What is typed elsewhere is taken first.
      (document.activeElement as HTMLElement | null)?.blur();
      latest.current(next, "continuous");
    };
    follow(event, moved, () => travelled < SLACK && field.focus());
  };
  const words = isAuto ? `automatic, ${autoText} ${unit}` : `${shown(value)} ${unit}`;
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
        aria-valuetext={mixed ? `mixed, here ${words}` : words}
        title="Click to type, drag to change; with Shift in fine steps"
        data-clean={draft === null ? "" : undefined}
        placeholder={mixed ? "mixed" : isAuto ? `auto ${autoText}` : undefined}
        value={draft ?? (isAuto || mixed ? "" : shown(value))}
        onInput={({ currentTarget }) => setDraft(currentTarget.value)}
        onFocus={({ currentTarget }) => currentTarget.select()}
        onBlur={commit}
        onKeyDown={keys}
        onPointerDown={press}
        onMouseDown={(event) => event.currentTarget !== document.activeElement && ownMouse(event)}
      />
      {unit && <span class="unit">{unit}</span>}
    </span>
  );
}
