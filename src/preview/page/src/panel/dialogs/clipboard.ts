import type { Store } from "../../state/store";

export async function copyText(store: Store, text: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    store.toast({ text: "Copied" });
  } catch {
    store.toast({ text: "The browser does not let the page copy; select the text instead.", code: text });
  }
}
