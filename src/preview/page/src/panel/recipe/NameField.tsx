// The name of an operator or a fabric while it is typed.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { show } from "../../state/operators";
import { fullName, nameProblem, type Instance } from "../../state/recipe";
import { isTyping } from "../../state/typing";
import { useStore } from "../controls/hooks";

interface NameFieldProps {
  instance: Instance;
  rename(name: string): void;
}

export function NameField({ instance, rename }: NameFieldProps) {
  const store = useStore();
  const field = useRef<HTMLInputElement>(null);
  const [name, setName] = useState(instance.name);
  const problem = nameProblem(store.state.document.merged, instance, name);
  const hasEnded = useRef(false);
  useLayoutEffect(() => {
    // The card of a new operator comes with the server's answer.
    if (isTyping(document.activeElement)) return;
    field.current?.focus({ preventScroll: true });
    field.current?.select();
  }, []);
  const end = (isKept: boolean, takesFocus: boolean) => {
    // The field leaves the page with the focus, which blurs it once more.
    if (hasEnded.current) return;
    hasEnded.current = true;
    const isRenamed = isKept && !problem && name !== instance.name;
    store.update({ naming: null });
    if (isKept && problem) store.toast({ text: `The name stays ${instance.name}: ${problem}` });
    if (isRenamed) rename(name);
    if (takesFocus) show(fullName(isRenamed ? { ...instance, name } : instance));
  };
  return (
    <input
      type="text"
      class="card-rename"
      aria-label={`Name of ${instance.name}`}
      aria-invalid={problem !== null}
      title={problem ?? "Enter to rename, Escape to keep the name"}
      spellcheck={false}
      autocomplete="off"
      data-clean={name === instance.name ? "" : undefined}
      value={name}
      ref={field}
      // Names have no spaces.
      onInput={({ currentTarget }) => setName(currentTarget.value.replaceAll(" ", "_"))}
      onBlur={() => end(true, false)}
      onKeyDown={(event) => {
        // Undo and save are keys of the page.
        if (!event.ctrlKey && !event.metaKey) event.stopPropagation();
        if (event.key === "Enter" && problem) store.toast({ text: `${name} is no name: ${problem}` });
        if (event.key === "Enter" && !problem) end(true, true);
        if (event.key === "Escape") end(false, true);
      }}
    />
  );
}
