// Saves pictures of the view.

import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { MenuButton } from "../controls/Menu";

/** Width and height of a large picture. [pixels] */
const LARGE = [3840, 2160] as const;
/** Time of one turn. [seconds] */
const TURN = 8;

export function PictureButton() {
  const store = useStore();
  const flat = useSelect(({ settings }) => settings.flat);
  const items = () => [
    { label: "This view", detail: "PNG", pick: () => save("png", store.view?.screenshot()) },
    {
      label: "4k on a transparent ground",
      detail: "PNG",
      pick: () => save("png", store.view?.clearPicture(...LARGE)),
    },
    {
      label: "Turntable",
      detail: `WebM, ${TURN} s`,
      blocked: flat ? "Flat panels do not turn" : undefined,
      pick: () => save("webm", store.view?.turntable(TURN)),
    },
  ];
  return (
    <MenuButton label="Screenshot" hint="Save a picture" items={items}>
      <Icon name="camera" />
    </MenuButton>
  );

  async function save(ending: string, made: Promise<Blob> | undefined): Promise<void> {
    try {
      const blob = await made;
      if (blob) download(blob, `${(store.state.garment?.file ?? "garment").replace(/\.[^.]*$/, "")}.${ending}`);
    } catch (error) {
      store.toast({ text: error instanceof Error ? error.message : String(error) });
    }
  }
}

function download(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The download starts after this turn of the event loop.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
