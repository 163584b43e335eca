// The head of an open card: what the seam or fold looks like, and the preset that its values are of.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Stacked } from "../../server/protocol";
import { giveValues, valuesOf } from "../../state/cards";
import { automaticMeasure, MEASURE, type Kind } from "../../state/garment";
import { presetOf, presetsOf, removePreset, savePreset, type Preset } from "../../state/presets";
import { isEnabled, instanceAt } from "../../state/recipe";
import { Button } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { MenuButton, type MenuItem } from "../controls/Menu";
import { lengthUnit } from "../controls/numbers";
import { Profile, SmallProfile } from "./Profile";

/** Length of the folds that the menu draws, in thicknesses of the thickest one. */
const REACH = 4;

export function Look({ operator, kind }: { operator: Stacked; kind: Kind }) {
  const store = useStore();
  const [isSaving, setSaving] = useState(false);
  const garment = useSelect((state) => state.garment);
  const fields = useSelect(({ document }) => instanceAt(document.merged, operator)) ?? {};
  const isOff = useSelect(({ document }) => !isEnabled(document.merged, operator));
  const used = useSelect(({ products }) => products.render?.lengths[`${operator.full}.${MEASURE[kind.name]}`]);
  const known = useSelect((state) => state.presets);
  const presets = presetsOf(known, kind.name);
  const current = presetOf(presets, valuesOf(store.state, operator));
  const drawn = { kind: kind.name, auto: used ?? automaticMeasure(kind, garment) };
  return (
    <div class="look">
      <Profile {...drawn} fields={fields} unit={lengthUnit(garment)} isOff={isOff} />
      {isSaving ? (
        <PresetName operator={operator} presets={presets} done={() => setSaving(false)} />
      ) : (
        <MenuButton label={`Preset of ${operator.name}`} hint="Values of a kind of seam or fold" class="button" items={items}>
          <span class="preset-name">{current?.name ?? "Own values"}</span>
          <Icon name="down" />
        </MenuButton>
      )}
    </div>
  );

  function items(): MenuItem[] {
    // Folds differ most by their thickness, so that they are drawn to one scale.
    const reach = REACH * Math.max(...presets.map(({ values }) => Number(values.thickness ?? 0)));
    const saved = current?.isSaved ? [current] : [];
    return [
      ...presets.map((preset) => ({
        label: preset.name,
        picture: <SmallProfile {...drawn} reach={reach} fields={preset.values} />,
        detail: preset === current ? "in use" : undefined,
        section: preset.isSaved ? "Beside the garment" : "Presets",
        pick: () => giveValues(store, operator, preset.values),
      })),
      { label: "Save as preset…", icon: "save", section: "These values", pick: () => setSaving(true) },
      ...saved.map((preset) => ({
        label: `Remove “${preset.name}”`,
        icon: "trash" as const,
        danger: true,
        section: "These values",
        pick: () => removePreset(store, kind.name, preset),
      })),
    ];
  }
}

/** Takes the name of a new preset. */
function PresetName({ operator, presets, done }: { operator: Stacked; presets: Preset[]; done(): void }) {
  const store = useStore();
  const file = useSelect((state) => state.presets?.file) ?? "";
  const field = useRef<HTMLInputElement>(null);
  const [name, setName] = useState("");
  useLayoutEffect(() => field.current?.focus(), []);
  const isThere = presets.some((preset) => preset.isSaved && preset.name === name.trim());
  return (
    <form
      class="preset-save"
      onSubmit={(event) => {
        event.preventDefault();
        if (name.trim() === "") return;
        savePreset(store, operator.kind, name.trim(), valuesOf(store.state, operator));
        done();
      }}
      onKeyDown={(event) => {
        event.stopPropagation();
        if (event.key === "Escape") done();
      }}
    >
      <input
        type="text"
        aria-label="Name of the preset"
        placeholder="Name of the preset"
        title={`Saved in ${file}`}
        maxLength={60}
        spellcheck={false}
        autocomplete="off"
        value={name}
        ref={field}
        onInput={({ currentTarget }) => setName(currentTarget.value)}
      />
      <button type="submit" class="button is-main" disabled={name.trim() === ""}>{isThere ? "Replace" : "Save"}</button>
      <Button act={done}>Cancel</Button>
    </form>
  );
}
