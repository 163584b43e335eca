// The name of an operator or a fabric while it is typed.

import { useRef, useState } from "preact/hooks";
import { nameProblem, type Instance } from "../../state/recipe";
import { useStore } from "../controls/hooks";

interface NameFieldProps {
  instance: Instance;
  rename(name: string): void;
  done(): void;
}

export function NameField({ instance, rename, done }: NameFieldProps) {
  const store = useStore();
  const [name, setName] = useState(instance.name);
  const problem = nameProblem(store.state.document.merged, instance, name);
  const hasEnded = useRef(false);
  const end = (isKept: boolean) => {
    // The field leaves the page with the focus, which blurs it once more.
    if (hasEnded.current) return;
    hasEnded.current = true;
    if (isKept && !problem && name !== instance.name) rename(name);
    done();
  };
  return (
    <input
      type="text"
      class="card-rename"
      aria-label={`Name of ${instance.name}`}
      aria-invalid={problem !== null}
      title={problem ?? "Enter to rename, Escape to keep the name"}
      spellcheck={false}
      value={name}
      ref={(element) => {
        if (element && document.activeElement !== element) element.select();
      }}
      onInput={({ currentTarget }) => setName(currentTarget.value)}
      onBlur={() => end(true)}
      onKeyDown={(event) => {
        event.stopPropagation();
        if (event.key === "Enter" && !problem) end(true);
        if (event.key === "Escape") end(false);
      }}
    />
  );
}
