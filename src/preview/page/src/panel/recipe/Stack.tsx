// Seams and folds as cards, in the order in which they run.

import { useRef } from "preact/hooks";
import type { SetInfo, Stacked } from "../../server/protocol";
import type { Garment, Kind } from "../../state/garment";
import { setsOf } from "../../state/recipe";
import { Card } from "./Card";
import { useDrag } from "./drag";
import { Button } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { isDerived } from "./SetChips";
import { Icon } from "../controls/icons";
import { MenuButton, type MenuItem } from "../controls/Menu";
import { addOperator, moveOperator } from "../../state/operators";
import type { State } from "../../state/state";

export const KIND_NAMES: Record<Kind["name"], string> = { seam: "seam", fold: "fold" };

export function Stack() {
  const store = useStore();
  const operators = useSelect(({ document }) => document.stack);
  const kinds = useSelect(({ garment }) => garment?.kinds) ?? [];
  const list = useRef<HTMLDivElement>(null);
  const drag = useDrag(list, (full, to) => moveOperator(store, full, to));
  if (operators.length === 0) {
    return <p class="empty">No seams and no folds yet. Click an edge of the model and press L, or take a set from the menus.</p>;
  }
  return (
    <>
      <Chosen />
      <div class="cards" role="list" aria-label="Operators in the order in which they run" ref={list}>
        {operators.map((operator, place) => {
          const kind = kinds.find(({ name }) => name === operator.kind);
          if (!kind) return null;
          const props = { operator, kind, place, count: operators.length };
          return <Card key={operator.full} {...props} handle={drag.handle(operator.full)} drag={drag.style(place)} />;
        })}
      </div>
    </>
  );
}

/** Says what a selection of cards does, and ends it. */
function Chosen() {
  const store = useStore();
  const count = useSelect(({ chosen, document }) => document.stack.filter(({ full }) => chosen.has(full)).length);
  return (
    <div role="status">
      {count > 0 && (
        <p class="chosen-cards">
          <span>
            <b>{count === 1 ? "1 card" : `${count} cards`} selected.</b> A value that is set in one is set in all of its
            kind.
          </span>
          <Button class="is-small" act={() => store.update({ chosen: new Set() })}>Clear</Button>
        </p>
      )}
    </div>
  );
}

export function NewOperator() {
  const store = useStore();
  const kinds = useSelect(({ garment }) => garment?.kinds) ?? [];
  return (
    <div class="new-operator">
      {kinds.map((kind) => (
        <MenuButton
          key={kind.name}
          label={`New ${KIND_NAMES[kind.name]}`}
          hint={`A ${KIND_NAMES[kind.name]} along ${kind.sets.of === "edge" ? "an edge set" : "the border of a face set"}`}
          class="button"
          items={() => choices(kind, store.state).map((set) => item(kind, set))}
          empty={`The garment has no ${kind.sets.of} sets`}
        >
          <Icon name={kind.name} />
          New {KIND_NAMES[kind.name]}
        </MenuButton>
      ))}
    </div>
  );

  function item(kind: Kind, { name, count, kind: elements, section }: SetInfo & { section: string }): MenuItem {
    return {
      label: name,
      detail: `${count} ${elements}s`,
      chip: store.view?.colourOf(name),
      section,
      pick: () => addOperator(store, kind, name),
      hover: (on) => store.highlight(on ? [name] : null),
    };
  }
}

/** Sets that no operator of the kind uses come first. */
function choices(kind: Kind, { garment, document }: State): (SetInfo & { section: string })[] {
  const used = usedSets(
    garment,
    document.stack.filter((each) => each.kind === kind.name),
    document.merged,
  );
  const fitting = (garment?.sets ?? []).filter((set) => set.kind === kind.sets.of);
  const free = fitting.filter(({ name }) => !used.has(name));
  return [
    ...free.filter((set) => !isDerived(set)).map((set) => ({ ...set, section: "Not in use" })),
    ...fitting.filter(({ name }) => used.has(name)).map((set) => ({ ...set, section: "In use" })),
    ...free.filter(isDerived).map((set) => ({ ...set, section: "Found in the mesh" })),
  ];
}

function usedSets(
  garment: Garment | null,
  operators: Stacked[],
  merged: State["document"]["merged"],
): Set<string> {
  return new Set(operators.flatMap((operator) => setsOf(merged, operator, garment?.kinds ?? [])));
}
