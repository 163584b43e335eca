// The left panel: all options, by what they act on.

import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import type { Option } from "../../server/protocol";
import { ORDER, valueAt } from "../../state/recipe";
import { useLive, useSelect } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { ClothFigures, Fabrics } from "./Cloth";
import { OptionRow } from "./OptionRow";
import { NewOperator, Stack } from "./Stack";

/** Options of the simulation mesh that artists set often. The others fold under "More". */
const OFTEN = ["maxEdgeLength", "minEdgeLength", "density", "grading", "constraints", "constrainUvSeams"].map(
  (field) => `sim.${field}`,
);

const NONE: Option[] = [];

export function Recipe() {
  const isLive = useLive();
  const options = useSelect(({ garment }) => garment?.options) ?? NONE;
  const hasGarment = useSelect(({ garment }) => garment !== null);
  const often = OFTEN.flatMap((key) => options.filter((option) => option.key === key));
  const rest = options.filter(({ key }) => key.startsWith("sim.") && !OFTEN.includes(key));
  const cloth = options.filter(({ key }) => key.startsWith("cloth."));
  const fit = options.filter(({ key }) => key.startsWith("fit."));
  const lod = options.filter(({ key }) => key.startsWith("lod."));
  const render = options.filter(({ key }) => key.startsWith("render.") && key !== ORDER);
  return (
    <aside class="recipe" aria-label="Recipe">
      <fieldset class="recipe-scroll" disabled={!isLive}>
        {!hasGarment && <Skeleton />}
        {hasGarment && (
          <>
            <Section title="Seams and folds" tools={<NewOperator />}>
              <Stack />
            </Section>
            <Section title="Simulation mesh">
              <Rows options={often} />
              <More options={rest} />
            </Section>
            <Section title="Render mesh">
              <Rows options={render} />
            </Section>
            <Section title="Cloth">
              <ClothFigures />
              <Rows options={cloth} />
              <Fabrics />
            </Section>
            <Section title="Fit">
              <Rows options={fit} />
            </Section>
            <Section title="Levels of detail">
              <Rows options={lod} />
            </Section>
          </>
        )}
      </fieldset>
      <InfoLine />
    </aside>
  );
}

function Section({
  title,
  tools,
  children,
}: {
  title: string;
  tools?: ComponentChildren;
  children: ComponentChildren;
}) {
  const [isOpen, setOpen] = useState(true);
  return (
    <section class="section" aria-label={title}>
      <header class="section-head">
        <h2>
          <button type="button" class="fold" aria-expanded={isOpen} onClick={() => setOpen(!isOpen)}>
            <Icon name={isOpen ? "down" : "right"} />
            {title}
          </button>
        </h2>
        {isOpen && tools}
      </header>
      {isOpen && children}
    </section>
  );
}

function Rows({ options }: { options: Option[] }) {
  return (
    <>
      {options.map((option) => <OptionRow key={option.key} option={option} full={option.key} />)}
    </>
  );
}

/** Opens by itself where something in it is wrong. */
function More({ options }: { options: Option[] }) {
  const [wish, setOpen] = useState(false);
  const edited = useSelect(
    ({ document }) => options.filter(({ key }) => valueAt(document.edits, key) !== undefined).length,
  );
  const hasFault = useSelect(({ placed }) => options.some(({ key }) => placed.at.has(key)));
  const isOpen = wish || hasFault;
  if (options.length === 0) return null;
  return (
    <>
      <button type="button" class="fold more" aria-expanded={isOpen} onClick={() => setOpen(!isOpen)}>
        <Icon name={isOpen ? "down" : "right"} />
        More
        {edited > 0 && <i class="edited-dot" title={`${edited} edited here`} />}
        <span class="more-count">{options.length}</span>
      </button>
      {isOpen && <Rows options={options} />}
    </>
  );
}

/** The meaning of the option that the hand or the focus is on. */
function InfoLine() {
  const info = useSelect((state) => state.info);
  return (
    <p class="info-line" aria-hidden="true">
      {info || "Point at an option to read what it does. Double-click its name to reset it."}
    </p>
  );
}

function Skeleton() {
  return (
    <div class="skeleton" aria-hidden="true">
      {[5, 3, 6].map((rows) => (
        <div class="section">
          <i class="bone is-title" />
          {Array.from({ length: rows }, (_, i) => <i class="bone" style={{ width: `${96 - ((i * 17) % 30)}%` }} />)}
        </div>
      ))}
    </div>
  );
}
