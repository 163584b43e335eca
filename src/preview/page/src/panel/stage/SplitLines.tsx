// The lines of a split view, which are dragged or moved by keys.

import { useRef } from "preact/hooks";
import type { Column } from "../../view/layout";
import { useSelect, useStore } from "../controls/hooks";

/** The line keeps away from the sides by this part. */
const LEAST = 0.04;
const STEP = 0.02;

export function SplitLines({ columns }: { columns: Column[] }) {
  const share = useSelect(({ split }) => split);
  if (share === null) return null;
  return (
    <>
      {columns.map((column, index) => (
        <SplitLine key={`${column.x} ${column.y}`} column={column} share={share} hasNames={index === 0} />
      ))}
    </>
  );
}

interface LineProps {
  column: Column;
  share: number;
  /** Whether it says what is on its sides. */
  hasNames: boolean;
}

function SplitLine({ column: { x, y, width, height }, share, hasNames }: LineProps) {
  const store = useStore();
  const from = useRef<{ pointer: number; share: number } | null>(null);
  const move = (to: number) => store.split(Math.min(1 - LEAST, Math.max(LEAST, to)));
  return (
    <div
      class="split-line"
      role="slider"
      tabIndex={0}
      aria-label="Split"
      aria-orientation="horizontal"
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(100 * share)}
      style={{ left: `${x + share * width}px`, top: `${y}px`, height: `${height}px` }}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        from.current = { pointer: event.clientX, share };
      }}
      onPointerMove={({ clientX }) => {
        if (from.current) move(from.current.share + (clientX - from.current.pointer) / width);
      }}
      onPointerUp={() => (from.current = null)}
      onPointerCancel={() => (from.current = null)}
      onKeyDown={({ key }) => {
        if (key === "ArrowLeft") move(share - STEP);
        if (key === "ArrowRight") move(share + STEP);
      }}
    >
      {hasNames && <span class="split-kept">kept</span>}
      {hasNames && <span class="split-now">now</span>}
    </div>
  );
}
