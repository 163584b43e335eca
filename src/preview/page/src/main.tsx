import { render } from "preact";
import "./style.css";
import { App } from "./panel/App";
import { installKeys } from "./state/keys";
import type { Timing } from "./state/stopwatch";
import { Store } from "./state/store";
import type { View } from "./view/api";

declare global {
  interface Window {
    /** For tests. */
    preview: { readonly view: View | null; store: Store; timing: Timing[] };
  }
}

const store = new Store();
window.preview = {
  get view() {
    return store.view;
  },
  store,
  timing: store.stopwatch.timing,
};
installKeys(store);
const app = document.getElementById("app");
if (app) render(<App store={store} />, app);
