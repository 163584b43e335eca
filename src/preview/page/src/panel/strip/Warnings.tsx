import type { Severity } from "../../server/protocol";
import type { Finding } from "../../state/garment";
import { ROLE_NAMES } from "../../state/settings";
import { useSelect, useStandingOfAll, useStore } from "../controls/hooks";
import { Icon, type IconName } from "../controls/icons";
import { Words } from "../controls/Words";

export const SEVERITY_ICONS: Record<Severity, IconName> = { fault: "error", quality: "warning", note: "note" };

/** The worst first. A click on a warning shows where it is. */
export function Warnings({ findings }: { findings: Finding[] }) {
  const store = useStore();
  const marked = useSelect((state) => state.marked);
  const standing = useStandingOfAll();
  return (
    <div class="warnings">
      <h3>
        Warnings <span>{findings.length || (standing === "current" ? "none" : "not known")}</span>
      </h3>
      <ul>
        {findings.map((finding) => (
          <li key={`${finding.role} ${finding.code} ${finding.place} ${finding.problem}`}>
            <button
              type="button"
              class={`warning is-${finding.severity}`}
              aria-pressed={marked === finding}
              title={canShow(finding) ? "Show where (Escape ends it)" : undefined}
              onClick={() => store.mark(marked === finding ? null : finding)}
            >
              <span class="warning-icon" title={finding.code}>
                <Icon name={SEVERITY_ICONS[finding.severity]} />
              </span>
              <span class="warning-text">
                <b>{finding.place}</b> <Words text={finding.problem} />
                <small>
                  <i>{finding.severity}</i> · {ROLE_NAMES[finding.role].toLowerCase()}
                  {extent(finding)}
                  {finding.remedy && " · "}
                  <Words text={finding.remedy} />
                </small>
              </span>
            </button>
          </li>
        ))}
      </ul>
    </div>
  );
}

function canShow({ elements, names }: Finding): boolean {
  return Boolean(names?.length) || Object.values(elements).some((list) => list.length > 0);
}

function extent({ elements }: Finding): string {
  const parts = Object.entries(elements).flatMap(([kind, list]) =>
    list.length > 0 ? [`${list.length} ${list.length === 1 ? kind.slice(0, -1) : kind}`] : [],
  );
  return parts.length > 0 ? ` · ${parts.join(", ")}` : "";
}
