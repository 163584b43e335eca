import { useRef } from "preact/hooks";
import { openBuild } from "../state/build";
import type { Before, VariantSet } from "../server/protocol";
import { Button, IconButton, Select } from "./controls/controls";
import { useLive, useSelect, useStore } from "./controls/hooks";
import { Icon } from "./controls/icons";

export function TopBar() {
  const store = useStore();
  const isLive = useLive();
  const garment = useSelect((state) => state.garment);
  const { canUndo, canRedo, unsaved } = useSelect(({ document }) => document);
  const theme = useSelect(({ settings }) => settings.theme);
  return (
    <header class="top-bar">
      <svg class="mark" viewBox="0 0 24 24" width="24" height="24" aria-hidden="true">
        <path d="M4 19C9 18.5 7 13 11.5 12.5S14 6.5 19 5" stroke-dasharray="4 2.6" />
        <circle cx="19.5" cy="4.8" r="1.6" />
      </svg>
      <h1 class="garment-name" title={garment ? `${garment.file} ${garment.prim}` : undefined}>
        {garment?.file ?? "usdtailor"}
        <span class="prim">{garment?.prim}</span>
      </h1>
      <div class="top-group">
        <IconButton
          label="Undo"
          icon="undo"
          hint="Undo (Ctrl+Z)"
          disabled={!isLive || !canUndo}
          act={() => store.command({ type: "undo" })}
        />
        <IconButton
          label="Redo"
          icon="redo"
          hint="Redo (Ctrl+Shift+Z)"
          disabled={!isLive || !canRedo}
          act={() => store.command({ type: "redo" })}
        />
        <Compare disabled={!isLive || !canUndo} />
      </div>
      <IconButton
        label="Read the files again"
        icon="reload"
        hint="Read the files again. They are followed, but some network drives do not tell of changes."
        disabled={!isLive}
        act={() => store.command({ type: "reload" })}
      />
      <div class="variants">
        {garment?.variants.map((variants) => (
          <Variant key={variants.prim + variants.set} variants={variants} disabled={!isLive} />
        ))}
      </div>
      <span class={`unsaved ${unsaved ? "" : "is-hidden"}`} aria-live="polite">{unsaved ? "Not saved" : ""}</span>
      <IconButton label="Keys" icon="keys" hint="Keys (?)" act={() => store.update({ dialog: "keys" })} />
      <IconButton
        label={theme === "dark" ? "Light theme" : "Dark theme"}
        icon={theme === "dark" ? "sun" : "moon"}
        act={() => store.settings({ theme: theme === "dark" ? "light" : "dark" })}
      />
      <Button hint="Build what is saved (Ctrl+B)" disabled={!isLive || !garment} act={() => openBuild(store)}>Build</Button>
      <Button
        class="is-main"
        hint="Save (Ctrl+S)"
        disabled={!isLive || !garment}
        act={() => store.update({ dialog: "save", save: null })}
      >
        <Icon name="save" />
        Save
      </Button>
    </header>
  );
}

function Variant({ variants, disabled }: { variants: VariantSet; disabled: boolean }) {
  const store = useStore();
  const { prim, set, choices, selected } = variants;
  const values = choices.includes(selected) ? choices : [selected, ...choices];
  return (
    <fieldset class="variant" title={`Variant set ${set} of ${prim}`} disabled={disabled}>
      <span>{set}</span>
      <Select
        label={`Variant ${set}`}
        value={selected}
        groups={[{ choices: values.map((value) => ({ value, label: value || "none" })) }]}
        change={(choice) => store.command({ type: "variant", prim, set, choice })}
      />
    </fieldset>
  );
}

/** Shows an earlier state while it is held. */
function Compare({ disabled }: { disabled: boolean }) {
  const store = useStore();
  const isOn = useSelect(({ document }) => document.comparing !== null);
  const held = useRef(false);
  const hold = (on: boolean, earlier: Before = "step") => {
    if (held.current === on) return;
    held.current = on;
    store.command({ type: "compare", with: on ? earlier : null });
  };
  return (
    <button
      type="button"
      class="icon-button"
      aria-label="Compare"
      aria-pressed={isOn}
      title="Hold to see the garment before the last change (hold C), or with Shift as it was saved or opened"
      disabled={disabled}
      onPointerDown={({ shiftKey }) => hold(true, shiftKey ? "saved" : "step")}
      onPointerUp={() => hold(false)}
      onPointerLeave={() => hold(false)}
      onKeyDown={({ key }) => (key === " " || key === "Enter") && hold(true)}
      onKeyUp={() => hold(false)}
      onBlur={() => hold(false)}
    >
      <Icon name="compare" />
    </button>
  );
}
