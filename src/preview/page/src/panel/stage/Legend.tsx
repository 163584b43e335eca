import { heatCss } from "../../view/shade/heat";
import { CUTS } from "../../view/mesh/panels";
import { useSelect, useStore } from "../controls/hooks";
import { rounded } from "../controls/numbers";
import { Swatch } from "../recipe/SetChips";
import { paintedChoices, QUALITIES } from "../../state/settings";

const STOPS = 16;

/** What colours stand for. */
export function Legends() {
  return (
    <div class="legends">
      <EdgeSetLegend />
      <HeatLegend />
    </div>
  );
}

/** The set that the view adds where the UV set is cut has an expression of its own. */
const expressionOf = (name: string): string => (name === CUTS ? "uvSeams" : name);

function EdgeSetLegend() {
  const store = useStore();
  const isShown = useSelect(({ settings }) => settings.edgeSets);
  const sets = useSelect(({ garment }) => garment?.sets) ?? [];
  // Other meshes have lines of other sets.
  useSelect(({ drawn }) => drawn);
  useSelect(({ settings }) => settings.roles);
  useSelect(({ isolated }) => isolated);
  const names = isShown ? (store.view?.edgeSets() ?? []) : [];
  if (names.length === 0) return null;
  // Sets that a build made are on its mesh alone, and selections are of the model.
  const isOfModel = (name: string) => name === CUTS || sets.some((set) => set.name === name);
  return (
    <section class="legend" aria-label="Edge sets on view">
      <h3>Edge sets</h3>
      <div class="legend-sets">
        {names.map((name) => (
          <button
            type="button"
            key={name}
            title={isOfModel(name) ? `Select ${name}` : `${name} is of a mesh that was built`}
            aria-disabled={!isOfModel(name)}
            onPointerEnter={() => store.highlight([name])}
            onPointerLeave={() => store.highlight(null)}
            onClick={() => isOfModel(name) && store.selector.take(expressionOf(name))}
          >
            <Swatch set={name} />
            {name}
          </button>
        ))}
      </div>
    </section>
  );
}

function HeatLegend() {
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
