import type { Warning } from "../../server/protocol";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { Words } from "../controls/Words";

/** A click on a warning shows where it is. */
export function Warnings({ warnings }: { warnings: Warning[] }) {
  const store = useStore();
  const marked = useSelect((state) => state.marked);
  return (
    <div class="warnings">
      <h3>
        Warnings <span>{warnings.length || "none"}</span>
      </h3>
      <ul>
        {warnings.map((warning) => (
          <li key={`${warning.code} ${warning.place} ${warning.problem}`}>
            <button
              type="button"
              class="warning"
              aria-pressed={marked === warning}
              title={canShow(warning) ? "Show where (Escape ends it)" : undefined}
              onClick={() => store.mark(marked === warning ? null : warning)}
            >
              <span class="warning-icon" style={{ color: colourOf(warning.code) }} title={warning.code}>
                <Icon name="warning" />
              </span>
              <span class="warning-text">
                <b>{warning.place}</b> <Words text={warning.problem} />
                <small>
                  <Words text={warning.remedy} />
                  {extent(warning)}
                </small>
              </span>
            </button>
          </li>
        ))}
      </ul>
    </div>
  );
}

function canShow({ elements, names }: Warning): boolean {
  return Boolean(names?.length) || Object.values(elements).some((list) => list.length > 0);
}

function extent({ elements }: Warning): string {
  const parts = Object.entries(elements).flatMap(([kind, list]) =>
    list.length > 0 ? [`${list.length} ${list.length === 1 ? kind.slice(0, -1) : kind}`] : [],
  );
  return parts.length > 0 ? ` (${parts.join(", ")})` : "";
}

/** Hues that are apart from one another and legible in both themes. */
const HUES = [40, 15, 330, 280, 230, 190, 95];

/** Warnings of one code have one colour. */
function colourOf(code: string): string {
  const sum = [...code].reduce((hash, letter) => (hash * 31 + letter.charCodeAt(0)) % 9973, 7);
  const hue = HUES[sum % HUES.length];
  return `light-dark(hsl(${hue} 75% 36%), hsl(${hue} 80% 68%))`;
}
