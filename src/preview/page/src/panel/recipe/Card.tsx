// A seam or a fold.

import type { CSSProperties, HTMLAttributes, TargetedKeyboardEvent, TargetedMouseEvent } from "preact";
import type { Fields, KindName } from "../../server/options";
import type { Stacked } from "../../server/protocol";
import type { Kind } from "../../state/garment";
import { chooseTo, clickCard, copyValues, keysWith, pasteProblem, pasteValues, toggleCard, twinOf } from "../../state/cards";
import { isEnabled, instanceAt, setsOf } from "../../state/recipe";
import { Switch } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { MenuButton, type MenuItem } from "../controls/Menu";
import { inUnit, lengthUnit, shown, type LengthUnit } from "../controls/numbers";
import { deleteOperator, duplicateOperator, isUpstream, moveOperator, renameOperator } from "../../state/operators";
import { Look } from "../presets/Look";
import { wordsOf } from "../../state/selection";
import { NameField } from "./NameField";
import { Faults, OptionRow } from "./OptionRow";
import { Swatch } from "./SetChips";

const TWIN = {
  self: "Its sets lie on both sides of the garment",
  other: "The same on the other side: a value that is set here is set there (Y ends it)",
};

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
  const isRenaming = useSelect(({ naming }) => naming === full);
  const isChosen = useSelect(({ chosen }) => chosen.has(full));
  const isOn = isEnabled(merged, operator);
  const twin = useSelect((state) => twinOf(state, operator));

  const act = () => {
    clickCard(store, full);
    store.openCard(full, !isOpen);
  };
  const keys = (event: TargetedKeyboardEvent<HTMLElement>) => {
    const { target, currentTarget, key } = event;
    const isOfHead = target === currentTarget || (target as HTMLElement).matches(".card-title");
    if (!isOfHead || event.altKey) return;
    const isModified = event.ctrlKey || event.metaKey;
    let isTaken = true;
    if (key === " " && event.shiftKey) chooseTo(store, full);
    else if (key === " " && isModified) toggleCard(store, full);
    else if (isModified && key.toLowerCase() === "c") copyValues(store, operator);
    else if (isModified && key.toLowerCase() === "v") pasteValues(store, operator);
    else if (key === "Escape" && isChosen) store.update({ chosen: new Set() });
    // The title is a button, which takes these keys itself.
    else if ((key === "Enter" || key === " ") && target === currentTarget && !isModified) act();
    else isTaken = false;
    if (!isTaken) return;
    event.preventDefault();
    event.stopPropagation();
  };
  /** A click with a modifier selects, wherever on the head it is. */
  const choose = (event: TargetedMouseEvent<HTMLElement>) => {
    const isModified = event.shiftKey || event.ctrlKey || event.metaKey;
    if (!isModified || isRenaming) return;
    event.preventDefault();
    event.stopPropagation();
    (event.shiftKey ? chooseTo : toggleCard)(store, full);
  };
  const move = (event: TargetedKeyboardEvent<HTMLElement>) => {
    if (!event.altKey || (event.key !== "ArrowUp" && event.key !== "ArrowDown")) return;
    event.preventDefault();
    const card = event.currentTarget;
    moveOperator(store, full, place + (event.key === "ArrowUp" ? -1 : 1));
    // The element may be moved in the document, which takes its focus. A focus that went elsewhere meanwhile stays there.
    const keepFocus = () => document.activeElement === document.body && card.focus();
    requestAnimationFrame(() => requestAnimationFrame(keepFocus));
  };
  const states = [isOn ? "" : "is-off", isChosen ? "is-chosen" : "", isHovered ? "is-hovered" : "", hasFault ? "has-fault" : "", drag.class].join(
    " ",
  );
  return (
    <div
      class={`card ${states}`}
      style={drag.style}
      role="listitem"
      data-card={full}
      tabIndex={0}
      aria-label={`${kind.name} ${operator.name}, ${place + 1} of ${count}${isOn ? "" : ", off"}${isChosen ? ", selected" : ""}`}
      onKeyDown={(event) => (keys(event), move(event))}
    >
      {/* Not over the options, where a highlight would cover the seam that they change. */}
      <header
        class="card-head"
        onPointerEnter={() => store.highlight(sets)}
        onPointerLeave={() => store.highlight(null)}
        onClickCapture={choose}
      >
        <span class="handle" {...handle} title="Drag to another place, or Alt+Up and Alt+Down">
          <Icon name="handle" />
        </span>
        <Swatch set={sets[0]} />
        {isRenaming ? (
          <NameField instance={operator} rename={(name) => renameOperator(store, operator, name)} />
        ) : (
          <button
            type="button"
            class="card-title"
            aria-expanded={isOpen}
            title={listed ? sets.map(wordsOf).join(", ") : "render.operators leaves it out, so that it does not run"}
            onClick={act}
            onDblClick={() => !isUpstream(store, operator) && store.update({ naming: full })}
          >
            <Icon name={kind.name} />
            <span class="card-words">
              <span class="card-name">{operator.name}</span>
              {isEdited && <i class="edited-dot" title="Edited here" />}
              <span class="card-summary">
                {!listed && "not in the order"}
                {listed && !isOpen && <Summary operator={operator} />}
                {twin && (
                  <em class="card-twin" title={twin.full === full ? TWIN.self : TWIN.other}>
                    ⇄ {twin.full === full ? "both sides" : twin.name}
                  </em>
                )}
              </span>
            </span>
          </button>
        )}
        <Switch label={`${operator.name} on`} on={isOn} change={enable} />
        <MenuButton label={`More of ${operator.name}`} items={items}>
          <Icon name="more" />
        </MenuButton>
      </header>
      {isOpen && (
        <div class="card-body">
          <Look operator={operator} kind={kind} />
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

  function enable(on: boolean): void {
    store.setAll(keysWith(store.state, `${full}.enabled`).map((key) => ({ key, value: on })));
  }

  function items(): MenuItem[] {
    const isAuthored = isUpstream(store, operator);
    return [
      { label: "Duplicate", icon: "copy", pick: () => duplicateOperator(store, operator) },
      {
        label: "Rename",
        icon: "rename",
        blocked: isAuthored ? "authored in the garment; duplicate it instead" : undefined,
        pick: () => store.update({ naming: full }),
      },
      { label: "Copy values", detail: "Ctrl C", pick: () => copyValues(store, operator) },
      {
        label: "Paste values",
        detail: "Ctrl V",
        blocked: pasteProblem(store.state, operator) ?? undefined,
        pick: () => pasteValues(store, operator),
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
  return <>{fields && summary(operator, fields, lengthUnit(garment))}</>;
}

function summary({ kind }: Stacked, fields: Fields, unit: LengthUnit): string {
  const length = (field: string) => shown(inUnit(Number(fields[field] ?? 0), unit)).replace("-", "−");
  const automatic = (field: string) => (length(field) === "0" ? "auto" : length(field));
  const figures: Record<KindName, () => string> = {
    seam: () => `${automatic("width")} × ${length("normalOffset")} ${unit.word}`,
    fold: () => (automatic("thickness") === "auto" ? "auto" : `${length("thickness")} ${unit.word}`),
  };
  return figures[kind]();
}
