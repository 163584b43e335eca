// What cloth is made of: its colour or an image, how rough it is, its weave or a normal map.

import { useRef } from "preact/hooks";
import { keptImage } from "../../state/images";
import type { Fabric, Weave } from "../../view/api";
import { IMAGE_SIZE, ROUGHNESS } from "../../view/shade/fabric";
import { Button, IconButton, Segments } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { PopButton, usePopover } from "../controls/Menu";
import { NumberField } from "../controls/NumberField";
import { lengthUnit, neat } from "../controls/numbers";

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
  return (
    <PopButton label="Fabric" hint="Colour, images, roughness and weave of the cloth" content={(anchor) => <Fabrics anchor={anchor} />}>
      <Icon name="fabric" />
    </PopButton>
  );
}

function Fabrics({ anchor }: { anchor: { current: HTMLElement | null } }) {
  const store = useStore();
  const fabric = useSelect(({ settings }) => settings.fabric);
  const garment = useSelect((state) => state.garment);
  const box = useRef<HTMLDivElement>(null);
  usePopover(box, anchor);
  const unit = lengthUnit(garment);
  const change = (changed: Partial<Fabric>) => store.settings({ fabric: { ...store.state.settings.fabric, ...changed } });
  const isOwn = fabric.colour === null && fabric.roughness === null && !fabric.image;
  return (
    <div class="menu fabric" popover="manual" role="group" aria-label="Fabric of the cloth" ref={box}>
      <label class="fabric-own">
        <input
          type="checkbox"
          checked={isOwn}
          onChange={() => change(isOwn ? { colour: COLOURS[1].colour } : { colour: null, roughness: null, image: null })}
        />
        {garment?.looks?.length ? "Model’s own material" : "Plain grey"}
      </label>
      <span class="fabric-colours" role="group" aria-label="Colour">
        {COLOURS.map(({ name, colour }) => (
          <button
            type="button"
            key={colour}
            class="fabric-chip"
            aria-label={name}
            aria-pressed={fabric.colour === colour && !fabric.image}
            title={name}
            style={{ background: colour }}
            onClick={() => change({ colour, image: null })}
          />
        ))}
        <input
          type="color"
          class="fabric-chip"
          aria-label="Another colour"
          title="Another colour"
          value={fabric.colour ?? "#a7b0be"}
          onInput={({ currentTarget }) => change({ colour: currentTarget.value, image: null })}
        />
      </span>
      <ImageRow label="Image" hint="An image in place of the colour" image={fabric.image} change={(image) => change({ image })} />
      <ImageRow label="Normal map" hint="A normal map in place of the weave" image={fabric.relief} change={(relief) => change({ relief })} />
      {(fabric.image || fabric.relief) && (
        <div class="fabric-row">
          <span>Size of the {fabric.image ? "image" : "map"}</span>
          <NumberField
            label="Size of the image"
            value={neat((fabric.size ?? IMAGE_SIZE) / unit.metres)}
            unit={unit.word}
            metres={unit.metres}
            step={0.1}
            fine={0.01}
            clamp={(size) => Math.min(1e4, Math.max(0.01, size))}
            change={(size) => change({ size: size * unit.metres })}
          />
        </div>
      )}
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
      {!fabric.relief && <Segments label="Weave" value={fabric.weave} choices={WEAVES} change={(weave) => change({ weave })} />}
      <p class="fabric-note">For this view alone: the browser keeps it, and nothing of it is saved.</p>
    </div>
  );
}

interface ImageRowProps {
  label: string;
  hint: string;
  image: string | null | undefined;
  change(image: string | null): void;
}

/** An image of a file, which the browser keeps. */
function ImageRow({ label, hint, image, change }: ImageRowProps) {
  const store = useStore();
  const field = useRef<HTMLInputElement>(null);
  const take = async (input: HTMLInputElement) => {
    const file = input.files?.[0];
    // The same file may be chosen again.
    input.value = "";
    if (!file) return;
    await keptImage(file).then(change, () => store.toast({ text: `${file.name} is no image that the browser reads. Use PNG, JPEG or WebP` }));
  };
  return (
    <div class="fabric-row">
      <span>{label}</span>
      <input type="file" hidden accept="image/*" aria-label={`File of the ${label.toLowerCase()}`} ref={field} onChange={({ currentTarget }) => void take(currentTarget)} />
      {image && <img class="fabric-image" src={image} alt="" />}
      <Button class="is-small" hint={hint} act={() => field.current?.click()}>{image ? "Replace…" : "Choose…"}</Button>
      {image && <IconButton label={`Remove the ${label.toLowerCase()}`} icon="close" class="is-small" act={() => change(null)} />}
    </div>
  );
}
