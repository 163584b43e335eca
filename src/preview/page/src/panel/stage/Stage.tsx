// The 3D view and what floats over it.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { setsOf } from "../../state/recipe";
import { wordsOf } from "../../state/selection";
import { Button } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { ColumnLabels } from "./ColumnLabels";
import { Legends } from "./Legend";
import { PaintBar } from "./PaintBar";
import { PickPopover } from "./PickPopover";
import { FirstSteps } from "./FirstSteps";
import { Handles } from "./Handles";
import { FitBar } from "./FitBar";
import { ScrubBar } from "./ScrubBar";
import { SelectionBar } from "./SelectionBar";
import { ROLE_NAMES } from "../../state/settings";
import { ROLES } from "../../view/layout";
import { Swatch } from "../recipe/SetChips";
import { Toasts } from "../Notices";
import { SideBar, ToolBar } from "./ToolBar";

export function Stage() {
  const store = useStore();
  const canvas = useRef<HTMLCanvasElement>(null);
  const comparing = useSelect(({ document }) => document.comparing);
  useLayoutEffect(() => {
    if (canvas.current) store.start(canvas.current);
  }, [store]);
  return (
    <main class="stage" aria-label="Garment">
      <canvas
        ref={canvas}
        tabIndex={0}
        aria-label="The garment in 3D"
        onPointerLeave={() => store.update({ hovered: null, outlines: [] })}
      />
      <Outlines />
      <ColumnLabels />
      <Handles />
      <StillNote />
      <FirstLoad />
      <Progress />
      <ToolBar />
      <SideBar />
      <FirstSteps />
      <Legends />
      <HoverLabel />
      <PickPopover />
      <SelectionBar />
      <PaintBar />
      <FitBar />
      <ScrubBar />
      <Toasts />
      <IsolatedNote />
      {comparing && <p class="comparing">{comparing === "step" ? "Before the last change" : "As it was saved or opened"}</p>}
    </main>
  );
}

function StillNote() {
  const isFinal = useSelect((state) => state.isFinal);
  return isFinal ? null : <p class="still-note">A finer picture comes</p>;
}

function IsolatedNote() {
  const store = useStore();
  const isolated = useSelect((state) => state.isolated);
  if (!isolated) return null;
  return (
    <p class="comparing is-isolated" role="status">
      A part is shown alone
      <Button class="is-small" hint="Show all (Esc)" act={() => store.isolate(null)}>Show all</Button>
    </p>
  );
}

/** Shorter work needs no bar, which would flicker. [ms] */
const PATIENCE = 300;

function Progress() {
  const progress = useSelect((state) => state.progress);
  const [, render] = useState(0);
  const active = ROLES.flatMap((role) => {
    const work = progress[role];
    return work ? [{ ...work, role }] : [];
  });
  const first = Math.min(...active.map(({ since }) => since));
  useEffect(() => {
    if (active.length === 0) return;
    const timer = setTimeout(() => render((n) => n + 1), Math.max(0, first + PATIENCE - performance.now()));
    return () => clearTimeout(timer);
  }, [first]);
  const late = active.filter(({ since }) => performance.now() - since >= PATIENCE - 1);
  if (late.length === 0) return null;
  return (
    <div class="progress" role="progressbar" aria-label="Working">
      <i />
      <span>
        {late
          .map(({ role, step }) => `${role === "model" ? ROLE_NAMES[role] : `${ROLE_NAMES[role]} mesh`}: ${step}`)
          .join(" · ")}
      </span>
    </div>
  );
}

function FirstLoad() {
  const isDrawn = useSelect(({ drawn }) => drawn > 0);
  const fault = useSelect(({ viewFault }) => viewFault);
  const file = useSelect(({ garment }) => garment?.file);
  if (isDrawn || fault) return null;
  return (
    <div class="first-load" role="status">
      <svg viewBox="0 0 220 90" width="220" height="90" aria-hidden="true">
        <path class="cloth-edge" d="M6 52C40 20 72 78 108 46s70-32 106-6" />
        <path class="thread" pathLength={100} d="M6 64C40 32 72 90 108 58s70-32 106-6" />
      </svg>
      <p>{file ? `Laying out ${file}` : "Waiting for the garment"}</p>
    </div>
  );
}

/** What a click takes, on all meshes. */
function Outlines() {
  const outlines = useSelect((state) => state.outlines);
  const isFace = useSelect(({ hovered }) => hovered?.edge === null);
  return outlines.map(({ x, y, width, height, path }) => (
    <svg class={`outline ${isFace ? "is-face" : ""}`} key={`${x} ${y}`} style={{ left: `${x}px`, top: `${y}px` }} width={width} height={height} aria-hidden="true">
      {!isFace && <path class="outline-rim" d={path} />}
      <path d={path} />
    </svg>
  ));
}

/** Names the sets under the pointer. Face sets are everywhere, so only those of a fold are named. */
function HoverLabel() {
  const hovered = useSelect((state) => state.hovered);
  const clicked = useSelect((state) => state.clicked);
  const garment = useSelect((state) => state.garment);
  const { merged, stack } = useSelect(({ document }) => document);
  if (!hovered || clicked || !garment) return null;
  const operators = stack.map((each) => ({ ...each, sets: setsOf(merged, each, garment.kinds) }));
  const labels = hovered.sets.flatMap(({ name, kind }) => {
    const users = operators.filter(({ sets }) => sets.includes(name)).map(({ full }) => full);
    return kind === "edge" || users.length > 0 ? [{ name, users }] : [];
  });
  if (labels.length === 0) return null;
  return (
    <div class="hover-label" style={{ left: `${hovered.x + 14}px`, top: `${hovered.y + 16}px` }} aria-hidden="true">
      {labels.map(({ name, users }) => (
        <span key={name}>
          <Swatch set={name} />
          {wordsOf(name)}
          {users.length > 0 && <em>{users.join(", ")}</em>}
        </span>
      ))}
    </div>
  );
}
