import { heatCss } from "../../view/shade/heat";
import { useSelect } from "../controls/hooks";
import { rounded } from "../controls/numbers";
import { paintedChoices, QUALITIES } from "../../state/settings";

const STOPS = 16;

/** What the colours of heat stand for. */
export function Legend() {
  const heat = useSelect((state) => state.heat);
  const shading = useSelect(({ settings }) => settings.shading);
  const garment = useSelect((state) => state.garment);
  if (shading !== "values" || !heat) return null;
  const choice = [...QUALITIES, ...paintedChoices(garment)].find(({ name }) => name === heat.name);
  const stops = Array.from({ length: STOPS + 1 }, (_, i) => heatCss(i / STOPS)).join(", ");
  const at = (share: number) => rounded(heat.least + share * (heat.most - heat.least)) + (choice?.unit ?? "");
  return (
    <figure class="legend" aria-label={`Heat of ${choice?.label ?? heat.name}`}>
      <figcaption>{choice?.label ?? heat.name}</figcaption>
      <i class="legend-bar" style={{ background: `linear-gradient(to right, ${stops})` }} />
      <div class="legend-scale">
        <span>{at(0)}</span>
        <span>{at(0.5)}</span>
        <span>{at(1)}</span>
      </div>
    </figure>
  );
}
