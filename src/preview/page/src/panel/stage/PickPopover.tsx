// What may be done with the edge or face that was clicked.

import { useLayoutEffect, useRef } from "preact/hooks";
import type { Stacked } from "../../server/protocol";
import type { Kind } from "../../state/garment";
import { setsOf } from "../../state/recipe";
import { wordsOf } from "../../state/selection";
import { Button, IconButton } from "../controls/controls";
import { useLive, useOutside, useSelect, useStore } from "../controls/hooks";
import { addOperator, reveal } from "../../state/operators";
import type { Isolated, PickedSet } from "../../view/api";
import { Swatch } from "../recipe/SetChips";
import { KIND_NAMES } from "../recipe/Stack";

export function PickPopover() {
  const clicked = useSelect((state) => state.clicked);
  // A click elsewhere is another popover, with its own place and focus.
  return clicked && <Popover key={`${clicked.x},${clicked.y}`} />;
}

function Popover() {
  const store = useStore();
  const clicked = useSelect((state) => state.clicked);
  const garment = useSelect((state) => state.garment);
  const box = useRef<HTMLDivElement>(null);
  const close = () => {
    store.update({ clicked: null });
    store.highlight(null);
  };
  useOutside(box, close);
  useLayoutEffect(() => {
    const element = box.current;
    const stage = element?.parentElement;
    if (!element || !stage || !clicked) return;
    const fits = (at: number, size: number, whole: number) => (at + size + 12 > whole ? at - size - 8 : at + 8);
    element.style.left = `${Math.max(8, fits(clicked.x, element.offsetWidth, stage.clientWidth))}px`;
    // The bar of the selection stays free.
    const low = stage.querySelector<HTMLElement>(".selection-bar")?.offsetTop ?? stage.clientHeight;
    element.style.top = `${Math.max(8, fits(clicked.y, element.offsetHeight, low))}px`;
    (element.querySelector<HTMLElement>("[aria-label=Close]") ?? element).focus({ preventScroll: true });
  }, []);
  if (!clicked || !garment) return null;
  // Products have sets of their own, which are nothing to make seams of.
  const wanted = clicked.edge ? "edge" : "face";
  const sets = clicked.sets.filter(
    ({ name, kind }) => kind === wanted && garment.sets.some((set) => set.name === name && set.kind === kind),
  );
  return (
    <div
      class="pick"
      role="dialog"
      aria-label="What was clicked"
      tabIndex={-1}
      ref={box}
      onKeyDown={(event) => {
        if (event.key !== "Escape") return;
        event.stopPropagation();
        close();
      }}
    >
      <header class="pick-head">
        {clicked.edge ? `Edge ${clicked.edge[0]}–${clicked.edge[1]}` : `Face ${clicked.face}`}
        <span>
          <IsolateButton label="Show its panel alone" what={clicked} />
          <IconButton label="Close" icon="close" class="is-small" act={close} />
        </span>
      </header>
      {sets.length === 0 && <p class="pick-none">In no set</p>}
      {sets.map((set) => <PickRow key={`${set.kind} ${set.name}`} set={set} close={close} />)}
    </div>
  );
}

function IsolateButton({ label, what }: { label: string; what: Isolated }) {
  const store = useStore();
  return (
    <IconButton label={label} icon="isolate" hint={`${label} (Esc shows all)`} class="is-small" act={() => store.isolate(what)} />
  );
}

function PickRow({ set, close }: { set: PickedSet; close(): void }) {
  const store = useStore();
  const isLive = useLive();
  const garment = useSelect((state) => state.garment);
  const { merged, stack } = useSelect(({ document }) => document);
  const kinds = garment?.kinds ?? [];
  const kind = kinds.find(({ sets }) => sets.of === set.kind);
  const users = stack.filter((each) => setsOf(merged, each, kinds).includes(set.name));
  if (!kind || set.kind === "point") return null;
  const act = (what: () => void) => () => {
    close();
    what();
  };
  return (
    <div class="pick-row" onPointerEnter={() => store.highlight([set.name])} onPointerLeave={() => store.highlight(null)}>
      <Swatch set={set.name} />
      <span class="pick-name" title={set.name}>
        {wordsOf(set.name)}
        <small>{set.kind === "edge" ? "edge set" : "face set"}</small>
      </span>
      {set.kind === "face" && <IsolateButton label={`Show ${set.name} alone`} what={set.name} />}
      {users.map((user) => <Button class="is-small" act={act(() => reveal(store, user.full))}>{goTo(user)}</Button>)}
      {users.length === 0 && (
        <Button class="is-small" disabled={!isLive} act={act(() => addOperator(store, kind, set.name))}>{newOf(kind)}</Button>
      )}
    </div>
  );
}

function goTo({ kind, name }: Stacked): string {
  return `Go to ${KIND_NAMES[kind]} ${name}`;
}

function newOf({ name }: Kind): string {
  return `New ${KIND_NAMES[name]}`;
}
