// The cloth that a solver simulates: its figures, its options, and its fabrics as cards.

import type { ClothMessage } from "../../server/protocol";
import { addFabric, deleteFabric, renameFabric } from "../../state/fabrics";
import { fabricsOf, fullName, instanceAt, type Instance } from "../../state/recipe";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { MenuButton, type MenuItem } from "../controls/Menu";
import { count, percent } from "../controls/numbers";
import { NameField } from "./NameField";
import { Faults, OptionRow } from "./OptionRow";
import { Swatch, useSets } from "./SetChips";

/** Mass, area and rest, as `build` prints them. */
export function ClothFigures() {
  const cloth = useSelect((state) => state.cloth);
  if (!cloth) return null;
  return <p class="cloth-figures" data-testid="cloth-figures">{words(cloth)}</p>;
}

function words({ figures }: ClothMessage): string {
  if (!figures) return "No physics is written";
  const { mass, area, fabrics, attached, pinned, rest } = figures;
  const grams = `${count(Math.round(1000 * mass))} g`;
  const parts = [`${fabrics.join(", ")}: ${grams}, ${area.toFixed(3)} m²`];
  if (attached > 0) parts.push(`${attached} attached ${attached === 1 ? "piece" : "pieces"}`);
  if (pinned > 0) parts.push(`${count(pinned)} pinned points`);
  if (rest) parts.push(`rests as ${rest.panels} flat panels, stretched by ${percent(rest.stretchRms)} (RMS)`);
  return parts.join(" · ");
}

export function Fabrics() {
  const merged = useSelect(({ document }) => document.merged);
  const fabrics = fabricsOf(merged);
  return (
    <>
      <div class="cards is-fabrics" role="list" aria-label="Fabrics">
        {fabrics.map((fabric) => <FabricCard key={fabric.name} fabric={fabric} />)}
      </div>
      <NewFabric />
    </>
  );
}

function NewFabric() {
  const store = useStore();
  const sets = useSets(["face"]);
  const items = (): MenuItem[] => [
    { label: "Whole garment", pick: () => addFabric(store, null) },
    ...sets.map(({ name, count }) => ({
      label: name,
      detail: `${count} faces`,
      chip: store.view?.colourOf(name),
      section: "Face sets",
      pick: () => addFabric(store, name),
      hover: (on: boolean) => store.highlight(on ? [name] : null),
    })),
  ];
  return (
    <div class="new-fabric">
      <MenuButton label="New fabric" hint="A fabric of a face set, or of the whole garment" class="button" items={items}>
        <Icon name="plus" />
        New fabric
      </MenuButton>
    </div>
  );
}

function FabricCard({ fabric }: { fabric: Instance }) {
  const store = useStore();
  const full = fullName(fabric);
  const isOpen = useSelect(({ open }) => open.has(full));
  const options = useSelect(({ garment }) => garment?.fabric) ?? [];
  const fields = useSelect(({ document }) => instanceAt(document.merged, fabric)) ?? {};
  const isEdited = useSelect(({ document }) => instanceAt(document.edits, fabric) !== undefined);
  const isAuthored = useSelect(({ document }) => instanceAt(document.upstream, fabric) !== undefined);
  const faults = useSelect(({ placed }) => placed.at.get(full)) ?? [];
  const isRenaming = useSelect(({ naming }) => naming === full);
  const sets = Array.isArray(fields.faces) ? fields.faces : [];
  const blocked = isAuthored ? "authored in the garment" : undefined;
  const items = (): MenuItem[] => [
    { label: "Rename", icon: "rename", blocked, pick: () => store.update({ naming: full }) },
    { label: "Delete", icon: "trash", danger: true, blocked, pick: () => deleteFabric(store, fabric) },
  ];
  return (
    <div class={`card ${faults.length > 0 ? "has-fault" : ""}`} role="listitem" data-card={full} tabIndex={0} aria-label={`fabric ${fabric.name}`}>
      <header class="card-head" onPointerEnter={() => store.highlight(sets)} onPointerLeave={() => store.highlight(null)}>
        <Swatch set={sets[0]} />
        {isRenaming ? (
          <NameField instance={fabric} rename={(name) => renameFabric(store, fabric, name)} />
        ) : (
          <button type="button" class="card-title" aria-expanded={isOpen} onClick={() => store.openCard(full, !isOpen)}>
            <span class="card-name">{fabric.name}</span>
            {isEdited && <i class="edited-dot" title="Edited here" />}
            <span class="card-summary">{!isOpen && String(fields.preset ?? "cotton")}</span>
          </button>
        )}
        <MenuButton label={`More of ${fabric.name}`} items={items}>
          <Icon name="more" />
        </MenuButton>
      </header>
      {isOpen && (
        <div class="card-body">
          {options.map((option) => <OptionRow key={option.key} option={option} full={`${full}.${option.key}`} />)}
        </div>
      )}
      {faults.length > 0 && (
        <div class="card-faults">
          <Faults faults={faults} />
        </div>
      )}
    </div>
  );
}
