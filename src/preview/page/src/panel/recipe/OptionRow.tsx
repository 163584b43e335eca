// One option of the recipe: its label, its control, and the way back to its upstream value.

import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import type { Value } from "../../server/options";
import type { Fault, Option } from "../../server/protocol";
import { fitting, labelOf, valueAt } from "../../state/recipe";
import { wordsOf } from "../../state/selection";
import { isMixed, keysWith } from "../../state/cards";
import { Icon } from "../controls/icons";
import { MenuButton, type MenuItem } from "../controls/Menu";
import { IconButton, Segments, Select, Switch } from "../controls/controls";
import { NumberField } from "../controls/NumberField";
import { Slider } from "../controls/Slider";
import { useSelect, useStore } from "../controls/hooks";
import { rounded } from "../controls/numbers";
import { clamped, numberOption, setNumber } from "./numberOption";
import { SetChips } from "./SetChips";
import { TextField, WordChoice } from "../controls/TextField";
import { Words } from "../controls/Words";

/** Ranges wider than this have no slider, which could not hit a value. */
const WIDEST = 10_000;

/** More words than this are a menu. */
const MOST_SEGMENTS = 3;
/** A value that no option has. */
const MIXED = "\0mixed";

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
  // Sets are those of one card.
  const mixed = useSelect((state) => option.domain.type !== "sets" && isMixed(state, full, option.default));
  const reset = () => store.reset(...(option.domain.type === "sets" ? [full] : keysWith(store.state, full)));
  const label = labelOf(option);
  const hint = `${option.meaning}${option.unit ? ` [${option.unit}]` : ""}`;
  const explain = () => store.state.info !== hint && store.update({ info: hint });
  return (
    <div
      class={`option ${option.domain.type === "sets" ? "is-tall" : ""} ${edited ? "is-edited" : ""}`}
      data-key={full}
      onPointerEnter={explain}
      onFocusIn={explain}
    >
      <span class="option-label" title={`${hint}\n${full}`} onDblClick={() => edited && reset()}>
        {edited && <i class="edited-dot" title="Edited here" />}
        {label}
        {mixed && <span class="mixed" title="The selected cards differ"> mixed</span>}
      </span>
      <Control option={option} full={full} mixed={mixed} label={label} describedBy={id} invalid={faults.length > 0} />
      <IconButton label={`Reset ${label}`} icon="reset" hint="Back to the garment's value or the default" disabled={!edited} class="reset" act={reset} />
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
  /** Whether cards that are edited together differ. */
  mixed: boolean;
}

function Control({ option, full, ...described }: ControlProps) {
  const store = useStore();
  const value = useSelect(({ document }) => valueAt(document.merged, full)) ?? option.default;
  const set = (changed: Value) =>
    store.setAll(keysWith(store.state, full).map((key) => ({ key, value: changed })));
  const { domain } = option;
  switch (domain.type) {
    case "flag":
      return <Switch {...described} on={value === true} change={set} />;
    case "choice": {
      const choices = domain.words.map((each) => ({ value: each, label: each }));
      if (choices.length > MOST_SEGMENTS) {
        return <Select {...described} value={String(value)} groups={[{ choices }]} change={set} />;
      }
      return <Segments {...described} value={String(value)} choices={choices} change={set} />;
    }
    case "uvSet":
    case "weights":
      return <NameSelect value={String(value)} of={domain.type} change={set} {...described} />;
    case "fabric":
      return <FabricSelect words={domain.words} value={String(value)} change={set} {...described} />;
    case "primPath":
      return <TextField {...described} value={String(value)} placeholder="/Body/hips" change={set} />;
    case "file":
      return <FileChoice {...described} value={String(value)} change={set} />;
    case "words": {
      const chosen = Array.isArray(value) ? value : [];
      return <WordChoice {...described} words={domain.words} chosen={chosen} change={set} />;
    }
    case "sets":
      return <SetChips {...described} of={domain.of} names={Array.isArray(value) ? value : []} change={(names) => store.set(full, names)} />;
    default:
      return <NumberControl option={option} full={full} {...described} />;
  }
}

interface NamedSelectProps {
  label: string;
  describedBy: string;
  invalid: boolean;
  /** Whether cards that are edited together differ. */
  mixed: boolean;
  value: string;
  change(value: string): void;
}

/** A primvar; as weights also a set or the selection. */
function NameSelect({ value, of, change, mixed, ...described }: NamedSelectProps & { of: "uvSet" | "weights" }) {
  const garment = useSelect((state) => state.garment);
  const selection = useSelect((state) => state.selection);
  const takesSets = of === "weights";
  const primvars = fitting(garment?.primvars ?? [], of).map(({ name }) => ({ value: name, label: name }));
  const sets = takesSets ? (garment?.sets ?? []).map(({ name }) => ({ value: name, label: wordsOf(name) })) : [];
  const isListed = mixed || value === "" || [...primvars, ...sets].some((each) => each.value === value);
  const first = [
    ...(mixed ? [{ value: MIXED, label: "mixed" }] : []),
    { value: "", label: "none" },
    ...(isListed ? [] : [{ value, label: wordsOf(value) }]),
    ...(takesSets && selection && selection.expression !== value ? [{ value: selection.expression, label: "The selection" }] : []),
  ];
  const groups = takesSets
    ? [{ choices: first }, { label: "Painted", choices: primvars }, { label: "Sets", choices: sets }]
    : [{ choices: [...first, ...primvars] }];
  const filled = groups.filter(({ choices }) => choices.length > 0);
  return <Select {...described} value={mixed ? MIXED : value} groups={filled} change={(name) => name !== MIXED && change(name)} />;
}

/** A path from a folder, if it leads into that or into one beside it. */
function fromFolder(path: string, folder: string): string {
  const above = folder.slice(0, folder.search(/[^/\\]+$/));
  if (above === "" || !path.startsWith(above)) return path;
  const below = path.startsWith(folder) && /[/\\]/.test(path.charAt(folder.length));
  return below ? path.slice(folder.length + 1) : `../${path.slice(above.length)}`;
}

/** A file that is typed, or chosen from those near the garment. */
function FileChoice({ value, change, ...described }: NamedSelectProps) {
  const store = useStore();
  const folder = useSelect(({ garment }) => garment?.folder) ?? "";
  const { files, isComplete } = useSelect((state) => state.bodies);
  const items = (): MenuItem[] => [
    ...(value === "" ? [] : [{ label: "none", pick: () => change("") }]),
    ...files.map((file) => ({ label: fromFolder(file, folder), pick: () => change(file) })),
  ];
  return (
    <span class="file-choice" title={value}>
      <TextField {...described} value={fromFolder(value, folder)} placeholder="body.usd" change={change} />
      <MenuButton label={`Files for ${described.label}`} hint="USD files with one mesh, in the garment's folder, below it and beside it" items={items} opens={() => store.send({ type: "bodies" })} empty={isComplete ? "No file with one mesh is near the garment" : "Looking for files with one mesh"}>
        <Icon name="down" />
      </MenuButton>
    </span>
  );
}

/** A fabric that every recipe has, or one of this recipe. */
function FabricSelect({ words, value, ...described }: NamedSelectProps & { words: string[] }) {
  const own = useSelect(({ document }) => document.merged.fabric) ?? {};
  const choices = (names: string[]) => names.map((name) => ({ value: name, label: name }));
  const known = [...Object.keys(own), ...words];
  const groups = [
    { choices: choices(known.includes(value) ? [] : [value]) },
    { label: "This recipe", choices: choices(Object.keys(own)) },
    { label: "Presets", choices: choices(words) },
  ];
  return <Select {...described} value={value} groups={groups.filter(({ choices }) => choices.length > 0)} />;
}

function NumberControl({ option, full, mixed, ...described }: ControlProps) {
  const store = useStore();
  useSelect((state) => JSON.stringify(numberOption(state, option, full)));
  const number = numberOption(store.state, option, full);
  if (!number) return null;
  const { value, auto, unit, metres, size, range } = number;
  const set = (typed: number, how: "step" | "continuous") => setNumber(store, option, full, size, typed, how);
  return (
    <span class="number-control">
      <NumberField
        {...described}
        value={value}
        mixed={mixed}
        unit={unit}
        metres={metres}
        step={range.step}
        fine={range.fine}
        clamp={(typed) => clamped(option.domain, typed)}
        auto={auto}
        autoText={auto === null ? undefined : rounded(auto)}
        change={set}
      />
      {range.most - range.least <= WIDEST * range.step && (
        <Slider
          {...described}
          value={value}
          range={range}
          ghost={value === 0 ? auto : null}
          change={(changed) => (changed !== value || mixed) && set(changed, "continuous")}
        />
      )}
    </span>
  );
}
