// The strip below the view: figures of both meshes, times, warnings.

import type { Role } from "../../server/protocol";
import type { Product, Standing } from "../../state/state";
import { IconButton } from "../controls/controls";
import { useLevels, useSelect, useStanding, useStandingOfAll, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { count, degrees, milliseconds, percent } from "../controls/numbers";
import { ROLE_NAMES } from "../../state/settings";
import { findingsOf } from "../../state/state";
import type { Finding } from "../../state/garment";
import type { Timing } from "../../state/stopwatch";
import { SEVERITY_ICONS, Warnings } from "./Warnings";

export function Strip() {
  const store = useStore();
  const isOpen = useSelect(({ settings }) => settings.figures);
  const roles = useSelect(({ settings }) => settings.roles);
  const products = useSelect((state) => state.products);
  const lastEdit = useSelect((state) => state.lastEdit);
  const garment = useSelect((state) => state.garment);
  const cloth = useSelect((state) => state.cloth);
  const fit = useSelect((state) => state.fit);
  const findings = findingsOf({ garment, fit, products, cloth });
  const toggle = () => store.settings({ figures: !isOpen });
  return (
    <section class={`strip ${isOpen ? "is-open" : ""}`} aria-label="Figures and warnings">
      <div class="strip-bar">
        <Brief role="sim" isShown={roles.includes("sim")} product={products.sim} figures={simBrief(products.sim)} />
        <Brief role="render" isShown={roles.includes("render")} product={products.render} figures={[]} />
        <span class="strip-space" />
        {lastEdit && (
          <span class="brief" title="From your last edit until it was drawn">
            Edit <b data-testid="last-edit">{milliseconds(lastEdit.total)}</b>
          </span>
        )}
        <FaultCount />
        <WarningCount findings={findings} isOpen={isOpen} toggle={toggle} />
        <IconButton label={isOpen ? "Hide figures" : "Show figures"} icon={isOpen ? "down" : "up"} act={toggle} />
      </div>
      {isOpen && (
        <div class="strip-body">
          <SimFigures product={products.sim} />
          <RenderFigures product={products.render} />
          <Times timing={lastEdit} />
          <Warnings findings={findings} />
        </div>
      )}
    </section>
  );
}

/** Faults of options, which are beside their controls: a click goes to the first. */
function FaultCount() {
  const placed = useSelect(({ placed }) => placed);
  const keys = [...placed.at.keys()];
  if (keys.length === 0) return null;
  const count = [...placed.at.values()].flat().length;
  const show = () => {
    const key = keys[0];
    const at = document.querySelector(`[data-key="${CSS.escape(key)}"]`) ?? cardOf(key);
    at?.scrollIntoView({ block: "center", behavior: "smooth" });
  };
  return (
    <button type="button" class="warning-count has-faults" title="Show the first" onClick={show}>
      <Icon name="error" />
      <span data-testid="fault-count">{count === 1 ? "1 error" : `${count} errors`}</span>
    </button>
  );
}

function cardOf(key: string): Element | null {
  const full = key.split(".").slice(0, 2).join(".");
  return document.querySelector(`[data-card="${CSS.escape(full)}"]`);
}

interface CountProps {
  findings: Finding[];
  isOpen: boolean;
  toggle(): void;
}

/** What is built, or could not be built, may still have warnings. */
const NO_WARNINGS: Record<Standing["is"], string> = {
  current: "No warnings",
  building: "Building",
  stale: "Warnings not known",
};

function WarningCount({ findings, isOpen, toggle }: CountProps) {
  const standing = useStandingOfAll();
  const count = findings.length;
  const worst = findings[0]?.severity;
  return (
    <button
      type="button"
      class={`warning-count ${worst ? `is-${worst}` : ""}`}
      aria-expanded={isOpen}
      title={standing === "current" ? "Show the list" : "Show the list. It is that of the last good builds"}
      onClick={toggle}
    >
      {(worst || standing === "current") && <Icon name={worst ? SEVERITY_ICONS[worst] : "check"} />}
      <span data-testid="warning-count">
        {count === 0 ? NO_WARNINGS[standing] : count === 1 ? "1 warning" : `${count} warnings`}
      </span>
    </button>
  );
}

interface BriefProps {
  role: "sim" | "render";
  isShown: boolean;
  product: Product | undefined;
  figures: [string, string][];
}

function Brief({ role, isShown, product, figures }: BriefProps) {
  const standing = useStanding(role);
  const hint = isShown ? undefined : "Hidden: these are the figures of its last build";
  return (
    <span class={`brief ${isShown ? "" : "is-hidden"}`} title={hint} data-brief={role}>
      {ROLE_NAMES[role]}
      {standing.is !== "current" && <em class="standing" title={standing.why}>{standing.is}</em>}
      {product ? (
        <>
          <span class="brief-points">
            <b>{count(product.figures.vertices)}</b> points
          </span>
          <b>{count(product.figures.faces)}</b> faces
          {product.level !== null && <Level role={role} />}
          {figures.map(([term, figure]) => (
            <span class="brief-more" key={term}>
              {term} <b>{figure}</b>
            </span>
          ))}
        </>
      ) : (
        <span>–</span>
      )}
    </span>
  );
}

/** The level that is written, and what display adds to it. */
function Level({ role }: { role: Role }) {
  const { written, shown } = useLevels(role);
  return (
    <span title="Subdivision level that is written; refinements for display are only shown">
      written at level <b>{written}</b>
      {shown > written && `, shown at ${shown}`}
    </span>
  );
}

function simBrief(product: Product | undefined): [string, string][] {
  const figures = product?.figures;
  return [
    ["smallest angle", degrees(figures?.minAngle)],
    ["under 30°", percent(figures?.shareUnder30)],
    ["length error", percent(figures?.lengthErrorRms)],
  ];
}

function SimFigures({ product }: { product: Product | undefined }) {
  const figures = product?.figures;
  return (
    <Figures
      title={`${ROLE_NAMES.sim} mesh`}
      rows={[
        ["Points", count(figures?.vertices)],
        ["Triangles", count(figures?.faces)],
        ["Smallest angle", degrees(figures?.minAngle)],
        ["Triangles under 30°", percent(figures?.shareUnder30)],
        ["Length error (RMS)", percent(figures?.lengthErrorRms)],
      ]}
    />
  );
}

function RenderFigures({ product }: { product: Product | undefined }) {
  const figures = product?.figures;
  return (
    <Figures
      title={`${ROLE_NAMES.render} mesh`}
      rows={[
        ["Points", count(figures?.vertices)],
        ["Faces", count(figures?.faces)],
        ["Level, as written", product ? String(product.level) : "–"],
        ["Quads", percent(figures?.quads)],
        ["Operators that ran", product ? String(product.operators.length) : "–"],
      ]}
    />
  );
}

function Figures({ title, rows }: { title: string; rows: [string, string][] }) {
  return (
    <div class="figures">
      <h3>{title}</h3>
      <dl>
        {rows.map(([term, figure]) => (
          <div key={term}>
            <dt>{term}</dt>
            <dd>{figure}</dd>
          </div>
        ))}
      </dl>
    </div>
  );
}

const PARTS = ["build", "encode", "transfer", "upload"] as const;

/** The parts of the last edit's time. What is in none of them is waiting, such as for the next frame. */
function Times({ timing }: { timing: Timing | null }) {
  if (!timing) return <Figures title="Last edit" rows={PARTS.map((part) => [part, "–"])} />;
  const known = PARTS.reduce((sum, part) => sum + timing[part], 0);
  return (
    <div class="figures">
      <h3>
        Last edit <span>{ROLE_NAMES[timing.role].toLowerCase()}</span>
      </h3>
      <div class="times-bar" aria-hidden="true">
        {PARTS.map((part) => <i key={part} class={`is-${part}`} style={{ flexGrow: timing[part] }} />)}
        <i style={{ flexGrow: Math.max(0, timing.total - known) }} />
      </div>
      <dl>
        {PARTS.map((part) => (
          <div key={part}>
            <dt>
              <i class={`time-dot is-${part}`} />
              {part[0].toUpperCase() + part.slice(1)}
            </dt>
            <dd>{milliseconds(timing[part])}</dd>
          </div>
        ))}
        <div class="is-total">
          <dt>Until drawn</dt>
          <dd>{milliseconds(timing.total)}</dd>
        </div>
      </dl>
    </div>
  );
}
