// What is written on flat panels: their names, a scale bar, and the direction of the warp.

import type { PlanColumn } from "../../view/api";
import { RAIL } from "../../view/layout";
import { roundLength } from "../../view/shade/checker";
import { useSelect } from "../controls/hooks";
import { lengthUnit } from "../controls/numbers";
import { valueAt } from "../../state/recipe";
import { wordsOf } from "../../state/selection";
import { placed } from "./labels";

/** About the length of a scale bar. [CSS pixels] */
const BAR = 90;
/** A column that is narrower has no room for a scale bar. [CSS pixels] */
const LEAST_COLUMN = 200;

export function FlatNotes() {
  const plan = useSelect((state) => state.plan);
  return (
    <>
      {plan.map((column) => (
        <div class="plan" key={column.x + column.y * 1e4} role="group" aria-label="Panels">
          {placed(column.panels, column, wordsOf).map(({ name, text, x, y, width }) => (
            <span class="plan-label" key={name} style={{ left: `${x}px`, top: `${y}px`, width: `${width}px` }}>{text}</span>
          ))}
          {column.unit > 0 && column.width >= LEAST_COLUMN && <ScaleBar column={column} inset={plan.length === 1 ? RAIL : 0} />}
        </div>
      ))}
    </>
  );
}

function ScaleBar({ column, inset }: { column: PlanColumn; inset: number }) {
  const garment = useSelect((state) => state.garment);
  const merged = useSelect(({ document }) => document.merged);
  const usual = garment?.options.find(({ key }) => key === "cloth.warp")?.default;
  const warp = String(valueAt(merged, "cloth.warp") ?? usual ?? "v");
  const { word, size } = lengthUnit(garment);
  const length = roundLength(BAR / (column.unit * size));
  const breadth = length * column.unit * size;
  const left = column.x + column.width - inset - breadth - 16;
  return (
    <div class="plan-scale" style={{ left: `${left}px`, top: `${column.y + column.height - 58}px`, width: `${breadth}px` }}>
      <span class="plan-warp" data-warp={warp}>
        <svg viewBox="0 0 16 16" width="16" height="16" aria-hidden="true" style={warp === "u" ? { rotate: "90deg" } : {}}>
          <path d="M8 15V2M4 6l4-4 4 4" />
        </svg>
        warp
      </span>
      <i />
      {length} {word}
    </div>
  );
}
