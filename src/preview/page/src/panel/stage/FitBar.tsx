// Moves the garment and the body on the way of the fit.

import { useEffect } from "preact/hooks";
import { useSelect, useStore } from "../controls/hooks";
import { percent } from "../controls/numbers";

export function FitBar() {
  const store = useStore();
  const fit = useSelect((state) => state.fit);
  const large = useSelect(({ settings }) => settings.large);
  useEffect(() => store.way.mark(), [large]);
  if (!fit) return null;
  const { share, finding, new: fresh } = fit;
  const [{ length: count } = []] = Object.values(finding?.elements ?? {});
  const faces = count === 1 ? "1 face crosses" : `${count} faces cross`;
  const crossing = count === 0 ? "nothing crosses" : `${faces}, ${fresh === 0 ? "none" : fresh} new`;
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
