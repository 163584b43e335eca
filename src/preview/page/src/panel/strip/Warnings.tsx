import type { Severity } from "../../server/protocol";
import type { Finding } from "../../state/garment";
import { ROLE_NAMES } from "../../state/settings";
import { cureOf } from "../../state/fixes";
import type { Change } from "../../state/store";
import { Button } from "../controls/controls";
import { useLive, useSelect, useStandingOfAll, useStore } from "../controls/hooks";
import { inUnit, lengthUnit, rounded } from "../controls/numbers";
import { Icon, type IconName } from "../controls/icons";
import { Words } from "../controls/Words";

export const SEVERITY_ICONS: Record<Severity, IconName> = { fault: "error", quality: "warning", note: "note" };

/** The worst first. A click on a warning shows where it is. */
export function Warnings({ findings }: { findings: Finding[] }) {
  const store = useStore();
  const marked = useSelect((state) => state.marked);
  const place = useSelect((state) => state.place);
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
            {marked === finding && place && <Places at={place.at} count={place.count} />}
            <FixButton finding={finding} />
          </li>
        ))}
      </ul>
    </div>
  );
}

/** The way from place to place of a warning. */
function Places({ at, count }: { at: number; count: number }) {
  const store = useStore();
  return (
    <span class="warning-places" role="group" aria-label="Places">
      <Button class="is-small" hint="The place before ([)" act={() => store.visit(at - 1)}>Previous</Button>
      place {at + 1} of {count}
      <Button class="is-small" hint="The next place (])" act={() => store.visit(at + 1)}>Next</Button>
    </span>
  );
}

/** Sets the values that end a warning. */
function FixButton({ finding }: { finding: Finding }) {
  const store = useStore();
  const isLive = useLive();
  const garment = useSelect((state) => state.garment);
  const text = useSelect((state) => JSON.stringify(cureOf(state, finding)));
  const cure: Change[] = JSON.parse(text);
  if (cure.length === 0) return null;
  const unit = lengthUnit(garment);
  const words = cure.map(({ key, value }) => `${key.split(".")[2]} ${rounded(inUnit(Number(value), unit))} ${unit.word}`);
  return <Button class="is-small" hint={words.join(", ")} disabled={!isLive} act={() => store.setAll(cure)}>Fix it</Button>;
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
