// The brush: what it paints, how large and how strong it is.

import { Button, IconButton, Select } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { lengthUnit, rounded } from "../controls/numbers";
import { Slider } from "../controls/Slider";

/** Radii of the slider. [mean edge lengths] */
const RADII = [0.5, 12];

export function PaintBar() {
  const store = useStore();
  const brush = useSelect((state) => state.brush);
  const garment = useSelect((state) => state.garment);
  useSelect(({ document }) => document.stack);
  if (!brush || !garment) return null;
  const { key, radius, strength } = brush;
  const { word, size } = lengthUnit(garment);
  const [least, most] = RADII.map((edges) => (edges * garment.meanEdge) / size);
  const step = least / 20;
  const choices = store.painter.targets().map(({ key, label }) => ({ value: key, label }));
  return (
    <div class="selection-bar paint-bar" role="toolbar" aria-label="Brush" title="Drag on the garment; Alt takes away, Shift smooths">
      <Select label="What is painted" value={key} groups={[{ choices }]} change={(key) => store.painter.take(key)} />
      <span>Radius {rounded(radius / size)} {word}</span>
      <Slider label="Radius" value={radius / size} range={{ least, most, step, fine: step / 10 }} change={(radius) => store.painter.set({ radius: radius * size })} />
      <span>Strength</span>
      <Slider label="Strength" value={strength} range={{ least: 0, most: 1, step: 0.01, fine: 0.001 }} change={(strength) => store.painter.set({ strength })} />
      <Button class="is-small" hint="The garment's own value again" act={() => store.reset(key)}>Reset</Button>
      <IconButton label="End painting" icon="close" hint="End painting (P, Esc)" class="is-small" act={() => store.painter.end()} />
    </div>
  );
}
