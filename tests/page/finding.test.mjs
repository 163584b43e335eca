// Places are found: one mesh large, panels alone, seams brought into view, the camera that stays, and meshes that are stale.

import assert from "node:assert/strict";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { bareShirt, sewnShirt, variantSheet } from "./support/garments.mjs";
import { placeOf } from "./support/picking.mjs";
import { differing, inked } from "./support/png.mjs";

const label = (preview, role) => preview.page.locator(`.column-label[data-role="${role}"]`);

/** Waits for the picture of an action's end. */
async function pictureAfter(preview, act) {
  await act();
  await preview.quiet();
  return preview.picture();
}

/** The length of an edge of the model on the canvas, in the column of that mesh. [CSS pixels] */
const breadthOf = (preview, role) =>
  preview.evaluate((role) => {
    const places = Array.from({ length: 200 }, (_, i) => preview.view.project(role, i)).filter((place) => place !== null);
    const xs = places.map(({ x }) => x);
    return Math.max(...xs) - Math.min(...xs);
  }, role);

test("a new artist sees the render mesh large, and a click or a key makes another one large", async (t) => {
  const preview = await show(t, sewnShirt(t), { viewport: SCREEN, isNew: true });
  const { page } = preview;
  const settings = () => preview.state(({ settings }) => [settings.layout, settings.large]);
  assert.deepEqual(await settings(), ["large", "render"]);
  assert.ok((await breadthOf(preview, "render")) > 1.6 * (await breadthOf(preview, "model")), "it is the large one");
  const first = await preview.picture();
  assert.ok(inked(first, [0, 0.65]) > 0.05 && inked(first, [0.68, 0.92]) > 0.05, "both columns have a garment");

  await label(preview, "model").getByRole("button", { name: "Model" }).click();
  assert.deepEqual(await settings(), ["large", "model"]);
  assert.ok((await breadthOf(preview, "model")) > 1.6 * (await breadthOf(preview, "render")));
  await page.keyboard.press("g");
  assert.deepEqual(await settings(), ["large", "sim"]);
  await page.keyboard.press("g");
  assert.ok(differing(first, await preview.picture()) < 0.001, "all is as it was");

  // A mesh that is small is picked in its place.
  const { x, y } = await placeOf(preview, "side_seams");
  await page.mouse.click(x, y);
  await preview.when(() => preview.store.state.selection?.kind === "edge");
  assert.equal(await preview.state(({ clicked }) => clicked.role), "model");

  await page.getByRole("radiogroup", { name: "Layout" }).getByRole("radio", { name: "Side by side" }).check();
  await page.reload();
  await preview.isDrawn();
  assert.deepEqual(await settings(), ["side", "render"], "what was chosen is kept");
  assertClean(preview);
});

test("the camera keeps its target and direction in every layout", async (t) => {
  const preview = await show(t, sewnShirt(t), { viewport: SCREEN, isNew: true });
  const { page } = preview;
  const aim = () => preview.evaluate(() => preview.view.aim());
  const near = (a, b) => a.every((value, i) => Math.abs(value - b[i]) < 1e-4);
  const goThrough = async (words) => {
    const first = await aim();
    const steps = [{ layout: "side" }, { layout: "over" }, { flat: true }, { layout: "large" }, { flat: false, large: "sim" }];
    for (const step of [...steps, { large: "render" }]) {
      await preview.settings(step);
      await preview.isStill();
      const now = await aim();
      const what = `${words}: ${JSON.stringify(step)}`;
      assert.ok(near(first.target, now.target) && near(first.direction, now.direction), what);
      if (step.flat || (await preview.state(({ settings }) => settings.flat))) continue;
      const all = await preview.evaluate(() => [...Array(50).keys()].map((i) => preview.view.project("render", i)));
      if (words === "at first") assert.ok(!all.includes(null), `${what}: all of it is in view`);
    }
  };
  await goThrough("at first");
  await preview.isStill();
  const box = await page.locator("canvas").boundingBox();
  await page.mouse.move(box.x + 300, box.y + 300);
  await page.mouse.down();
  await page.mouse.move(box.x + 420, box.y + 330, { steps: 4 });
  await page.mouse.up();
  await page.mouse.wheel(0, -300);
  await preview.isStill();
  await goThrough("after a turn");
  assertClean(preview);
});

test("a new seam is flown to if it is out of view, and the camera stays if it is not", async (t) => {
  const preview = await show(t, bareShirt(t));
  const { keyboard } = preview.page;
  const aim = () => preview.evaluate(() => JSON.stringify(preview.view.aim()));
  const select = async (expression) => {
    await keyboard.press("e");
    await keyboard.type(expression);
    await keyboard.press("Enter");
    await preview.when((text) => preview.store.state.selection?.expression === text, expression);
  };
  await select("borders.highest");
  const whole = await aim();
  await preview.after("render", () => keyboard.press("n"));
  assert.equal(await aim(), whole, "it is in view");
  // Ends the name of the new seam.
  await keyboard.press("Escape");

  // Near the neck, the hem is far below.
  await select("borders.highest");
  await keyboard.press("f");
  await keyboard.press("Escape");
  await preview.isStill();
  const box = await preview.page.locator("canvas").boundingBox();
  await preview.page.mouse.move(box.x + box.width / 6, box.y + box.height / 2);
  for (let i = 0; i < 5; i++) await preview.page.mouse.wheel(0, -240);
  await preview.isStill();
  const near = await aim();
  assert.notEqual(near, whole);
  await select("borders.lowest");
  const edges = await preview.state(({ selection }) => selection.elements.edges);
  await preview.after("render", () => keyboard.press("n"));
  assert.notEqual(await aim(), near, "the camera goes there");
  await preview.isStill();
  const places = await preview.evaluate((points) => points.map((point) => preview.view.project("model", point)), edges.flat());
  assert.ok(!places.includes(null), "all of the hem is in view");
  assertClean(preview);
});

test("undo after a new seam brings the selection back, and redo ends it", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { keyboard } = preview.page;
  const is = (text) => preview.when((text) => (preview.store.state.selection?.expression ?? null) === text, text);
  await keyboard.press("e");
  await keyboard.type("borders.highest");
  await keyboard.press("Enter");
  await is("borders.highest");
  await preview.after("render", () => keyboard.press("n"));
  await is(null);
  await preview.after("render", () => keyboard.press("Control+z"));
  await is("borders.highest");
  await preview.after("render", () => keyboard.press("Control+Shift+z"));
  await is(null);
  assert.deepEqual(await preview.cards(), ["seam.borders_highest"]);
  assertClean(preview);
});

test("a panel is shown alone in all meshes, and all again by Escape or I", async (t) => {
  const preview = await show(t, sewnShirt(t), { viewport: SCREEN });
  const { page } = preview;
  const thirds = [[0, 0.31], [0.32, 0.62], [0.63, 0.93]];
  const box = await page.locator("canvas").boundingBox();
  const whole = await preview.picture();
  // The middle of the front of the model.
  await page.mouse.move(box.x + 0.15 * box.width, box.y + 0.5 * box.height);
  await preview.when(() => preview.store.state.hovered?.role === "model");
  const alone = await pictureAfter(preview, () => page.keyboard.press("i"));
  for (const third of thirds) {
    const share = inked(alone, third) / inked(whole, third);
    assert.ok(share > 0.1 && share < 0.9, `a part of the mesh is left: ${share}`);
  }
  const back = await pictureAfter(preview, () => page.keyboard.press("Escape"));
  await page.mouse.move(box.x + 5, box.y + box.height - 5);
  assert.ok(differing(whole, back) < 0.01, "all is there again");

  // On the render mesh, the same panel.
  await page.mouse.move(box.x + 0.77 * box.width, box.y + 0.5 * box.height);
  await preview.when(() => preview.store.state.hovered?.role === "render");
  const other = await pictureAfter(preview, () => page.keyboard.press("i"));
  assert.ok(differing(alone, other) < 0.01, "a face of the render mesh finds its panel");
  assert.equal(await preview.state(({ isolated }) => isolated), true);
  // It holds for a mesh with other faces.
  await preview.after("render", () => preview.set("render.level", 0));
  const coarse = await preview.picture();
  assert.ok(inked(coarse, thirds[2]) < 0.95 * inked(whole, thirds[2]));
  await page.keyboard.press("i");
  assert.equal(await preview.state(({ isolated }) => isolated), false);
  await preview.quiet();
  assert.ok(inked(await preview.picture(), thirds[2]) > 0.95 * inked(whole, thirds[2]));

  // The faces of the selection.
  await page.keyboard.press("e");
  await page.keyboard.type("rings(borders.lowest)");
  await page.keyboard.press("Enter");
  await preview.when(() => preview.store.state.selection?.kind === "face");
  const rows = await pictureAfter(preview, () => page.getByRole("button", { name: "Isolate" }).click());
  for (const third of thirds) assert.ok(inked(rows, third) < 0.4 * inked(whole, third), "a row of faces is left");
  await page.getByRole("button", { name: "Show all" }).click();
  assert.equal(await preview.state(({ isolated }) => isolated), false);
  assertClean(preview);
});

test("a mesh whose build failed is marked stale, and nothing says that there are no warnings", async (t) => {
  const preview = await show(t, variantSheet(t), { viewport: SCREEN });
  const { page } = preview;
  const count = page.getByTestId("warning-count");
  await preview.evaluate(() => preview.store.settings({ figures: true }));
  for (const role of ["model", "sim", "render"]) {
    assert.match(await label(preview, role).getAttribute("class"), /is-current/);
  }
  // It is refused when it is built, as it has too many triangles.
  await preview.set("sim.maxEdgeLength", 0.0002);
  await label(preview, "sim").getByText("stale: the last build failed").waitFor();
  assert.match(await label(preview, "render").getAttribute("class"), /is-current/, "the render mesh is of this recipe");
  assert.doesNotMatch(await count.innerText(), /^No warnings/);
  assert.doesNotMatch(await page.locator(".warnings h3").innerText(), /none/);
  await page.keyboard.press("Control+z");
  await preview.when(() => document.querySelector(".column-label.is-stale") === null);
  await preview.set("render.level", 9);
  for (const role of ["sim", "render"]) await label(preview, role).getByText("stale: an option has an error").waitFor();
  assert.doesNotMatch(await count.innerText(), /^No warnings/);
  await page.keyboard.press("Control+z");
  await preview.when(() => document.querySelector(".column-label.is-stale") === null);
  assertClean(preview);
});

test("nothing says that there are no warnings before the first build has ended", async (t) => {
  const preview = await show(t, variantSheet(t), { viewport: SCREEN });
  const words = await preview.evaluate(() => {
    const { store } = preview;
    const { products } = store.state;
    const read = () => document.querySelector('[data-testid="warning-count"]').textContent;
    const known = read();
    store.update({ products: {} });
    return new Promise((resolve) =>
      requestAnimationFrame(() =>
        setTimeout(() => {
          const before = read();
          store.update({ products, progress: { sim: { step: "remesh", since: performance.now() } } });
          setTimeout(() => resolve({ known, before, during: read() }), 50);
        }, 50),
      ),
    );
  });
  assert.doesNotMatch(words.before, /No warnings/);
  assert.doesNotMatch(words.during, /No warnings/);
  assertClean(preview);
});

test("the strip tells the level that is written from the one that is only shown", async (t) => {
  const preview = await show(t, sewnShirt(t), { viewport: SCREEN });
  const brief = preview.page.locator('[data-brief="render"]');
  assert.match(await brief.innerText(), /written at level\s+1(?!.*shown at)/s);
  await preview.settings({ smooth: 1 });
  await brief.getByText("shown at 2").waitFor();
  assert.match(await brief.innerText(), /written at level\s+1/);
  assert.match(await label(preview, "model").innerText(), /\+1 for display/);
  assert.deepEqual((await preview.document()).edits, {});
  assertClean(preview);
});

test("the file that was saved last is proposed again", async (t) => {
  const garment = sewnShirt(t);
  const preview = await show(t, garment, { viewport: SCREEN });
  const { page } = preview;
  const dialog = page.getByRole("dialog", { name: "Save the edits" });
  const path = dialog.getByLabel("Path");
  await preview.after("render", () => preview.set("render.level", 0));
  await page.keyboard.press("Control+s");
  const file = join(dirname(garment), "mine.tailor");
  await path.fill(file);
  await preview.when((file) => preview.store.state.save?.path === file, file);
  await dialog.locator('button[type="submit"]').click();
  await dialog.waitFor({ state: "detached" });
  await page.keyboard.press("Control+s");
  assert.equal(await path.inputValue(), file);
  await dialog.getByRole("radio", { name: "USD layer" }).check();
  assert.match(await path.inputValue(), /tshirt_look\.usda$/);
  await dialog.getByRole("radio", { name: ".tailor file" }).check();
  assert.equal(await path.inputValue(), file);
  assertClean(preview);
});

test("toasts leave the bar of the selection free", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { page } = preview;
  await page.keyboard.press("e");
  await page.keyboard.type("uvSeams");
  await page.keyboard.press("Enter");
  const bar = page.getByRole("toolbar", { name: "Selection" });
  await bar.getByText("edges").first().waitFor();
  await preview.evaluate(() => {
    for (let i = 0; i < 3; i++) preview.store.toast({ text: `Saved ${"a long path ".repeat(8)}`, code: "usdtailor build" });
  });
  const boxes = [await bar.boundingBox(), await page.locator(".toasts").boundingBox()];
  assert.ok(boxes[1].height > 50 && boxes[1].y + boxes[1].height <= boxes[0].y, JSON.stringify(boxes));
  assertClean(preview);
});

test("a selection behind cloth is faint", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { page } = preview;
  await preview.settings({ roles: ["model"], wires: false });
  const yellow = ({ pixels, channels }) => {
    let count = 0;
    for (let at = 0; at < pixels.length; at += channels) {
      if (pixels[at] > 225 && pixels[at + 1] > 180 && pixels[at + 2] < 90) count += 1;
    }
    return count;
  };
  // Points in the middle of the back.
  const select = () =>
    preview.evaluate(() => {
      const all = observed.points.model;
      const range = (axis) => {
        const values = all.filter((_, i) => i % 3 === axis);
        return [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
      };
      const [[left, right], [back, front]] = [range(0), range(2)];
      const points = [];
      for (let i = 0; i < all.length / 3; i++) {
        const x = (all[3 * i] - left) / (right - left);
        if (Math.abs(x - 0.5) < 0.1 && all[3 * i + 2] < back + 0.1 * (front - back)) points.push(i);
      }
      preview.view.select({ points });
      return points.length;
    });
  const pictures = {};
  for (const key of ["4", "6"]) {
    const without = await pictureAfter(preview, () => page.keyboard.press(key));
    assert.ok((await select()) > 3);
    pictures[key] = { without, with: await preview.picture() };
    await preview.evaluate(() => preview.view.select(null));
  }
  const [front, back] = [pictures[4], pictures[6]];
  assert.ok(yellow(back.with) > 200, "it is seen from the back");
  assert.ok(yellow(front.with) < 0.05 * yellow(back.with), "it does not shine through to the front");
  assert.ok(differing(front.without, front.with) > 0.0005, "where it is can be told");
  assertClean(preview);
});

test("at the edge of cloth before other cloth, a click finds the edge in front", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { page } = preview;
  await preview.settings({ roles: ["model"] });
  await preview.isStill();
  await page.keyboard.press("e");
  await page.keyboard.type("borders.highest");
  await page.keyboard.press("Enter");
  await preview.when(() => preview.store.state.selection !== null);
  // The middle of the front of the neckline; above it, the inside of the back is seen.
  const { ends, x, y } = await preview.evaluate(() => {
    const { store, view } = preview;
    const { edges } = store.state.selection.elements;
    store.selector.clear();
    const front = (edge) => edge.reduce((sum, point) => sum + observed.points.model[3 * point + 2], 0);
    const [ends] = edges.sort((a, b) => front(b) - front(a));
    const [a, b] = ends.map((point) => view.project("model", point));
    const box = document.querySelector("canvas").getBoundingClientRect();
    return { ends, x: box.x + (a.x + b.x) / 2, y: box.y + (a.y + b.y) / 2 };
  });
  await page.mouse.click(x, y - 2);
  await preview.when(() => preview.store.state.selection !== null);
  const { edges } = await preview.state(({ selection }) => selection.elements);
  assert.deepEqual(edges?.map((pair) => [...pair].sort()), [[...ends].sort()]);
  assertClean(preview);
});
