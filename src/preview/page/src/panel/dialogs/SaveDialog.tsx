// Saves the edits as a USD layer or a `.tailor` file, after a look at what would be written.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { SaveMessage, SaveTargets } from "../../server/protocol";
import type { Store } from "../../state/store";
import { buildCommand, outputOf } from "../../state/build";
import { Button, Segments } from "../controls/controls";
import { useLive, useSelect, useStore } from "../controls/hooks";
import { Faults } from "../recipe/OptionRow";

type Format = "layer" | "recipe";

/** Pause in typing after which the plan is asked for. [ms] */
const PAUSE = 200;

export function SaveDialog() {
  const isOpen = useSelect(({ dialog }) => dialog === "save");
  const suggested = useSelect(({ garment }) => garment?.suggested);
  return isOpen && suggested ? <Dialog suggested={suggested} /> : null;
}

function Dialog({ suggested }: { suggested: SaveTargets }) {
  const store = useStore();
  const isLive = useLive();
  const dialog = useRef<HTMLDialogElement>(null);
  const savedTo = useSelect((state) => state.savedTo);
  const { layer, recipe } = withSaved(suggested, savedTo);
  const [path, setPath] = useState(savedTo ?? layer ?? recipe);
  const [isSure, setSure] = useState(false);
  const answer = useSelect((state) => state.save);
  const isNext = useSelect(({ buildsNext }) => buildsNext);
  const format = formatOf(path);
  const plan = answer?.path === path ? answer : null;

  useLayoutEffect(() => dialog.current?.showModal(), []);
  useEffect(() => {
    setSure(false);
    if (path.trim() === "") return;
    const timer = setTimeout(() => store.command({ type: "plan", path }), PAUSE);
    return () => clearTimeout(timer);
  }, [path]);
  useEffect(() => {
    if (plan?.status !== "saved") return;
    saved(store, plan.path);
    store.update({ dialog: store.state.buildsNext ? "build" : null, save: null, buildsNext: false });
  }, [plan]);

  const save = () => {
    if (plan?.exists && !isSure) return setSure(true);
    store.command({ type: "save", path, overwrite: plan?.exists ?? false });
  };
  return (
    <dialog
      class="dialog save"
      ref={dialog}
      aria-labelledby="save-title"
      onClose={() => store.state.dialog === "save" && store.update({ dialog: null, buildsNext: false })}
    >
      <form
        onSubmit={(event) => {
          event.preventDefault();
          save();
        }}
      >
        <h2 id="save-title">{isNext ? "Save the edits, then build" : "Save the edits"}</h2>
        {layer !== null && (
          <Segments
            label="Format"
            value={format}
            choices={[
              { value: "layer", label: "USD layer", hint: "A layer over the garment, for any program that reads USD" },
              { value: "recipe", label: ".tailor file", hint: "JSON with the options, for usdtailor and its plugin" },
            ]}
            change={(format) => setPath(format === "layer" ? layer : recipe)}
          />
        )}
        <label class="field">
          Path
          <input
            type="text"
            value={path}
            spellcheck={false}
            autocomplete="off"
            aria-invalid={plan?.fault != null}
            aria-describedby="save-fault save-note"
            onInput={({ currentTarget }) => setPath(currentTarget.value)}
          />
        </label>
        <p id="save-fault" class="save-fault" aria-live="polite">
          {plan?.fault && <Faults faults={[plan.fault]} />}
        </p>
        <div class="field">
          <span>{plan?.exists ? "The file exists. It would then hold:" : "What would be written"}</span>
          <pre class={plan ? "" : "is-waiting"} tabIndex={0} aria-label="What would be written">
            {plan?.text || (plan ? "" : "…")}
          </pre>
        </div>
        <p id="save-note" class="save-note">{plan?.note}</p>
        <footer>
          <Button act={() => dialog.current?.close()}>Cancel</Button>
          <button type="submit" class={`button is-main ${isSure ? "is-danger" : ""}`} disabled={!isLive || !plan}>
            {verb(plan, format, isSure)}
          </button>
        </footer>
      </form>
    </dialog>
  );
}

function formatOf(path: string): Format {
  return path.endsWith(".tailor") ? "recipe" : "layer";
}

/** The file that was saved last is the one of its format. */
function withSaved(suggested: SaveTargets, savedTo: string | null): SaveTargets {
  return savedTo === null ? suggested : { ...suggested, [formatOf(savedTo)]: savedTo };
}

/** A layer keeps what else is in it, a `.tailor` file is replaced. */
function verb(plan: SaveMessage | null, format: Format, isSure: boolean): string {
  if (!plan?.exists) return "Save";
  const word = format === "layer" ? "Update" : "Overwrite";
  return isSure ? `${word}: click again` : word;
}

function saved(store: Store, path: string): void {
  store.update({ savedTo: path });
  if (store.state.buildsNext) return;
  const act = () => store.update({ dialog: "build" });
  store.toast({ text: `Saved ${path}`, code: buildCommand(path, outputOf(path)), action: { label: "Build", act } });
}
