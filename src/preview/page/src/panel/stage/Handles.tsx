// Handles of the seam or the fold whose card is open, on the render mesh. The card has the same options for keys and screen readers.

import type { TargetedPointerEvent } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { Fields, Value } from "../../server/options";
import type { Stacked } from "../../server/protocol";
import { keysWith } from "../../state/cards";
import { instanceAt, isEnabled, labelOf, setsOf } from "../../state/recipe";
import type { State } from "../../state/state";
import type { Store } from "../../state/store";
import type { Grip, Vector } from "../../view/api";
import { useLive, useSelect, useStore } from "../controls/hooks";
import { shown, snapped } from "../controls/numbers";
import { follow } from "../controls/pointer";
import { clamped, numberOption, setNumber } from "../recipe/numberOption";

/** Handles are this far from the seam at least, so that they can be told apart; the arrow is as far along it. [CSS pixels] */
const REACH = 32;
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
  const grip = useSelect((state) => (state.document.comparing || state.brush ? null : state.grip));
  const fields = useSelect((state) => {
    const operator = operatorOf(state);
    return operator && instanceAt(state.document.merged, operator);
  });
  if (!grip || !full || !fields || fields.crease === true) return null;
  return (
    <div class="handles" aria-hidden="true">
      {grip.left && full.startsWith("seam.") && <SeamHandles full={full} grip={grip} left={grip.left} fields={fields} />}
      {full.startsWith("fold.") && <Knob full={full} field="thickness" way={grip.normal} unit={grip.unit} from={grip} to={upward(grip)} reach={REACH} />}
    </div>
  );
}

function SeamHandles({ full, grip, left, fields }: { full: string; grip: Grip; left: Vector; fields: Fields }) {
  const store = useStore();
  const length = (field: string) => {
    const number = numberAt(store, full, field);
    return number ? (number.value || (number.auto ?? 0)) * number.size : 0;
  };
  const asymmetry = Number(fields.asymmetry ?? 0);
  const hasRows = Number(fields.offset ?? 0) > 0 || Number(fields.rows ?? 1) > 1;
  // 1 is the left, -1 the right, 0 both.
  const chosen = hasRows ? { left: 1, right: -1 }[String(fields.side)] ?? 0 : -Math.sign(asymmetry);
  const side = grip.cloth || chosen || 1;
  const share = Math.min(1 - NARROW, Math.max(NARROW, 0.5 * (1 - side * asymmetry)));
  // The first row is beside the edges, or on them, where the mesh has its height already.
  const offset = length("offset");
  const [row, height] = offset > 0 ? [side * offset, length("normalOffset")] : [0, 0];
  const crest = { x: grip.x + row * left[0] + height * grip.normal[0], y: grip.y + row * left[1] + height * grip.normal[1] };
  const outward: Vector = [side * share * left[0], side * share * left[1]];
  const reach = Math.max(REACH, length("width") * Math.hypot(...outward));
  const [aside, up] = [directionOf(outward), upward(grip)];
  const isBeside = Math.abs(aside[0] * up[0] + aside[1] * up[1]) > 0.8;
  const flip = () => {
    const [field, value]: [string, Value] = hasRows ? ["side", chosen === 1 ? "right" : "left"] : ["asymmetry", -asymmetry || -1];
    store.setAll(keysWith(store.state, `${full}.${field}`).map((key) => ({ key, value })));
  };
  return (
    <>
      <Knob full={full} field="width" way={outward} unit={share * grip.unit} from={crest} to={aside} reach={reach} />
      <Knob full={full} field="normalOffset" way={grip.normal} unit={grip.unit} from={crest} to={up} reach={isBeside ? REACH + reach : REACH} />
      <SideArrow grip={grip} left={left} side={chosen} flip={flip} />
    </>
  );
}

function optionAt({ state }: Store, full: string, field: string) {
  return state.garment?.kinds.find(({ name }) => full.startsWith(`${name}.`))?.options.find(({ key }) => key === field);
}

function numberAt(store: Store, full: string, field: string) {
  const option = optionAt(store, full, field);
  return option && numberOption(store.state, option, `${full}.${field}`);
}

interface KnobProps {
  full: string;
  field: string;
  /** The way of one mesh unit on the screen, and its length if it were seen from the side. */
  way: Vector;
  unit: number;
  from: { x: number; y: number };
  /** Where it is from there, and how far. [CSS pixels] */
  to: Vector;
  reach: number;
}

/** Drags a length along a way. */
function Knob({ full, field, way, unit, from, to: [x, y], reach }: KnobProps) {
  const store = useStore();
  /** Of the pointer, while it drags. */
  const [place, setPlace] = useState<Vector | null>(null);
  const [option, number] = [optionAt(store, full, field), numberAt(store, full, field)];
  if (!option || !number) return null;
  const { value, auto, size, range } = number;
  const now = value || (auto ?? 0);
  const end = { x: from.x + reach * x, y: from.y + reach * y };
  const press = (event: TargetedPointerEvent<HTMLElement>) => {
    if (event.button !== 0) return;
    event.preventDefault();
    let [at, pointer] = [now, [end.x, end.y] as Vector];
    const pace = Math.min(1 / (size * Math.max(Math.hypot(...way), LEAST_SHARE * unit)), (range.most - range.least) / LEAST_DRAG);
    setPlace(pointer);
    follow(
      event,
      (right, isFine, down) => {
        const whole = isFine ? 10 : 1;
        pointer = [pointer[0] + whole * right, pointer[1] + whole * down];
        setPlace(pointer);
        at += (right * x + down * y) * pace;
        const next = clamped(option.domain, snapped(at, isFine ? range.fine : range.step));
        // A length of 0 would be automatic.
        setNumber(store, option, `${full}.${field}`, size, auto === null ? next : Math.max(range.fine, next), "continuous");
      },
      () => setPlace(null),
    );
  };
  return (
    <>
      <svg class="knob-stem"><line x1={from.x} y1={from.y} x2={end.x} y2={end.y} /></svg>
      <i
        class={`knob is-${field}`}
        title={`${labelOf(option)}: drag; with Shift for a tenth of the way`}
        style={{ left: `${end.x}px`, top: `${end.y}px` }}
        onPointerDown={press}
      />
      {place && (
        <span class="hover-label knob-number" style={{ left: `${place[0] + 16}px`, top: `${place[1] - 12}px` }}>
          {labelOf(option)} {shown(now)} {number.unit}
        </span>
      )}
    </>
  );
}

function directionOf([x, y]: Vector): Vector {
  const length = Math.hypot(x, y) || 1;
  return [x / length, y / length];
}

/** The direction of the normal on the screen. One that is seen from its end is along the seam, and up. */
function upward({ normal, left, unit }: Grip): Vector {
  if (Math.hypot(...normal) > LEAST_SHARE * unit) return directionOf(normal);
  const [x, y] = directionOf(left ?? [1, 0]);
  return x > 0 ? [y, -x] : [-y, x];
}

/** Points to the left of the edges. A click gives the seam the other side; one on both sides the left. */
function SideArrow({ grip, left, side, flip }: { grip: Grip; left: Vector; side: number; flip(): void }) {
  const [[x, y], up] = [directionOf(left), upward(grip)];
  // Away from the crest.
  const along = up[1] * x - up[0] * y > 0 ? -REACH : REACH;
  const on = side === 0 ? "both sides" : side === 1 ? "the left" : "the right";
  const at = { x: grip.x - along * y, y: grip.y + along * x };
  return (
    <>
      <button
        type="button"
        tabIndex={-1}
        class="knob-side"
        title={`The arrow points to the left. The seam is on ${on}; a click puts it on ${side === 1 ? "the right" : "the left"}`}
        style={{ left: `${at.x}px`, top: `${at.y}px` }}
        onClick={flip}
      >
        <svg viewBox="-17 -9 34 18" width="34" height="18" style={{ rotate: `${Math.atan2(y, x)}rad` }}>
          <path d="M-13 0H13M7 -5L13 0L7 5" />
        </svg>
      </button>
      <b class="knob-left" style={{ left: `${at.x + 24 * x}px`, top: `${at.y + 24 * y}px` }}>L</b>
    </>
  );
}
