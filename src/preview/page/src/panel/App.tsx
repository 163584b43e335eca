import { useLayoutEffect } from "preact/hooks";
import type { Store } from "../state/store";
import { StoreContext, useSelect } from "./controls/hooks";
import { BuildDialog } from "./dialogs/BuildDialog";
import { KeysDialog } from "./dialogs/KeysDialog";
import { Banners } from "./Notices";
import { Recipe } from "./recipe/Recipe";
import { SaveDialog } from "./dialogs/SaveDialog";
import { Stage } from "./stage/Stage";
import { Strip } from "./strip/Strip";
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
      <BuildDialog />
      <KeysDialog />
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
