import { useLayoutEffect, useRef } from "preact/hooks";
import { Button } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { KEYS } from "../../state/keys";

export function KeysDialog() {
  const isOpen = useSelect(({ dialog }) => dialog === "keys");
  return isOpen ? <Dialog /> : null;
}

function Dialog() {
  const store = useStore();
  const dialog = useRef<HTMLDialogElement>(null);
  const version = useSelect(({ garment }) => garment?.version);
  useLayoutEffect(() => {
    dialog.current?.showModal();
    // The focus is on the button at the end.
    dialog.current?.scrollTo(0, 0);
  }, []);
  return (
    <dialog class="dialog keys" ref={dialog} aria-labelledby="keys-title" onClose={() => store.update({ dialog: null })}>
      <h2 id="keys-title">Keys</h2>
      <dl>
        {KEYS.map(([keys, meaning]) => (
          <div key={keys}>
            <dt>
              {keys.split(" ").map((key) => <kbd>{key}</kbd>)}
            </dt>
            <dd>{meaning}</dd>
          </div>
        ))}
      </dl>
      <footer>
        <span class="version">{version && `usdtailor ${version}`}</span>
        <Button act={() => dialog.current?.close()}>Close</Button>
      </footer>
    </dialog>
  );
}
