// Places on the garment where tests click.

import assert from "node:assert/strict";

/** The place in the window of an edge of a set of the model that a click there finds. */
export async function placeOf(preview, set) {
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
  for (const { x, y } of places) {
    await preview.page.mouse.move(x - 1, y);
    await preview.page.mouse.move(x, y);
    const isFound = (set) => preview.store.state.hovered?.sets.some(({ name }) => name === set);
    const found = preview.when(isFound, set, 1500).then(
      () => true,
      () => false,
    );
    if (await found) return { x, y };
  }
  assert.fail(`no edge of ${set} is found on the model`);
}
