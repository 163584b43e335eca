// The name of each mesh in its place on the view, and whether it is of the recipe as it is now.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Role } from "../../server/protocol";
import { makeLarge } from "../../state/keys";
import { ROLE_NAMES } from "../../state/settings";
import { shownOf } from "../../state/state";
import { columns, largeOf } from "../../view/layout";
import { FlatNotes } from "./FlatNotes";
import { SplitLines } from "./SplitLines";
import { useLevels, useSelect, useStanding, useStore } from "../controls/hooks";

export function ColumnLabels() {
  const box = useRef<HTMLDivElement>(null);
  const [size, setSize] = useState({ width: 0, height: 0 });
  const store = useStore();
  useSelect((state) => state.settings);
  useSelect((state) => state.brush);
  const settings = shownOf(store.state);
  useLayoutEffect(() => {
    const element = box.current;
    if (!element) return;
    const measure = () => setSize({ width: element.clientWidth, height: element.clientHeight });
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    measure();
    return () => observer.disconnect();
  }, []);
  const all = columns(settings, size.width, size.height);
  const large = largeOf(settings);
  return (
    <div class="columns" ref={box}>
      <FlatNotes />
      <SplitLines columns={all} />
      {all.map(({ x, y, width, height, roles, flat }) => (
        <div
          class={`column ${y > 0 ? "is-lower" : ""} ${x > 0 ? "is-beside" : ""}`}
          key={`${roles.join()} ${flat}`}
          style={{ left: `${x}px`, top: `${y}px`, width: `${width}px`, height: `${height}px` }}
        >
          <div class="column-labels">
            {roles.map((role) => (
              <Label key={role} role={role} isFlat={flat} isSmall={settings.layout === "large" && role !== large} />
            ))}
          </div>
        </div>
      ))}
    </div>
  );
}

function Label({ role, isFlat, isSmall }: { role: Role; isFlat: boolean; isSmall: boolean }) {
  const store = useStore();
  const standing = useStanding(role);
  const { shown, written } = useLevels(role);
  const name = ROLE_NAMES[role];
  const isMore = shown > written;
  return (
    <span class={`column-label is-${standing.is}`} data-role={role}>
      {isSmall ? (
        <button type="button" title="Make it the large one (G)" onClick={() => makeLarge(store, role)}>{name}</button>
      ) : (
        name
      )}
      {isFlat && <small>flat</small>}
      {isMore && <small title="Refinements for display are not written">+{shown - written} for display</small>}
      {standing.is === "building" && <em>building</em>}
      {standing.is === "stale" && <em title={standing.why}>stale: {standing.why}</em>}
    </span>
  );
}
