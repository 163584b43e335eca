// A slider as wide as there is room.

import type { CSSProperties, TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useRef } from "preact/hooks";
import type { Described } from "./controls";
import { arrowOf, snapped } from "./numbers";
import { drags, follow, ownMouse } from "./pointer";

export interface Range {
  least: number;
  most: number;
  step: number;
  /** Step of a drag with Shift. */
  fine: number;
}

interface SliderProps extends Described {
  value: number;
  range: Range;
  /** A length that 0 stands for, shown as a tick. */
  ghost?: number | null;
  change(value: number): void;
}

/** As in the style. [pixels] */
const THUMB = 12;

export function Slider({ label, describedBy, invalid, value, range, ghost, change }: SliderProps) {
  const { least, most, step } = range;
  const latest = useRef(change);
  latest.current = change;
  const within = (at: number) => Math.min(most, Math.max(least, at));
  const share = (at: number) => (within(at) - least) / (most - least);
  const origin = share(0);
  const fill = [origin, share(value)].sort((a, b) => a - b);
  const style = { "--from": fill[0], "--to": fill[1], "--origin": origin, "--ghost": share(ghost ?? 0) };
  const keys = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    const direction = arrowOf(event.key);
    if (direction === 0 || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    change(snapped(within(value + (event.shiftKey ? 10 : 1) * step * direction), step));
  };
  const press = (event: TargetedPointerEvent<HTMLInputElement>) => {
    if (!drags(event)) return;
    const { left, width } = event.currentTarget.getBoundingClientRect();
    const perPixel = (most - least) / (width - THUMB);
    const pressed = least + (event.clientX - left - THUMB / 2) * perPixel;
    const isOnThumb = Math.abs(pressed - within(value)) < THUMB * 0.7 * perPixel;
    let at = within(isOnThumb || event.shiftKey ? value : pressed);
    event.currentTarget.focus({ preventScroll: true });
    if (!isOnThumb && !event.shiftKey) change(snapped(at, step));
    follow(event, (way, isFine) => {
      if (way === 0) return;
      at = within(at + way * perPixel);
      latest.current(snapped(at, isFine ? range.fine : step));
    });
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
        title="Drag; with Shift for a tenth of the way"
        min={least}
        max={most}
        step="any"
        data-step={step}
        value={value}
        onInput={({ currentTarget }) => change(snapped(currentTarget.valueAsNumber, step))}
        onKeyDown={keys}
        onPointerDown={press}
        onMouseDown={ownMouse}
      />
    </span>
  );
}
