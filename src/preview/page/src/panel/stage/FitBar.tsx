// Moves the garment and the body on the way of the fit.

import { useSelect, useStore } from "../controls/hooks";
import { percent } from "../controls/numbers";

export function FitBar() {
  const store = useStore();
  const fit = useSelect((state) => state.fit);
  if (!fit) return null;
  const { share, crossings, new: fresh } = fit;
  const faces = crossings.length === 1 ? "1 face crosses" : `${crossings.length} faces cross`;
  const crossing = crossings.length === 0 ? "nothing crosses" : `${faces}, ${fresh === 0 ? "none" : fresh} new`;
  return (
    <div class="scrub-bar" role="group" aria-label="Fit" title="From the body that the garment was made for to the one that it fits">
      <input
        type="range"
        aria-label="Share of the fit"
        aria-valuetext={`${percent(share)}, ${crossing}`}
        min={0}
        max={1}
        step={0.01}
        value={share}
        onInput={({ currentTarget }) => store.way.show(currentTarget.valueAsNumber)}
      />
      <output>
        {percent(share)} · {crossing}
      </output>
    </div>
  );
}
