// Places on the garment where tests click.

import assert from "node:assert/strict";

/** The place in the window of an edge of a set of the model that a click there finds. */
export async function placeOf(preview, set) {
  await preview.isStill();
  const places = await preview.evaluate(
    (name) => {
      const { sets, numbers } = observed.elements.model;
      const { offset, length } = sets.find((set) => set.name === name);
      const box = document.querySelector("canvas").getBoundingClientRect();
      const found = [];
      for (let i = offset; i < offset + length; i += 2) {
        const ends = [numbers[i], numbers[i + 1]].map((point) => preview.view.project("model", point));
        if (ends.includes(null)) continue;
        const [a, b] = ends;
        // Long edges are seen from the front.
        const way = Math.hypot(a.x - b.x, a.y - b.y);
        found.push({ x: box.x + (a.x + b.x) / 2, y: box.y + (a.y + b.y) / 2, way });
      }
      return found.sort((a, b) => b.way - a.way).slice(0, 12);
    },
    set,
  );
  for (const place of places) {
    if (await finds(preview, set, place)) return place;
  }
  assert.fail(`no edge of ${set} is found on the model`);
}

/** Moves the pointer off the canvas and then to a place in the window: what a slow machine finds late is of the place before. */
export async function pointAt(preview, { x, y }) {
  await preview.page.mouse.move(1, 1);
  await preview.when(() => preview.store.state.hovered === null);
  await preview.page.mouse.move(x, y);
}

/** Whether the pointer finds the set at a place. */
async function finds(preview, set, { x, y }) {
  await pointAt(preview, { x, y });
  const isFound = ([set, x, y]) => {
    const { hovered } = preview.store.state;
    const box = document.querySelector("canvas").getBoundingClientRect();
    const isHere = hovered && Math.hypot(box.x + hovered.x - x, box.y + hovered.y - y) < 1;
    return isHere && hovered.sets.some(({ name }) => name === set);
  };
  return preview.when(isFound, [set, x, y], 3000).then(
    () => true,
    () => false,
  );
}
