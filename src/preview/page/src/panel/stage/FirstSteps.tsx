// How a first seam is made, over the picture of a garment that has none.

import type { ComponentChildren } from "preact";
import { IconButton } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";

/** The lines of a bit of mesh, and the one across it that becomes a seam. */
const MESH = "M2 12 94 4M2 32 94 24M2 52 94 44M14 4v54M38 2v54M62 1v54M86 0v54";
const LINE = "M2 32 94 24";
const EDGE = "M38 29 62 27";
const SIDES = "M2 28 94 20M2 36 94 28";

interface Step {
  key: string;
  words: string;
  drawing: ComponentChildren;
}

const STEPS: Step[] = [
  { key: "Click", words: "an edge", drawing: <path class="steps-taken" d={EDGE} /> },
  { key: "L", words: "the whole line", drawing: <path class="steps-taken" d={LINE} /> },
  {
    key: "N",
    words: "a seam along it",
    drawing: (
      <>
        <path class="steps-seam" d={LINE} />
        <path class="steps-stitches" d={SIDES} />
      </>
    ),
  },
];

export function FirstSteps() {
  const store = useStore();
  // Flat panels have no room for them.
  const isOff = useSelect(({ settings, document, drawn }) => {
    const hasSeams = document.stack.length > 0 || document.comparing !== null;
    return settings.knowsSteps || settings.flat || hasSeams || drawn === 0;
  });
  // The step that comes next: one edge grows to its line.
  const next = useSelect(({ selection }) => (!selection ? 0 : selection.count === 1 ? 1 : 2));
  if (isOff) return null;
  return (
    <div class="steps" role="note" aria-label="How to make a seam">
      <ol>
        {STEPS.map(({ key, words, drawing }, number) => (
          <li key={key} aria-current={number === next ? "step" : undefined}>
            <svg viewBox="0 0 96 56" width="84" height="49" aria-hidden="true">
              <path class="steps-mesh" d={MESH} />
              {drawing}
            </svg>
            <span>
              <kbd>{key}</kbd> {words}
            </span>
          </li>
        ))}
      </ol>
      <IconButton label="Hide these steps" icon="close" class="is-small" act={() => store.settings({ knowsSteps: true })} />
    </div>
  );
}
