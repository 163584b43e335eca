// Places of the names of flat panels.

import type { Box } from "../../view/api";

/** Height of a line, mean width of a letter, and the least gap to a panel. [CSS pixels] */
const LINE = 14;
const LETTER = 6.4;
const GAP = 3;
/** A panel that is narrower has no name until the view is closer. */
const LEAST = 24;

interface Label extends Box {
  name: string;
  /** The words in lines. */
  text: string;
}

/**
 * A place for the name of each panel: above, below or beside it where nothing else is, or else in it where there is room.
 * Names without a place are left out until the view is closer. Large panels come first.
 */
export function placed(panels: ({ name: string } & Box)[], within: Box, words: (name: string) => string): Label[] {
  const labels: Label[] = [];
  const seen = panels.filter((panel) => overlap(panel, within));
  const named = seen.filter(({ width }) => width >= LEAST).sort((a, b) => b.width * b.height - a.width * a.height);
  for (const panel of named) {
    const { name, x, y } = panel;
    const line = words(name);
    const [middle, centre] = [x + panel.width / 2, y + panel.height / 2];
    const width = LETTER * line.length;
    const beside = [
      at(line, middle, y - GAP - LINE / 2),
      at(line, middle, y + panel.height + GAP + LINE / 2),
      at(line, x + panel.width + GAP + width / 2, centre),
      at(line, x - GAP - width / 2, centre),
    ];
    const inside = at(inLines(line, panel.width), middle, centre);
    const isFree = (place: Box) => holds(within, place) && !labels.some((other) => overlap(place, other));
    const isBare = (place: Box) => !seen.some((other) => other !== panel && overlap(place, other));
    const place = beside.find((each) => isFree(each) && isBare(each)) ?? (holds(panel, inside) && isFree(inside) && inside);
    if (place) labels.push({ name, ...place });
  }
  return labels;
}

/** A text around a place. */
function at(text: string, x: number, y: number): Box & { text: string } {
  const lines = text.split("\n");
  const [width, height] = [LETTER * Math.max(...lines.map(({ length }) => length)), LINE * lines.length];
  return { text, x: x - width / 2, y: y - height / 2, width, height };
}

/** Words in lines of a width, where they have room. */
function inLines(words: string, width: number): string {
  return words.split(" ").reduce((lines, word) => {
    const last = lines.slice(lines.lastIndexOf("\n") + 1);
    return `${lines}${LETTER * (last.length + 1 + word.length) <= width ? " " : "\n"}${word}`;
  });
}

const overlap = (a: Box, b: Box) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

const holds = (a: Box, b: Box) => a.x <= b.x && b.x + b.width <= a.x + a.width && a.y <= b.y && b.y + b.height <= a.y + a.height;
