// What is selected, and what may be done with it.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { densityOf, paintedHint, setFiner } from "../../state/density";
import { addFromSelection, kindFor } from "../../state/operators";
import { shortName, WAYS, type Selection } from "../../state/selection";
import { Button, IconButton } from "../controls/controls";
import { useLive, useSelect, useStore } from "../controls/hooks";
import { lengthOrArea } from "../controls/numbers";
import { KIND_NAMES } from "../recipe/Stack";

export function SelectionBar() {
  const selection = useSelect((state) => state.selection);
  const isSelecting = useSelect((state) => state.isSelecting);
  const isPainting = useSelect((state) => state.brush !== null);
  if (isPainting || (!selection && !isSelecting)) return null;
  return (
    <div class="selection-bar" role="toolbar" aria-label="Selection">
      <p class="selection-words" role="status">{selection ? wordsOf(selection) : "Nothing is selected"}</p>
      <Field />
      {selection && <Ways kind={selection.kind} />}
      {selection?.kind === "face" && <Density />}
      {selection && <MakeButton />}
      <CloseButton />
    </div>
  );
}

function wordsOf({ count, kind, size, isClosed }: Selection): string {
  const parts = [`${count} ${kind}${count === 1 ? "" : "s"}`];
  if (size !== null) parts.push(lengthOrArea(size, kind === "face"));
  if (isClosed) parts.push("closed");
  return parts.join(" · ");
}

/** The expression, which may be typed. */
function Field() {
  const store = useStore();
  const selection = useSelect((state) => state.selection);
  const expression = selection?.expression ?? "";
  const isSelecting = useSelect((state) => state.isSelecting);
  const [draft, setDraft] = useState<string | null>(null);
  const field = useRef<HTMLInputElement>(null);
  useLayoutEffect(() => {
    if (isSelecting) field.current?.focus();
  }, [isSelecting]);
  const isTyping = draft !== null;
  useLayoutEffect(() => {
    if (isTyping) field.current?.select();
  }, [isTyping]);
  // A text that gives no set stays, to be mended.
  const last = useRef(selection);
  useLayoutEffect(() => {
    if (last.current !== selection) field.current?.blur();
    last.current = selection;
  }, [selection]);
  return (
    <input
      type="text"
      ref={field}
      class="selection-field"
      aria-label="Selection as an expression"
      placeholder="such as borders.lowest"
      spellcheck={false}
      data-clean={draft === null ? "" : undefined}
      value={draft ?? shortName(expression)}
      onFocus={() => setDraft(expression)}
      onInput={({ currentTarget }) => setDraft(currentTarget.value)}
      onBlur={() => {
        setDraft(null);
        store.update({ isSelecting: false });
      }}
      onKeyDown={(event) => {
        if (event.key !== "Enter" && event.key !== "Escape") return;
        event.preventDefault();
        event.stopPropagation();
        const text = event.currentTarget.value.trim();
        if (event.key === "Enter" && text) return store.selector.take(text);
        if (event.key === "Enter") store.selector.clear();
        event.currentTarget.blur();
      }}
    />
  );
}

function Ways({ kind }: { kind: Selection["kind"] }) {
  const store = useStore();
  return (
    <>
      {WAYS.filter((way) => way.of === kind).map((way) => (
        <Button
          key={way.label}
          class="is-small"
          hint={`${way.hint} (${way.key.toUpperCase()})`}
          act={() => store.selector.go(way.key)}
        >
          {way.label}
        </Button>
      ))}
      <span class="selection-rows" role="group" aria-label="Rows of faces">
        <IconButton
          label="One row less"
          icon="minus"
          hint="One row of faces less (−)"
          class="is-small"
          disabled={kind === "edge"}
          act={() => store.selector.grow(-1)}
        />
        <IconButton
          label="One row more"
          icon="plus"
          hint="One row of faces more around the selection (+)"
          class="is-small"
          act={() => store.selector.grow(1)}
        />
      </span>
    </>
  );
}

function Density() {
  const store = useStore();
  const isLive = useLive();
  const name = useSelect((state) => densityOf(state).name);
  const isPainted = useSelect((state) => densityOf(state).isPainted);
  const hint = (text: string) => (isPainted ? paintedHint(name) : text);
  return (
    <>
      <Button
        class="is-small"
        hint={hint("Smaller triangles of the simulation mesh here (D)")}
        disabled={!isLive || isPainted}
        act={() => setFiner(store, true)}
      >
        Finer
      </Button>
      <Button
        class="is-small"
        hint={hint("Again larger triangles here (Shift D)")}
        disabled={!isLive || isPainted || !name}
        act={() => setFiner(store, false)}
      >
        Coarser
      </Button>
    </>
  );
}

function MakeButton() {
  const store = useStore();
  const isLive = useLive();
  const kind = useSelect(({ selection, garment }) => kindFor(selection, garment));
  if (!kind) return null;
  return (
    <Button
      class="is-small is-main"
      hint={`A ${KIND_NAMES[kind.name]} of the selection (N)`}
      disabled={!isLive}
      act={() => addFromSelection(store)}
    >
      New {KIND_NAMES[kind.name]}
    </Button>
  );
}

function CloseButton() {
  const store = useStore();
  const close = () => {
    store.update({ isSelecting: false });
    store.selector.clear();
  };
  return <IconButton label="Select nothing" icon="close" hint="Select nothing (Esc)" class="is-small" act={close} />;
}
