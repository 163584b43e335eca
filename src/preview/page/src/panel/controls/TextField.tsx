// A line of text, taken on Enter or when it is left, and a choice of several words.

import { useState } from "preact/hooks";
import type { Described } from "./controls";

interface TextFieldProps extends Described {
  value: string;
  placeholder: string;
  change(value: string): void;
}

export function TextField({ label, describedBy, invalid, value, placeholder, change }: TextFieldProps) {
  const [draft, setDraft] = useState<string | null>(null);
  const commit = () => {
    if (draft !== null && draft.trim() !== value) change(draft.trim());
    setDraft(null);
  };
  return (
    <input
      type="text"
      class="text-field"
      aria-label={label}
      aria-describedby={describedBy}
      aria-invalid={invalid}
      autocomplete="off"
      spellcheck={false}
      placeholder={placeholder}
      data-clean={draft === null ? "" : undefined}
      value={draft ?? value}
      onInput={({ currentTarget }) => setDraft(currentTarget.value)}
      onBlur={commit}
      onKeyDown={(event) => {
        if (event.key === "Enter") {
          commit();
          event.currentTarget.blur();
        }
        if (event.key !== "Escape" || draft === null) return;
        event.stopPropagation();
        setDraft(null);
      }}
    />
  );
}

interface WordChoiceProps extends Described {
  words: string[];
  chosen: string[];
  change(chosen: string[]): void;
}

/** Words that are on or off, in their own order. */
export function WordChoice({ label, describedBy, invalid, words, chosen, change }: WordChoiceProps) {
  const toggled = (word: string) => words.filter((each) => chosen.includes(each) !== (each === word));
  return (
    <span class="segments is-several" role="group" aria-label={label} aria-describedby={describedBy} aria-invalid={invalid}>
      {words.map((word) => (
        <label key={word}>
          <input type="checkbox" aria-label={word} checked={chosen.includes(word)} onChange={() => change(toggled(word))} />
          <span>{word}</span>
        </label>
      ))}
    </span>
  );
}
