// Bars over the view: which meshes, how they are shaded, and what is drawn over them.

import type { Shading } from "../../view/api";
import { IconButton, Segments, Select, Toggle } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { showAlone, SIDE_NAMES, toggleRole } from "../../state/keys";
import { FabricButton } from "./FabricButton";
import { PictureButton } from "./PictureButton";
import { paintedChoices, QUALITIES, ROLE_NAMES } from "../../state/settings";
import { ROLES } from "../../view/layout";

const SHADINGS: { value: Shading; label: string; hint: string }[] = [
  { value: "cloth", label: "Cloth", hint: "Plain cloth" },
  { value: "faceSets", label: "Face sets", hint: "A colour for each face set" },
  { value: "checker", label: "UV checker", hint: "A checker in the UV set" },
  { value: "values", label: "Heat", hint: "A painted primvar or a quality figure, as colour" },
];

export function ToolBar() {
  const store = useStore();
  const settings = useSelect((state) => state.settings);
  return (
    <div class="tool-bar" role="toolbar" aria-label="Meshes and shading">
      <span class="roles" role="group" aria-label="Meshes">
        {ROLES.map((role, i) => (
          <button
            type="button"
            key={role}
            class="role"
            aria-pressed={settings.roles.includes(role)}
            title={`Show or hide (${i + 1}); double-click to show it alone`}
            onClick={() => toggleRole(store, i)}
            onDblClick={() => showAlone(store, i)}
          >
            <Icon name={settings.roles.includes(role) ? "eye" : "hidden"} />
            {ROLE_NAMES[role]}
          </button>
        ))}
      </span>
      <BodyButton />
      <Segments
        label="Layout"
        value={settings.layout}
        choices={[
          { value: "large", label: "One large", icon: "large", hint: "One mesh large, the others beside it (G for the next)" },
          { value: "side", label: "Side by side", icon: "side" },
          { value: "over", label: "Over one another", icon: "over" },
        ]}
        change={(layout) => store.settings({ layout })}
      />
      <Segments label="Shading" value={settings.shading} choices={SHADINGS} change={(shading) => store.settings({ shading })} />
      {settings.shading === "cloth" && <FabricButton />}
      {settings.shading === "values" && <HeatSelect />}
      <Levels />
    </div>
  );
}

/** Shows the body under the garment, where there is one. */
function BodyButton() {
  const store = useStore();
  const body = useSelect(({ garment }) => garment?.body ?? null);
  const on = useSelect(({ settings }) => settings.body);
  if (body === null) return null;
  return (
    <button type="button" class="role" aria-pressed={on} title={`Show or hide ${body}`} onClick={() => store.settings({ body: !on })}>
      Body
    </button>
  );
}

/** The levels of detail, where the recipe has some. */
function Levels() {
  const store = useStore();
  const count = useSelect(({ document }) => Number(document.merged.lod?.levels ?? 1));
  const level = useSelect(({ document }) => document.level);
  if (count < 2) return null;
  return (
    <Segments
      label="Level of detail"
      value={level}
      choices={Array.from({ length: count }, (_, number) => ({
        value: number,
        label: `LOD${number}`,
        hint: number === 0 ? "The garment as it is simulated" : "The meshes of this level, without cloth",
      }))}
      change={(level) => store.command({ type: "level", level })}
    />
  );
}

function HeatSelect() {
  const store = useStore();
  const garment = useSelect((state) => state.garment);
  const values = useSelect(({ settings }) => settings.values);
  const options = (choices: { name: string; label: string }[]) =>
    choices.map(({ name, label }) => ({ value: name, label }));
  return (
    <Select
      label="Heat of"
      value={values ?? ""}
      groups={[
        { label: "Painted", choices: options(paintedChoices(garment)) },
        { label: "Simulation mesh", choices: options(QUALITIES) },
      ]}
      change={(values) => store.settings({ values })}
    />
  );
}

/** What is drawn or not: a setting, its icon's name too, with its words. */
const DRAWN: ["wires" | "edgeSets" | "flat" | "shadows", string, string][] = [
  ["wires", "Wires", "Edges of the mesh (W)"],
  ["edgeSets", "Edge sets", "Edge sets and seams, each in its colour"],
  ["flat", "Flat panels", "The UV panels, flat; of the large mesh, with the mesh in space beside them"],
  ["shadows", "Shadows", "Layers shade one another, once the view is at rest"],
];

export function SideBar() {
  const store = useStore();
  const settings = useSelect((state) => state.settings);
  const { flat, layout, smooth, symmetric } = settings;
  const mirror = useSelect(({ garment }) => garment?.mirror);
  const isolated = useSelect((state) => state.isolated);
  const split = useSelect((state) => state.split);
  const isPainting = useSelect((state) => state.brush !== null);
  return (
    <div class="side-bar" role="toolbar" aria-orientation="vertical" aria-label="Drawing">
      {DRAWN.map(([name, label, hint]) => (
        <Toggle key={name} label={label} icon={name} hint={hint} on={settings[name]} change={(on) => store.settings({ [name]: on })} />
      ))}
      <hr />
      <Segments
        label="Display smoothing"
        value={smooth}
        choices={[0, 1, 2].map((level) => ({
          value: level,
          label: String(level),
          hint: `Subdivide ${level === 0 ? "not at all" : level === 1 ? "once" : "twice"} for display only`,
        }))}
        change={(smooth) => store.settings({ smooth })}
      />
      <hr />
      <span class="sides" role="group" aria-label="Look from">
        {SIDE_NAMES.map((side, i) => (
          <button
            type="button"
            class="icon-button is-small"
            key={side}
            aria-label={side}
            title={`Look from the ${side} (${i + 1 + ROLES.length})`}
            disabled={flat && layout !== "large"}
            onClick={() => store.view?.look(side)}
          >
            {side === "three-quarter" ? "¾" : side[0].toUpperCase()}
          </button>
        ))}
      </span>
      <Toggle
        label="Isolate"
        icon="isolate"
        hint="Show the panel where the pointer was, or the selected faces, alone (I)"
        on={isolated}
        change={() => store.toggleIsolated()}
      />
      <Toggle
        label="Split"
        icon="compare"
        hint="What is shown now stays on the left of a line, and edits go on on the right (X)"
        on={split !== null}
        change={() => store.toggleSplit()}
      />
      {mirror && (
        <Toggle
          label="Both sides"
          icon="mirror"
          hint={`Select and edit both sides of the garment at once; its plane is across ${mirror.axis} (Y)`}
          on={symmetric}
          change={(symmetric) => store.settings({ symmetric })}
        />
      )}
      <Toggle
        label="Paint"
        icon="brush"
        hint="Paint the density, the thickness of folds, pins (P)"
        on={isPainting}
        change={() => store.painter.toggle()}
      />
      <IconButton label="Frame" icon="frame" hint="Frame what is marked, or everything (F)" act={() => store.view?.frame()} />
      <PictureButton />
    </div>
  );
}
