// What cloth is made of: its colour, how rough it is, its weave.

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Fabric, Weave } from "../../view/api";
import { ROUGHNESS } from "../../view/shade/fabric";
import { Segments } from "../controls/controls";
import { useOutside, useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { place } from "../controls/Menu";

const COLOURS: { name: string; colour: string }[] = [
  { name: "Chalk", colour: "#ecebe6" },
  { name: "Linen", colour: "#cdbb9c" },
  { name: "Camel", colour: "#b08250" },
  { name: "Olive", colour: "#666b47" },
  { name: "Denim", colour: "#4f6d94" },
  { name: "Navy", colour: "#2a3550" },
  { name: "Wine", colour: "#7d2f3a" },
  { name: "Black", colour: "#2b2c30" },
];

const WEAVES: { value: Weave; label: string; hint: string }[] = [
  { value: "none", label: "None", hint: "Smooth" },
  { value: "plain", label: "Plain", hint: "Plain weave" },
  { value: "twill", label: "Twill", hint: "Twill, with ribs aslant" },
  { value: "knit", label: "Knit", hint: "Plain knit" },
];

export function FabricButton() {
  const fabric = useSelect(({ settings }) => settings.fabric);
  const [isOpen, setOpen] = useState(false);
  const wrap = useRef<HTMLSpanElement>(null);
  const button = useRef<HTMLButtonElement>(null);
  useOutside(wrap, () => setOpen(false));
  return (
    <span class="menu-wrap" ref={wrap} onKeyDown={(event) => {
      if (event.key !== "Escape" || !isOpen) return;
      event.stopPropagation();
      setOpen(false);
      button.current?.focus();
    }}>
      <button
        type="button"
        ref={button}
        class="icon-button"
        aria-label="Fabric"
        aria-expanded={isOpen}
        title="Colour, roughness and weave of the cloth"
        onClick={() => setOpen(!isOpen)}
      >
        <Icon name="fabric" />
      </button>
      {isOpen && <Fabrics fabric={fabric} anchor={button} />}
    </span>
  );
}

function Fabrics({ fabric, anchor }: { fabric: Fabric; anchor: { current: HTMLElement | null } }) {
  const store = useStore();
  const hasLooks = useSelect(({ garment }) => (garment?.looks ?? []).length > 0);
  const box = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    if (!box.current || !anchor.current) return;
    box.current.showPopover();
    place(box.current, anchor.current.getBoundingClientRect());
  }, []);
  const change = (changed: Partial<Fabric>) => store.settings({ fabric: { ...fabric, ...changed } });
  return (
    <div class="menu fabric" popover="manual" role="group" aria-label="Fabric of the cloth" ref={box}>
      <label class="fabric-own">
        <input
          type="checkbox"
          checked={fabric.colour === null && fabric.roughness === null}
          onChange={({ currentTarget }) =>
            change(currentTarget.checked ? { colour: null, roughness: null } : { colour: COLOURS[1].colour })
          }
        />
        {hasLooks ? "Model’s own material" : "Plain grey"}
      </label>
      <span class="fabric-colours" role="group" aria-label="Colour">
        {COLOURS.map(({ name, colour }) => (
          <button
            type="button"
            key={colour}
            class="fabric-chip"
            aria-label={name}
            aria-pressed={fabric.colour === colour}
            title={name}
            style={{ background: colour }}
            onClick={() => change({ colour })}
          />
        ))}
        <input
          type="color"
          class="fabric-chip"
          aria-label="Another colour"
          title="Another colour"
          value={fabric.colour ?? "#a7b0be"}
          onInput={({ currentTarget }) => change({ colour: currentTarget.value })}
        />
      </span>
      <label class="fabric-row">
        Roughness
        <input
          type="range"
          min={0}
          max={1}
          step={0.01}
          value={fabric.roughness ?? ROUGHNESS}
          onInput={({ currentTarget }) => change({ roughness: Number(currentTarget.value) })}
        />
      </label>
      <Segments label="Weave" value={fabric.weave} choices={WEAVES} change={(weave) => change({ weave })} />
      <p class="fabric-note">For this view alone: nothing of it is saved.</p>
    </div>
  );
}
