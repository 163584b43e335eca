// The name of an operator while it is typed.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Stacked } from "../../server/protocol";
import { renameOperator, show } from "../../state/operators";
import { fullName, nameProblem } from "../../state/recipe";
import { useStore } from "../controls/hooks";

export function NameField({ operator }: { operator: Stacked }) {
  const store = useStore();
  const field = useRef<HTMLInputElement>(null);
  const [name, setName] = useState(operator.name);
  const problem = nameProblem(store.state.document.merged, operator, name);
  const hasEnded = useRef(false);
  useLayoutEffect(() => {
    field.current?.focus({ preventScroll: true });
    field.current?.select();
  }, []);
  const end = (isKept: boolean, takesFocus: boolean) => {
    // The field leaves the page with the focus, which blurs it once more.
    if (hasEnded.current) return;
    hasEnded.current = true;
    const isRenamed = isKept && !problem && name !== operator.name;
    store.update({ naming: null });
    if (isRenamed) renameOperator(store, operator, name);
    if (takesFocus) show(isRenamed ? fullName({ kind: operator.kind, name }) : operator.full);
  };
  return (
    <input
      type="text"
      class="card-rename"
      aria-label={`Name of ${operator.name}`}
      aria-invalid={problem !== null}
      title={problem ?? "Enter to rename, Escape to keep the name"}
      spellcheck={false}
      autocomplete="off"
      data-clean={name === operator.name ? "" : undefined}
      value={name}
      ref={field}
      onInput={({ currentTarget }) => setName(currentTarget.value)}
      onBlur={() => end(true, false)}
      onKeyDown={(event) => {
        // Undo and save are keys of the page.
        if (!event.ctrlKey && !event.metaKey) event.stopPropagation();
        if (event.key === "Enter" && !problem) end(true, true);
        if (event.key === "Escape") end(false, true);
      }}
    />
  );
}
