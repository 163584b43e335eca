// A seam or a fold.

import type { CSSProperties, HTMLAttributes, TargetedKeyboardEvent } from "preact";
import { useState } from "preact/hooks";
import type { Fields } from "../../server/options";
import type { Stacked } from "../../server/protocol";
import type { Kind } from "../../state/garment";
import { isEnabled, instanceAt, setsOf } from "../../state/recipe";
import { Switch } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { MenuButton, type MenuItem } from "../controls/Menu";
import { shown, unitOf } from "../controls/numbers";
import { deleteOperator, duplicateOperator, isUpstream, moveOperator, renameOperator, setEnabled } from "../../state/operators";
import { NameField } from "./NameField";
import { Faults, OptionRow } from "./OptionRow";
import { Swatch } from "./SetChips";

interface CardProps {
  operator: Stacked;
  kind: Kind;
  place: number;
  count: number;
  handle: HTMLAttributes<HTMLElement>;
  drag: { class: string; style?: CSSProperties };
}

export function Card({ operator, kind, place, count, handle, drag }: CardProps) {
  const store = useStore();
  const { full, listed } = operator;
  const merged = useSelect(({ document }) => document.merged);
  const isOpen = useSelect(({ open }) => open.has(full));
  const isEdited = useSelect(({ document }) => instanceAt(document.edits, operator) !== undefined);
  const sets = setsOf(merged, operator, store.state.garment?.kinds ?? []);
  const isHovered = useSelect(({ hovered }) => (hovered?.sets ?? []).some(({ name }) => sets.includes(name)));
  const faults = useSelect(({ placed }) => placed.at.get(full));
  const hasFault = useSelect(({ placed }) =>
    [...placed.at.keys()].some((key) => key === full || key.startsWith(`${full}.`)),
  );
  const [isRenaming, setRenaming] = useState(false);
  const isOn = isEnabled(merged, operator);

  const keys = (event: TargetedKeyboardEvent<HTMLElement>) => {
    if (event.target !== event.currentTarget) return;
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      store.openCard(full, !isOpen);
    }
  };
  const move = (event: TargetedKeyboardEvent<HTMLElement>) => {
    if (!event.altKey || (event.key !== "ArrowUp" && event.key !== "ArrowDown")) return;
    event.preventDefault();
    const card = event.currentTarget;
    moveOperator(store, full, place + (event.key === "ArrowUp" ? -1 : 1));
    // The element may be moved in the document, which takes its focus.
    requestAnimationFrame(() => requestAnimationFrame(() => card.focus()));
  };
  const states = [isOn ? "" : "is-off", isHovered ? "is-hovered" : "", hasFault ? "has-fault" : "", drag.class].join(
    " ",
  );
  return (
    <div
      class={`card ${states}`}
      style={drag.style}
      role="listitem"
      data-card={full}
      tabIndex={0}
      aria-label={`${kind.name} ${operator.name}, ${place + 1} of ${count}${isOn ? "" : ", off"}`}
      onKeyDown={(event) => (keys(event), move(event))}
    >
      {/* Not over the options, where a highlight would cover the seam that they change. */}
      <header
        class="card-head"
        onPointerEnter={() => store.highlight(sets)}
        onPointerLeave={() => store.highlight(null)}
      >
        <span class="handle" {...handle} title="Drag to another place, or Alt+Up and Alt+Down">
          <Icon name="handle" />
        </span>
        <Swatch set={sets[0]} />
        {isRenaming ? (
          <NameField instance={operator} rename={(name) => renameOperator(store, operator, name)} done={() => setRenaming(false)} />
        ) : (
          <button
            type="button"
            class="card-title"
            aria-expanded={isOpen}
            title={listed ? sets.join(", ") : "render.operators leaves it out, so that it does not run"}
            onClick={() => store.openCard(full, !isOpen)}
            onDblClick={() => !isUpstream(store, operator) && setRenaming(true)}
          >
            <Icon name={kind.name} />
            <span class="card-name">{operator.name}</span>
            {isEdited && <i class="edited-dot" title="Edited here" />}
            <span class="card-summary">
              {!listed && "not in the order"}
              {listed && !isOpen && <Summary operator={operator} />}
            </span>
          </button>
        )}
        <Switch label={`${operator.name} on`} on={isOn} change={(on) => setEnabled(store, operator, on)} />
        <MenuButton label={`More of ${operator.name}`} items={items}>
          <Icon name="more" />
        </MenuButton>
      </header>
      {isOpen && (
        <div class="card-body">
          {kind.options.map((option) =>
            option.key === "enabled" ? null : (
              <OptionRow key={option.key} option={option} full={`${full}.${option.key}`} />
            ),
          )}
        </div>
      )}
      {faults && (
        <div class="card-faults">
          <Faults faults={faults} />
        </div>
      )}
    </div>
  );

  function items(): MenuItem[] {
    const isAuthored = isUpstream(store, operator);
    return [
      { label: "Duplicate", icon: "copy", pick: () => duplicateOperator(store, operator) },
      {
        label: "Rename",
        icon: "rename",
        blocked: isAuthored ? "authored in the garment; duplicate it instead" : undefined,
        pick: () => setRenaming(true),
      },
      {
        label: "Move up",
        icon: "up",
        detail: "Alt ↑",
        blocked: place === 0 ? "first" : undefined,
        pick: () => moveOperator(store, full, place - 1),
      },
      {
        label: "Move down",
        icon: "down",
        detail: "Alt ↓",
        blocked: place === count - 1 ? "last" : undefined,
        pick: () => moveOperator(store, full, place + 1),
      },
      {
        label: "Delete",
        icon: "trash",
        danger: true,
        detail: isAuthored ? "turns it off" : undefined,
        pick: () => deleteOperator(store, operator),
      },
    ];
  }
}

/** The figures that tell operators of a kind apart. */
function Summary({ operator }: { operator: Stacked }) {
  const fields = useSelect(({ document }) => instanceAt(document.merged, operator));
  const garment = useSelect((state) => state.garment);
  return <>{fields && summary(operator, fields, unitOf("mesh units", garment))}</>;
}

function summary({ kind }: Stacked, fields: Fields, unit: string): string {
  const length = (field: string) => shown(Number(fields[field] ?? 0)).replace("-", "−");
  const automatic = (field: string) => (length(field) === "0" ? "auto" : length(field));
  if (kind === "fold") return automatic("thickness") === "auto" ? "auto" : `${length("thickness")} ${unit}`;
  return `${automatic("width")} × ${length("normalOffset")} ${unit}`;
}
