import { createContext } from "preact";
import { useContext, useEffect, useLayoutEffect, useReducer, useRef } from "preact/hooks";
import type { Store } from "../../state/store";
import type { State } from "../../state/state";

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
