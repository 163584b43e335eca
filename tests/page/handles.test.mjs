// Handles of a seam in the view: its width, its height and its side.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";

/** The shirt with the handles of its side seam. */
async function held(t, operator = "seam.side") {
  const preview = await show(t, sewnShirt(t), { isNew: true, viewport: SCREEN });
  await preview.openCard(operator);
  await preview.page.locator(".knob").first().waitFor();
  await preview.quiet();
  await preview.isStill();
  return preview;
}

/** Drags a handle away from the seam. Returns what is written beside the pointer meanwhile. */
async function pull(preview, name, pixels) {
  const { mouse } = preview.page;
  const box = await preview.page.locator(`.knob.is-${name}`).boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const line = await preview.evaluate((name) => {
    const stem = document.querySelector(`.knob.is-${name}`).previousElementSibling.querySelector("line");
    const [dx, dy] = [stem.x2.baseVal.value - stem.x1.baseVal.value, stem.y2.baseVal.value - stem.y1.baseVal.value];
    return { x: dx / Math.hypot(dx, dy), y: dy / Math.hypot(dx, dy) };
  }, name);
  await mouse.move(x, y);
  await mouse.down();
  for (let step = 1; step <= 4; step++) await mouse.move(x + (line.x * pixels * step) / 4, y + (line.y * pixels * step) / 4);
  const words = await preview.page.locator(".knob-number").textContent();
  await mouse.up();
  return words;
}

const seam = async (preview) => (await preview.document()).merged.seam.side;

for (const [name, label, below] of [["width", "Width", 0], ["normalOffset", "Normal offset", -0.3]]) {
  test(`the handle of the ${name} is dragged as one step of undo, ten times finer with Shift`, async (t) => {
    const preview = await held(t);
    const before = await preview.meshes();
    let words;
    const dragged = await preview.after("render", async () => (words = await pull(preview, name, 48)));
    const value = (await seam(preview))[name];
    // A width of 0 is 5 mm.
    const from = below || 0.5;
    assert.ok(value > from, `${value}`);
    assert.equal(words, `${label} ${value} cm`);
    const sent = await preview.evaluate(() => observed.sent.filter(({ type }) => type === "edit"));
    assert.equal(new Set(sent.map(({ gesture }) => gesture)).size, 1);
    assert.deepEqual([dragged.sim, dragged.model], [before.sim, before.model]);
    assert.equal(await preview.page.locator(".knob-number").count(), 0, "the number ends with the drag");

    assert.deepEqual(await preview.after("render", () => preview.page.keyboard.press("Control+z")), before);
    assert.equal((await preview.document()).canUndo, false, "one drag is one step");
    await preview.page.keyboard.down("Shift");
    await preview.after("render", () => pull(preview, name, 48));
    await preview.page.keyboard.up("Shift");
    const fine = (await seam(preview))[name];
    const share = (fine - from) / (value - from);
    assert.ok(share > 0.05 && share < 0.2, `${fine} and ${value} from ${from}`);
    assertClean(preview);
  });
}

/** How far the points of the render mesh have moved to the left of the seam on the screen, in all. [pixels] */
const movedLeft = (preview, before) =>
  preview.evaluate((before) => {
    const { grip } = preview.store.state;
    return before.reduce((sum, place, point) => {
      const now = place && preview.view.project("render", point);
      return now ? sum + (now.x - place.x) * grip.left[0] + (now.y - place.y) * grip.left[1] : sum;
    }, 0);
  }, before);

const places = (preview) =>
  preview.evaluate(() => {
    const { grip } = preview.store.state;
    return Array.from({ length: preview.view.stats("render").points }, (_, point) => {
      const at = preview.view.project("render", point);
      return at && Math.hypot(at.x - grip.x, at.y - grip.y) < 40 ? at : null;
    });
  });

test("the arrow points to the left, and a click puts the seam on the other side", async (t) => {
  const preview = await held(t);
  const arrow = preview.page.locator(".knob-side");
  const before = await preview.meshes();
  const at = await places(preview);
  await preview.after("render", () => arrow.click());
  assert.equal((await seam(preview)).asymmetry, -1, "a seam on both sides goes to the left");
  assert.ok((await movedLeft(preview, at)) > 0, "the cloth beside it moves to where the arrow points");
  await preview.after("render", () => arrow.click());
  assert.equal((await seam(preview)).asymmetry, 1);
  await preview.after("render", () => preview.page.keyboard.press("Control+z"));
  assert.deepEqual(await preview.after("render", () => preview.page.keyboard.press("Control+z")), before);

  await preview.after("render", () => preview.set("seam.side.offset", 1));
  for (const side of ["left", "right", "left"]) {
    await preview.after("render", () => arrow.click());
    assert.equal((await seam(preview)).side, side, "rows beside the edges have a side of their own");
  }
  assertClean(preview);
});

test("a fold has a handle for its thickness, and a closed card has none", async (t) => {
  const preview = await held(t, "fold.neck");
  const before = await preview.meshes();
  await preview.after("render", () => pull(preview, "thickness", 30));
  assert.ok((await preview.document()).merged.fold.neck.thickness > 0.4);
  assert.deepEqual(await preview.after("render", () => preview.page.keyboard.press("Control+z")), before);
  await preview.card("fold.neck").locator(".card-title").click();
  await preview.page.locator(".knob").waitFor({ state: "detached" });
  assertClean(preview);
});

test("handles are on a place that is seen, and go where the pointer was", async (t) => {
  const preview = await held(t);
  const { page } = preview;
  const grip = () => preview.state((state) => state.grip);
  const first = await grip();
  await preview.evaluate(() => preview.view.look("side"));
  await preview.isStill();
  await preview.when((first) => preview.store.state.grip && preview.store.state.grip.x !== first.x, first);
  const second = await grip();
  // A place farther down on the same seam.
  const box = await page.locator("canvas").boundingBox();
  await page.mouse.move(box.x + second.x, box.y + second.y + 90, { steps: 4 });
  await preview.when((y) => preview.store.state.grip?.y > y + 40, second.y);

  // Elsewhere the view turns as before.
  const aim = await preview.evaluate(() => preview.view.aim().direction);
  await page.mouse.move(box.x + 200, box.y + 400);
  await page.mouse.down();
  await page.mouse.move(box.x + 260, box.y + 400, { steps: 3 });
  await page.mouse.up();
  assert.notDeepEqual(await preview.evaluate(() => preview.view.aim().direction), aim);
  assertClean(preview);
});
