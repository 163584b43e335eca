// A drawn cross-section through a seam or a fold.

import type { Fields, KindName } from "../../server/options";
import { rounded, type LengthUnit } from "../controls/numbers";
import { foldSection, knots, seamSection, smoothPath, type Point, type Section } from "./section";

interface Size {
  width: number;
  height: number;
  /** Room beside the drawing, for figures. */
  margin: number;
}

const CARD: Size = { width: 304, height: 92, margin: 16 };
const MENU: Size = { width: 88, height: 34, margin: 4 };

export interface ProfileProps {
  kind: KindName;
  fields: Fields;
  /** The length that 0 stands for. [mesh units] */
  auto: number;
  /** Length of the second layer of a fold; by default it suits the thickness. [mesh units] */
  reach?: number;
}

const SECTIONS: Record<KindName, (props: ProfileProps) => Section> = {
  seam: ({ fields, auto }) => seamSection(fields, auto),
  fold: ({ fields, auto, reach }) => foldSection(fields, auto, reach),
};

const sectionOf = (props: ProfileProps): Section => SECTIONS[props.kind](props);

/** The drawing of a card, with figures. Both axes have one scale, so that it is true. */
export function Profile({ unit, isOff, ...props }: ProfileProps & { unit: LengthUnit; isOff: boolean }) {
  const section = sectionOf(props);
  const { scale, place } = placing(section, CARD);
  return (
    <svg
      class={`profile ${isOff ? "is-off" : ""}`}
      viewBox={`0 0 ${CARD.width} ${CARD.height}`}
      role="img"
      aria-label={`Cross-section: ${section.measures.map(({ key, ...ends }) => `${WORDS[key]} ${length(ends, unit)}`).join(", ")}`}
      data-scale={scale}
      data-origin={place([0, 0]).join(" ")}
    >
      <Cloth section={section} place={place} hasBody />
      {section.measures.map(({ key, from, to }) => (
        <Measure key={key} from={place(from)} to={place(to)} text={length({ from, to }, unit)} />
      ))}
    </svg>
  );
}

const WORDS: Record<string, string> = { width: "width", normalOffset: "height of the centre", thickness: "thickness" };

const length = ({ from, to }: { from: Point; to: Point }, { word, size }: LengthUnit): string =>
  `${rounded((to[0] - from[0] + (to[1] - from[1])) / size)} ${word}`;

/** The drawing of a menu. */
export function SmallProfile(props: ProfileProps) {
  const section = sectionOf(props);
  const { place } = placing(section, MENU);
  return (
    <svg class="profile is-small" viewBox={`0 0 ${MENU.width} ${MENU.height}`} aria-hidden="true">
      <Cloth section={section} place={place} />
    </svg>
  );
}

interface ClothProps {
  section: Section;
  place(point: Point): Point;
  /** Whether the inside of the garment is shaded. */
  hasBody?: boolean;
}

function Cloth({ section, place, hasBody }: ClothProps) {
  const path = smoothPath(section.cloth.map(place));
  const [a, b] = section.before.map(place);
  return (
    <>
      {hasBody && <path class="profile-before" d={`M${a.join(" ")}L${b.join(" ")}`} />}
      <path class="profile-cloth" d={path} />
    </>
  );
}

/** An arrow between two places with a figure. Lengths across are measured below the drawing. */
function Measure({ from, to, text }: { from: Point; to: Point; text: string }) {
  const isAcross = from[1] === to[1];
  const y = CARD.height - 6;
  const [a, b]: [Point, Point] = isAcross ? [[from[0], y - 10], [to[0], y - 10]] : [from, to];
  const ticks = isAcross ? `M${a.join(" ")}v-4v8m0-4H${b[0]}m0-4v8` : `M${a.join(" ")}V${b[1]}`;
  const isRight = a[0] > CARD.width - LABEL;
  const anchor = isAcross ? "middle" : isRight ? "end" : "start";
  const at: Point = isAcross ? [(a[0] + b[0]) / 2, y + 2] : [a[0] + (isRight ? -6 : 6), Math.min(a[1], b[1]) - 8];
  return (
    <>
      <path class="profile-measure" d={ticks} />
      <text class="profile-text" x={at[0]} y={at[1]} text-anchor={anchor}>{text}</text>
    </>
  );
}

/** Room that a figure needs. [pixels] */
const LABEL = 80;
/** Room below for the figure of a width. [pixels] */
const BELOW = 20;

/** The place of points in a drawing, which the section fills. */
function placing({ cloth, measures }: Section, { width, height, margin }: Size) {
  const [xs, ys] = [0, 1].map((axis) => knots(cloth).map((point) => point[axis]));
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  const [low, high] = [Math.min(...ys), Math.max(...ys)];
  const below = height > BELOW * 2 && measures.some(({ key }) => key === "width") ? BELOW : 0;
  const room = height - 2 * margin - below;
  const scale = Math.min((width - margin) / (right - left || 1), room / (high - low || Number.MIN_VALUE));
  const x = width / 2 - (scale * (left + right)) / 2;
  const y = margin + room / 2 + (scale * (low + high)) / 2;
  const place = ([px, py]: Point): Point => [x + scale * px, y - scale * py];
  return { scale, place };
}
