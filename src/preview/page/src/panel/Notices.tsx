// Banners above the view, toasts, and words for screen readers.

import type { Fault } from "../server/protocol";
import { Button, IconButton } from "./controls/controls";
import { useSelect, useStore } from "./controls/hooks";
import { copyText } from "./dialogs/clipboard";
import { Icon } from "./controls/icons";
import { Words } from "./controls/Words";

export function Banners() {
  const connection = useSelect((state) => state.connection);
  const file = useSelect(({ faults }) => faults.file);
  const presets = useSelect(({ faults }) => faults.presets);
  const { elsewhere } = useSelect(({ placed }) => placed);
  const viewFault = useSelect((state) => state.viewFault);
  return (
    <div class="banners" role="alert">
      {connection === "lost" && <Lost />}
      <Kept />
      {viewFault && (
        <p class="banner">
          <Icon name="error" />
          <span>
            <b>The 3D view cannot start.</b> {viewFault}
          </span>
        </p>
      )}
      {file.map((fault) => <Banner fault={fault} end="The last good garment stays." />)}
      {presets.map((fault) => <Banner fault={fault} end="The last good presets stay, and none is saved." />)}
      {elsewhere.map((fault) => <Banner fault={fault} end="" />)}
    </div>
  );
}

/** A command that is started again has another address, so that this page cannot go on with it. */
function Lost() {
  const store = useStore();
  const { edits, unsaved } = useSelect((state) => state.document);
  const copy = () => copyText(store, JSON.stringify(edits, null, 2));
  return (
    <p class="banner is-lost">
      <Icon name="warning" />
      <span>
        The connection is lost. If the command has ended, start it again and open the address that it prints.
        {unsaved && " It offers the unsaved edits again."}
      </span>
      {unsaved && (
        <Button class="is-small" hint="As the text of a .tailor file, for --recipe" act={copy}>Copy the unsaved edits</Button>
      )}
    </p>
  );
}

/** Edits of an earlier preview of the garment. */
function Kept() {
  const store = useStore();
  const kept = useSelect((state) => state.document.kept);
  const isOpen = useSelect((state) => state.connection === "open");
  if (!kept || !isOpen) return null;
  const answer = (restore: boolean) => store.command({ type: "kept", time: kept.time, restore });
  const time = new Date(kept.time).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
  return (
    <p class="banner is-lost">
      <Icon name="warning" />
      <span>
        Edits of {time} were not saved.
        {!kept.isCurrent && " The options of the garment have changed since."}
      </span>
      <Button class="is-small" act={() => answer(true)}>Restore</Button>
      <Button class="is-small" act={() => answer(false)}>Discard</Button>
    </p>
  );
}

function Banner({ fault, end }: { fault: Fault; end: string }) {
  return (
    <p class="banner">
      <Icon name="error" />
      <span>
        <b>{fault.place}</b> <Words text={fault.text} />{" "}
        <span class="remedy">
          <Words text={fault.remedy} /> {end}
        </span>
      </span>
    </p>
  );
}

export function Toasts() {
  const store = useStore();
  const toasts = useSelect((state) => state.toasts);
  const spoken = useSelect((state) => state.spoken);
  return (
    <>
      <div class="toasts" role="status" aria-live="polite">
        {toasts.map(({ id, text, code, action }) => (
          <div class="toast" key={id}>
            <div>
              <p>{text}</p>
              {code && <code>{code}</code>}
            </div>
            {action && <Button class="is-small" act={() => (store.dismiss(id), action.act())}>{action.label}</Button>}
            <IconButton label="Dismiss" icon="close" class="is-small" act={() => store.dismiss(id)} />
          </div>
        ))}
      </div>
      <div class="hidden" aria-live="assertive">{spoken}</div>
    </>
  );
}
