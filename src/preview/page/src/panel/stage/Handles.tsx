// Handles of the seam or the fold whose card is open, on the render mesh: width, height, and the side. The card has the same
// options for keys and screen readers.

import type { TargetedPointerEvent } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { Fields } from "../../server/options";
import type { Option, Stacked } from "../../server/protocol";
import { keysWith } from "../../state/cards";
import { instanceAt, isEnabled, labelOf, setsOf } from "../../state/recipe";
import type { State } from "../../state/state";
import type { Store } from "../../state/store";
import type { Grip, Vector } from "../../view/api";
import { useLive, useSelect, useStore } from "../controls/hooks";
import { shown, snapped } from "../controls/numbers";
import { follow } from "../controls/pointer";
import { clamped, numberOption, setNumber } from "../recipe/numberOption";

/** Handles are this far from the seam at least, so that they can be told apart. [CSS pixels] */
const REACH = 30;
/** The arrow is this far along the seam. [CSS pixels] */
const ASIDE = 34;
/** A way that is seen shorter than this share counts as much, so that a drag does not run away. */
const LEAST_SHARE = 0.35;
/** Pixels of a drag over the whole usual range, at least. */
const LEAST_DRAG = 300;
/** As of the engine: the narrow side keeps this share of the width. */
const NARROW = 0.05;

/** The operator whose card was used last, of those that are open or selected. */
function operatorOf({ chosen, open, anchor, document }: State): Stacked | undefined {
  const is = ({ full }: Stacked) => open.has(full) || chosen.has(full);
  const all = document.stack.filter((each) => is(each) && isEnabled(document.merged, each));
  return all.find(({ full }) => full === anchor) ?? all.at(-1);
}

export function Handles() {
  const store = useStore();
  const isLive = useLive();
  const garment = useSelect((state) => state.garment);
  const full = useSelect((state) => operatorOf(state)?.full);
  const set = useSelect((state) => {
    const operator = operatorOf(state);
    return operator ? setsOf(state.document.merged, operator, garment?.kinds ?? []).join(" + ") : "";
  });
  useEffect(() => {
    let isCurrent = true;
    store.view?.grip(null);
    if (set && isLive) store.selector.find(set, (elements) => isCurrent && store.view?.grip(elements));
    return () => void (isCurrent = false);
  }, [set, full, garment, isLive]);
  const grip = useSelect((state) => (state.document.comparing ? null : state.grip));
  const fields = useSelect((state) => {
    const operator = operatorOf(state);
    return operator && instanceAt(state.document.merged, operator);
  });
  if (!grip || !full || !fields || fields.crease === true) return null;
  const kind = full.split(".")[0];
  return (
    <div class="handles" aria-hidden="true">
      {kind === "seam" && grip.left ? <SeamHandles full={full} grip={grip} left={grip.left} fields={fields} /> : null}
      {kind === "fold" && <Knob full={full} field="thickness" way={grip.normal} unit={grip.unit} from={grip} to={upward(grip)} reach={REACH} />}
    </div>
  );
}

/** 1 of the left, -1 of the right. */
type Side = 1 | -1;

function SeamHandles({ full, grip, left, fields }: { full: string; grip: Grip; left: Vector; fields: Fields }) {
  const store = useStore();
  const options = optionsOf(store, full);
  const length = (field: string) => {
    const number = numberOption(store.state, options[field], full + "." + field);
    return number ? (number.value || (number.auto ?? 0)) * number.size : 0;
  };
  const asymmetry = Number(fields.asymmetry ?? 0);
  const hasRows = Number(fields.offset ?? 0) > 0 || Number(fields.rows ?? 1) > 1;
  const chosen: Side | null = !hasRows ? null : fields.side === "left" ? 1 : fields.side === "right" ? -1 : null;
  const side: Side = grip.cloth || (chosen ?? (asymmetry > 0 ? -1 : 1));
  const share = Math.min(1 - NARROW, Math.max(NARROW, 0.5 * (1 - side * asymmetry)));
  // The first row is beside the edges, or on them, where the mesh has its height already.
  const offset = length("offset");
  const [row, height] = offset > 0 ? [side * offset, length("normalOffset")] : [0, 0];
  const crest = { x: grip.x + row * left[0] + height * grip.normal[0], y: grip.y + row * left[1] + height * grip.normal[1] };
  const outward: Vector = [side * share * left[0], side * share * left[1]];
  const reach = Math.max(REACH, length("width") * Math.hypot(...outward));
  const [aside, up] = [unitOf(outward), upward(grip)];
  const isBeside = Math.abs(aside[0] * up[0] + aside[1] * up[1]) > 0.8;
  return (
    <>
      <Knob full={full} field="width" way={outward} unit={share * grip.unit} from={crest} to={aside} reach={reach} />
      <Knob full={full} field="normalOffset" way={grip.normal} unit={grip.unit} from={crest} to={up} reach={isBeside ? REACH + reach : REACH} />
      <SideArrow full={full} grip={grip} left={left} side={chosen ?? (asymmetry === 0 ? null : side)} hasRows={hasRows} />
    </>
  );
}

function optionsOf({ state }: Store, full: string): Record<string, Option> {
  const kind = state.garment?.kinds.find(({ name }) => full.startsWith(`${name}.`));
  return Object.fromEntries((kind?.options ?? []).map((option) => [option.key, option]));
}

interface KnobProps {
  full: string;
  field: string;
  /** The way of one mesh unit on the screen. */
  way: Vector;
  /** Its length if it were seen from the side. */
  unit: number;
  from: { x: number; y: number };
  /** Where it is from there, and how far. [CSS pixels] */
  to: Vector;
  reach: number;
}

/** Drags a length along a way. */
function Knob({ full, field, way, unit, from, to: [x, y], reach }: KnobProps) {
  const store = useStore();
  const [pointer, setPointer] = useState<{ x: number; y: number } | null>(null);
  const key = `${full}.${field}`;
  const option = optionsOf(store, full)[field];
  const number = numberOption(store.state, option, key);
  if (!number) return null;
  const { value, auto, size, range } = number;
  const seen = Math.hypot(...way);
  const press = (event: TargetedPointerEvent<HTMLElement>) => {
    if (event.button !== 0) return;
    event.preventDefault();
    event.stopPropagation();
    const box = event.currentTarget.closest(".handles")?.getBoundingClientRect();
    const place = { x: event.clientX - (box?.x ?? 0), y: event.clientY - (box?.y ?? 0) };
    let at = value || (auto ?? 0);
    const pace = Math.min(1 / (size * Math.max(seen, LEAST_SHARE * unit)), (range.most - range.least) / LEAST_DRAG);
    setPointer({ ...place });
    const moved = (right: number, isFine: boolean, down: number) => {
      at += (right * x + down * y) * pace;
      const step = isFine ? range.fine : range.step;
      // A length of 0 is automatic, where it is no length itself.
      const next = Math.max(auto === null ? -Infinity : range.fine, clamped(option.domain, snapped(at, step)));
      setNumber(store, option, key, size, next, "continuous");
    };
    const track = ({ clientX, clientY }: PointerEvent) => setPointer({ x: clientX - (box?.x ?? 0), y: clientY - (box?.y ?? 0) });
    const knob = event.currentTarget;
    knob.addEventListener("pointermove", track);
    follow(event, moved, () => {
      knob.removeEventListener("pointermove", track);
      setPointer(null);
    });
  };
  return (
    <>
      <svg class="knob-stem"><line x1={from.x} y1={from.y} x2={from.x + reach * x} y2={from.y + reach * y} /></svg>
      <i
        class={`knob is-${field}`}
        title={`${labelOf(option)}: drag; with Shift for a tenth of the way`}
        style={{ left: `${from.x + reach * x}px`, top: `${from.y + reach * y}px` }}
        onPointerDown={press}
      />
      {pointer && (
        <span class="knob-number" style={{ left: `${pointer.x + 16}px`, top: `${pointer.y - 12}px` }}>
          {labelOf(option)} {shown(value || (auto ?? 0))} {number.unit}
        </span>
      )}
    </>
  );
}

function unitOf([x, y]: Vector): Vector {
  const length = Math.hypot(x, y) || 1;
  return [x / length, y / length];
}

/** The direction of the normal on the screen. One that is seen from its end is along the seam, and up. */
function upward({ normal, left, unit }: Grip): Vector {
  if (Math.hypot(...normal) > LEAST_SHARE * unit) return unitOf(normal);
  const [x, y] = unitOf(left ?? [1, 0]);
  return x > 0 ? [y, -x] : [-y, x];
}

interface ArrowProps {
  full: string;
  grip: Grip;
  left: Vector;
  /** The side that the seam is on now; null of both. */
  side: Side | null;
  hasRows: boolean;
}

/** Points to the left of the edges. A click gives the seam the other side; one on both sides the left. */
function SideArrow({ full, grip, left, side, hasRows }: ArrowProps) {
  const store = useStore();
  const [x, y] = unitOf(left);
  const up = upward(grip);
  // Away from the crest.
  const along = up[1] * x - up[0] * y > 0 ? -ASIDE : ASIDE;
  const flip = () => {
    const field = hasRows ? "side" : "asymmetry";
    const before = Number(instanceAt(store.state.document.merged, operatorOf(store.state) as Stacked)?.asymmetry ?? 0);
    const value = hasRows ? (side === 1 ? "right" : "left") : before === 0 ? -1 : -before;
    store.setAll(keysWith(store.state, `${full}.${field}`).map((key) => ({ key, value })));
  };
  const on = side === null ? "both sides" : side === 1 ? "the left" : "the right";
  return (
    <button
      type="button"
      tabIndex={-1}
      class="knob-side"
      data-side={side ?? 0}
      title={`The arrow points to the left. The seam is on ${on}; a click puts it on ${side === 1 ? "the right" : "the left"}`}
      style={{ left: `${grip.x - along * y}px`, top: `${grip.y + along * x}px` }}
      onClick={flip}
    >
      <svg viewBox="-17 -9 34 18" width="34" height="18" style={{ rotate: `${Math.atan2(y, x)}rad` }}>
        <path d="M-13 0H13M7 -5L13 0L7 5" />
      </svg>
      <b style={{ left: `${17 + 24 * x}px`, top: `${9 + 24 * y}px` }}>L</b>
    </button>
  );
}
