// Edge or face sets as chips, with a menu of those that may be added.

import type { SetInfo } from "../../server/protocol";
import { IconButton } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { MenuButton, type MenuItem } from "../controls/Menu";
import { wordsOf } from "../../state/selection";

const NONE: SetInfo[] = [];

/** A set that follows from the mesh, such as a piece of its borders. */
export const isDerived = ({ family }: SetInfo): boolean => family === "tailorDerived";

/** A name that can only be that of a set of the garment; the server reads all others as expressions. */
const isName = (text: string): boolean => /^\w+$/.test(text) && !/^(borders|uvSeams|creases|featureLines|edges|faces|points|uvShells)$/.test(text);

export function useSets(of: string[]): SetInfo[] {
  const sets = useSelect(({ garment }) => garment?.sets) ?? NONE;
  return sets.filter(({ kind }) => of.includes(kind));
}

/** The colour that a set has in the view. */
export function Swatch({ set }: { set: string | undefined }) {
  const store = useStore();
  // Colours may be new with a mesh or another theme.
  useSelect(({ drawn }) => drawn);
  useSelect(({ settings }) => settings.theme);
  return <i class="chip" style={{ background: (set && store.view?.colourOf(set)) || "var(--line-strong)" }} />;
}

interface SetChipsProps {
  label: string;
  describedBy: string;
  invalid: boolean;
  /** Kinds of elements. */
  of: string[];
  names: string[];
  change(names: string[]): void;
}

export function SetChips({ label, describedBy, invalid, of, names, change }: SetChipsProps) {
  const store = useStore();
  const sets = useSets(of);
  const selected = () => {
    const { selection } = store.state;
    const fits = selection && of.includes(selection.kind) && !names.includes(selection.expression);
    return fits ? [selection] : [];
  };
  const items = (): MenuItem[] => [
    ...selected().map(({ expression, count, kind }) => ({
      label: "The selection",
      detail: `${count} ${kind}s`,
      pick: () => {
        store.selector.end();
        change([...names, expression]);
      },
    })),
    ...sets
      .filter(({ name }) => !names.includes(name))
      .map(({ name, count, kind }) => ({
        label: wordsOf(name),
        detail: `${count} ${kind}s`,
        chip: store.view?.colourOf(name),
        pick: () => change([...names, name]),
        hover: (on: boolean) => store.highlight(on ? [name] : null),
      })),
  ];
  const isMissing = (name: string) => isName(name) && !sets.some((set) => set.name === name);
  const remove = (name: string) => {
    store.highlight(null);
    change(names.filter((each) => each !== name));
  };
  return (
    <span class="chips" role="group" aria-label={label} aria-describedby={describedBy} aria-invalid={invalid}>
      {names.map((name) => (
        <span
          key={name}
          class={`set-chip ${isMissing(name) ? "is-missing" : ""}`}
          title={isMissing(name) ? `${name} is not in the garment` : undefined}
          onPointerEnter={() => store.highlight([name])}
          onPointerLeave={() => store.highlight(null)}
        >
          <Swatch set={name} />
          <button type="button" class="set-chip-name" title={`Select ${wordsOf(name)}`} onClick={() => store.selector.take(name)}>
            {wordsOf(name)}
          </button>
          <IconButton label={`Remove ${wordsOf(name)}`} icon="close" class="is-small" act={() => remove(name)} />
        </span>
      ))}
      <MenuButton label={`Add to ${label}`} class="add-chip" items={items} empty="All sets are in">
        <Icon name="plus" />
        {names.length === 0 && "Add"}
      </MenuButton>
    </span>
  );
}
