import { useLayoutEffect } from "preact/hooks";
import type { Store } from "../store";
import { StoreContext, useSelect } from "./hooks";
import { KeysDialog } from "./KeysDialog";
import { Banners, Toasts } from "./Notices";
import { Recipe } from "./Recipe";
import { SaveDialog } from "./SaveDialog";
import { Stage } from "./Stage";
import { Strip } from "./Strip";
import { TopBar } from "./TopBar";

export function App({ store }: { store: Store }) {
  return (
    <StoreContext.Provider value={store}>
      <Theme />
      <div class="page">
        <TopBar />
        <Recipe />
        <div class="work">
          <Banners />
          <Stage />
          <Strip />
        </div>
      </div>
      <SaveDialog />
      <KeysDialog />
      <Toasts />
    </StoreContext.Provider>
  );
}

function Theme() {
  const theme = useSelect(({ settings }) => settings.theme);
  useLayoutEffect(() => {
    document.documentElement.dataset.theme = theme;
  }, [theme]);
  return null;
}
