// Builds what is saved by the command, and shows what it prints.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import type { BuildMessage } from "../../server/protocol";
import { buildCommand, outputOf } from "../../state/build";
import { Button } from "../controls/controls";
import { useLive, useSelect, useStore } from "../controls/hooks";
import { copyText } from "./clipboard";

export function BuildDialog() {
  const isOpen = useSelect(({ dialog }) => dialog === "build");
  const savedAs = useSelect(({ document }) => document.savedAs);
  return isOpen ? <Dialog input={savedAs} /> : null;
}

function Dialog({ input }: { input: string | null }) {
  const store = useStore();
  const isLive = useLive();
  const dialog = useRef<HTMLDialogElement>(null);
  const [typed, setTyped] = useState<string | null>(null);
  // The dialog that follows a save is open before the path of what was saved arrives.
  const path = typed ?? (input === null ? "" : outputOf(input));
  const [isSure, setSure] = useState(false);
  const build = useSelect((state) => state.build);
  const own = build?.output === path ? build : null;
  const runs = build?.status === "running";
  const isTaken = own?.status === "failed" && own.text.includes("[output-exists]");
  useLayoutEffect(() => dialog.current?.showModal(), []);
  const start = () => {
    if (isTaken && !isSure) return setSure(true);
    setSure(false);
    store.command({ type: "build", path, overwrite: isTaken || own?.status === "built" });
  };
  return (
    <dialog class="dialog save" ref={dialog} aria-labelledby="build-title" onClose={() => store.update({ dialog: null })}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          start();
        }}
      >
        <h2 id="build-title">Build</h2>
        <label class="field">
          Output
          <input
            type="text"
            value={path}
            spellcheck={false}
            autocomplete="off"
            onInput={({ currentTarget }) => setTyped(currentTarget.value)}
          />
        </label>
        <div class="field">
          <span>{input === null ? "Save the edits first" : <code>{buildCommand(input, path)}</code>}</span>
          <pre class={runs ? "is-waiting" : ""} tabIndex={0} aria-label="What the command prints" aria-live="polite">
            {runs ? "Building…" : (own?.text ?? "")}
          </pre>
        </div>
        <p class="save-note" role="status" data-testid="build-state">{own && words(own)}</p>
        <footer>
          {own?.status === "built" && <Button act={() => copyText(store, own.output)}>Copy the path</Button>}
          <Button act={() => dialog.current?.close()}>Close</Button>
          <button
            type="submit"
            class={`button is-main ${isSure ? "is-danger" : ""}`}
            disabled={!isLive || runs || input === null || path.trim() === ""}
          >
            {isTaken ? (isSure ? "Overwrite: click again" : "Overwrite") : own?.status === "built" ? "Build again" : "Build"}
          </button>
        </footer>
      </form>
    </dialog>
  );
}

function words({ status, output }: BuildMessage): string {
  if (status === "running") return "";
  return status === "built" ? `Written: ${output}` : "Nothing was written";
}
