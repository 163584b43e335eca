// A garment is opened and drawn.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, open, SCREEN, show } from "./support/browser.mjs";
import { clipped } from "./support/layout.mjs";
import { colours, distance, rgb } from "./support/png.mjs";
import { example, Server, SUIT } from "./support/server.mjs";

/** Share of the points of a mesh whose pixels are not of the background's colour. */
async function drawnShare(preview, picture, role) {
  const places = await preview.evaluate((role) => {
    const { points } = preview.view.stats(role);
    const step = Math.max(1, Math.floor(points / 300));
    const all = Array.from({ length: Math.floor(points / step) }, (_, i) => preview.view.project(role, i * step));
    return all.filter((place) => place !== null);
  }, role);
  assert.ok(places.length > 50, `${role} is on the canvas`);
  const background = rgb(picture, 3, Math.floor(picture.height / 2));
  const differs = ({ x, y }) => distance(rgb(picture, Math.floor(x), Math.floor(y)), background) > 40;
  return places.filter(differs).length / places.length;
}

async function assertDrawn(preview) {
  const picture = await preview.picture();
  for (const [i, role] of ["model", "sim", "render"].entries()) {
    assert.ok((await drawnShare(preview, picture, role)) > 0.6, `${role} is drawn`);
    assert.ok(colours(picture, [i / 3, (i + 1) / 3]) > 200, `${role} is shaded`);
  }
}

test("the three meshes of the coat are drawn, and nothing is asked of anybody else", async (t) => {
  const preview = await show(t, example("coat.usda"), { rests: true });
  await assertDrawn(preview);
  await preview.when(() => preview.view.samples() >= 4);
  const { model, sim, render } = await preview.meshes();
  const garment = await preview.state(({ garment }) => garment);
  assert.deepEqual([model.points, model.faces], [garment.points, garment.faces]);
  assert.ok(sim.faces > model.faces && render.faces > 3.9 * model.faces, "finer than the garment");
  assert.equal(await preview.page.title(), "coat.usda · usdtailor");
  assertClean(preview);
});

test("a suit of many layers and thousands of faces is drawn", async (t) => {
  const preview = await show(t, SUIT);
  await assertDrawn(preview);
  assertClean(preview);
});

test("nothing is cut and nothing overflows, in light and in dark", async (t) => {
  const server = await Server.start(t, example("sewn/coat.usda"));
  for (const colorScheme of ["light", "dark"]) {
    const preview = await open(t, server, { viewport: SCREEN, colorScheme });
    assert.deepEqual(await preview.evaluate(clipped), [], `${colorScheme}, at first`);
    await preview.openCard("seam.side");
    await preview.page.getByRole("button", { name: "Show figures" }).click();
    await preview.page.getByRole("radio", { name: "Heat" }).check();
    await preview.quiet();
    assert.deepEqual(await preview.evaluate(clipped), [], `${colorScheme}, with all open`);
    const box = await preview.page.locator("canvas").boundingBox();
    assert.ok(box.width > 700 && box.height > 300, "the garment keeps most of the window");
    assertClean(preview);
    await preview.page.close();
  }
});
