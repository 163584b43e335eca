import { isQuality } from "../../view/mesh/values";
import { heatCss, scaleOf, valueAt } from "../../view/shade/heat";
import { CUTS } from "../../view/mesh/panels";
import { Button } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { lengthOrArea, rounded } from "../controls/numbers";
import { Swatch } from "../recipe/SetChips";
import type { Store } from "../../state/store";
import { wordsOf } from "../../state/selection";
import { paintedChoices, QUALITIES } from "../../state/settings";

const STOPS = 16;
/** Parts of the histogram. */
const PARTS = 30;

/** What colours stand for. */
export function Legends() {
  return (
    <div class="legends">
      <EdgeSetLegend />
      <CheckerLegend />
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
            {wordsOf(name)}
          </button>
        ))}
      </div>
    </section>
  );
}

function CheckerLegend() {
  const store = useStore();
  const shading = useSelect(({ settings }) => settings.shading);
  useSelect(({ drawn }) => drawn);
  const square = store.view?.square() ?? 0;
  if (shading !== "checker" || square === 0) return null;
  return (
    <figure class="legend is-small" aria-label="UV checker">
      <i class="legend-square" /> one square: {lengthOrArea(square, false)}
    </figure>
  );
}

function HeatLegend() {
  const store = useStore();
  const heat = useSelect((state) => state.heat);
  const shading = useSelect(({ settings }) => settings.shading);
  const garment = useSelect((state) => state.garment);
  const wanted = useSelect(({ settings }) => settings.values);
  if (shading !== "values") return null;
  if (!heat || heat.name !== wanted) {
    return <p class="legend" role="status">The heat is being made</p>;
  }
  const scale = scaleOf(heat);
  const choice = [...QUALITIES, ...paintedChoices(garment)].find(({ name }) => name === heat.name);
  const stops = Array.from({ length: STOPS + 1 }, (_, i) => heatCss(i / STOPS, scale)).join(", ");
  const at = (share: number) => rounded(valueAt(share, scale)) + (choice?.unit ?? "");
  return (
    <figure class="legend" aria-label={`Heat of ${choice?.label ?? heat.name}`}>
      <figcaption>{choice?.label ?? heat.name}</figcaption>
      <Histogram />
      <i class="legend-bar" style={{ background: `linear-gradient(to right, ${stops})` }} />
      <div class="legend-scale">
        <span>{at(0)}</span>
        <span>{at(0.5)}</span>
        <span>{at(1)}</span>
      </div>
      {isQuality(heat) && <Button class="is-small" act={() => flyToWorst(store)}>Fly to the worst</Button>}
    </figure>
  );
}

function flyToWorst(store: Store): void {
  if (!store.view?.flyToWorst()) store.toast({ text: "Show the simulation mesh in space to fly to its worst triangle" });
}

/** How many values are in each part of the scale below. */
function Histogram() {
  const store = useStore();
  useSelect(({ drawn }) => drawn);
  useSelect(({ settings }) => settings.large);
  const counts = store.view?.histogram(PARTS) ?? [];
  const most = Math.max(1, ...counts);
  return (
    <svg class="legend-histogram" viewBox={`0 0 ${PARTS} 1`} preserveAspectRatio="none" role="img" aria-label="Histogram">
      {counts.map((count, i) => <rect key={i} x={i} y={1 - count / most} width={0.9} height={count / most} data-count={count} />)}
    </svg>
  );
}
