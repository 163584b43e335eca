// One option of the recipe: its label, its control, and the way back to its upstream value.

import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import type { Fault, Option, Value } from "../../server/protocol";
import { fitting, labelOf, valueAt } from "../../state/recipe";
import { NumberField, Segments, Select, Slider, Switch, type Range } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { neat, niceStep, rounded, snapped, unitOf } from "../controls/numbers";
import { SetChips } from "./SetChips";
import { Words } from "../controls/Words";

/** Ranges wider than this have no slider, which could not hit a value. */
const WIDEST = 10_000;

const NONE: Fault[] = [];

interface RowProps {
  option: Option;
  /** Key with the operator's name, such as `seam.side.width`. */
  full: string;
}

export function OptionRow({ option, full }: RowProps) {
  const store = useStore();
  const id = useId();
  const edited = useSelect(({ document }) => valueAt(document.edits, full) !== undefined);
  const faults = useSelect(({ placed }) => placed.at.get(full) ?? NONE);
  const label = labelOf(option);
  const meaning = option.meaning.charAt(0).toUpperCase() + option.meaning.slice(1);
  const hint = `${meaning}${option.unit ? ` [${option.unit}]` : ""}`;
  const explain = () => store.state.info !== hint && store.update({ info: hint });
  return (
    <div
      class={`option ${option.domain.type === "names" ? "is-tall" : ""} ${edited ? "is-edited" : ""}`}
      data-key={full}
      onPointerEnter={explain}
      onFocusIn={explain}
    >
      <span class="option-label" title={`${hint}\n${full}`} onDblClick={() => edited && store.reset(full)}>
        {edited && <i class="edited-dot" title="Edited here" />}
        {label}
      </span>
      <Control option={option} full={full} label={label} describedBy={id} invalid={faults.length > 0} />
      <button
        type="button"
        class="reset"
        aria-label={`Reset ${label}`}
        title="Back to the garment's value or the default"
        disabled={!edited}
        onClick={() => store.reset(full)}
      >
        <Icon name="reset" />
      </button>
      <span id={id} class="option-notes">
        <span class="hidden">{hint}</span>
        <Faults faults={faults} />
      </span>
    </div>
  );
}

export function Faults({ faults }: { faults: Fault[] }): ComponentChildren {
  return faults.map(({ text, remedy }) => (
    <span class="fault" role="alert">
      <Words text={text} />
      {remedy && (
        <span class="remedy">
          <Words text={remedy} />
        </span>
      )}
    </span>
  ));
}

interface ControlProps extends RowProps {
  label: string;
  describedBy: string;
  invalid: boolean;
}

function Control({ option, full, ...described }: ControlProps) {
  const store = useStore();
  const value = useSelect(({ document }) => valueAt(document.merged, full)) ?? option.default;
  const primvars = useSelect(({ garment }) => garment?.primvars) ?? [];
  const set = (changed: Value) => store.set(full, changed);
  const { domain } = option;
  switch (domain.type) {
    case "flag":
      return <Switch {...described} on={value === true} change={set} />;
    case "choice": {
      const choices = domain.values.map((each) => ({ value: each, label: each }));
      return <Segments {...described} value={String(value)} choices={choices} change={set} />;
    }
    case "name": {
      const names = fitting(primvars, domain.of).map(({ name }) => name);
      const all = value === "" || names.includes(String(value)) ? names : [String(value), ...names];
      const choices = [{ value: "", label: "none" }, ...all.map((name) => ({ value: name, label: name }))];
      return <Select {...described} value={String(value)} groups={[{ choices }]} change={set} />;
    }
    case "names":
      if (domain.of === "operator") return null;
      return <SetChips {...described} of={domain.of} names={Array.isArray(value) ? value : []} change={set} />;
    default:
      return <NumberControl option={option} full={full} value={Number(value)} {...described} />;
  }
}

function NumberControl({ option, full, value, ...described }: ControlProps & { value: number }) {
  const store = useStore();
  const garment = useSelect((state) => state.garment);
  const used = useSelect(({ products }) => products.sim?.lengths[full] ?? products.render?.lengths[full]);
  const { domain } = option;
  if (domain.type !== "number" && domain.type !== "whole" && domain.type !== "length") return null;
  const range = rangeOf(domain);
  const known = domain.type === "length" ? domain.auto : null;
  const auto = used ?? known;
  const clamp = (typed: number) => {
    const number = domain.type === "whole" ? Math.round(typed) : typed;
    // A slider's end is no limit of a length.
    if (domain.type === "length") return domain.least < 0 ? number : Math.max(domain.least, number);
    return Math.min(domain.most, Math.max(domain.least, number));
  };
  return (
    <span class="number-control">
      {range.most - range.least <= WIDEST * range.step && (
        <Slider
          {...described}
          value={value}
          range={range}
          ghost={value === 0 ? auto : null}
          change={(changed) => changed !== value && store.set(full, changed, "continuous")}
        />
      )}
      <NumberField
        {...described}
        value={value}
        unit={unitOf(option.unit, garment)}
        step={range.step}
        clamp={clamp}
        auto={auto === null ? null : rounded(auto)}
        change={(changed, how) => store.set(full, changed, how)}
      />
    </span>
  );
}

function rangeOf(domain: { type: string; least: number; most: number; step?: number }): Range {
  if (domain.type === "whole") return { least: domain.least, most: domain.most, step: 1 };
  if (domain.type === "number") return { least: domain.least, most: domain.most, step: neat(domain.step ?? 1) };
  const step = niceStep(domain.most - domain.least);
  return { least: snapped(domain.least, step), most: snapped(domain.most, step), step };
}
