import { createContext } from "preact";
import { useContext, useEffect, useLayoutEffect, useReducer, useRef } from "preact/hooks";
import type { Store } from "../../state/store";
import { standingOf, type Standing, type State } from "../../state/state";
import type { Role } from "../../server/protocol";

export const StoreContext = createContext<Store | null>(null);

export function useStore(): Store {
  const store = useContext(StoreContext);
  if (!store) throw new Error("no store");
  return store;
}

/** A part of the state. The component renders anew when the part is another object. */
export function useSelect<T>(select: (state: State) => T): T {
  const store = useStore();
  const [, render] = useReducer((count: number) => count + 1, 0);
  const value = select(store.state);
  const last = useRef({ select, value });
  last.current = { select, value };
  useLayoutEffect(
    () =>
      store.subscribe(() => {
        const { select, value } = last.current;
        if (!Object.is(select(store.state), value)) render(0);
      }),
    [store],
  );
  return value;
}

/** True while the server is there. */
export function useLive(): boolean {
  return useSelect(({ connection }) => connection === "open");
}

/** How the mesh that is shown stands to the recipe and the files as they are. */
export function useStanding(role: Role): Standing {
  const faults = useSelect((state) => state.faults);
  const progress = useSelect((state) => state.progress);
  const products = useSelect((state) => state.products);
  return standingOf({ faults, progress, products }, role);
}

/** That of the meshes as a whole: stale if one is, or else building if one is. */
export function useStandingOfAll(): Standing["is"] {
  const all = [useStanding("model"), useStanding("sim"), useStanding("render")].map((standing) => standing.is);
  return all.includes("stale") ? "stale" : all.includes("building") ? "building" : "current";
}

/** The level that is written of a mesh, and the one that is shown. */
export function useLevels(role: Role): Levels {
  const store = useStore();
  const product = useSelect(({ products }) => products[role]);
  const garment = useSelect((state) => state.garment);
  useSelect(({ drawn }) => drawn);
  const written = product?.level ?? 0;
  const faces = role === "model" ? garment?.faces : product?.figures.faces;
  const drawn = store.view?.stats(role)?.faces;
  // Each refinement for display makes about four faces of one. Large meshes get fewer refinements than are asked for.
  const more = faces && drawn ? Math.max(0, Math.round(Math.log(drawn / faces) / Math.log(4))) : 0;
  return { written, shown: written + more };
}

export interface Levels {
  written: number;
  shown: number;
}

export function useOutside(element: { current: HTMLElement | null }, act: () => void): void {
  const latest = useRef(act);
  latest.current = act;
  useEffect(() => {
    const listen = ({ target }: Event) => {
      if (!element.current?.contains(target as Node)) latest.current();
    };
    addEventListener("pointerdown", listen, true);
    return () => removeEventListener("pointerdown", listen, true);
  }, [element]);
}
