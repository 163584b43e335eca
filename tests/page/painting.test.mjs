// A brush for the density, the thickness of folds, and pins.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { build, sewnShirt, substitute } from "./support/garments.mjs";
import { temporaryFolder } from "./support/server.mjs";

/** The shirt from the front, with the brush in hand. */
async function painting(t, settings = {}) {
  const shirt = sewnShirt(t);
  substitute(shirt, 'tailor:sim:density = "simDensity"', 'tailor:sim:density = ""');
  const preview = await show(t, shirt, { isNew: true, viewport: SCREEN });
  await preview.settings({ symmetric: false, ...settings });
  await preview.evaluate(() => preview.view.look("front"));
  await preview.isStill();
  await preview.page.locator("canvas").focus();
  await preview.page.keyboard.press("p");
  await preview.when(() => preview.store.state.brush?.isReady);
  await preview.quiet();
  await preview.isStill();
  return preview;
}

/** Drags over the belly of the large mesh, on the right half of the picture. */
async function stroke(preview, { from = [60, 60], to = [60, 120] } = {}) {
  const { mouse } = preview.page;
  const box = await preview.page.locator("canvas").boundingBox();
  const [x, y] = [box.x + 305, box.y + 317];
  await mouse.move(x + from[0], y + from[1]);
  await mouse.down();
  await mouse.move(x + to[0], y + to[1], { steps: 6 });
  await mouse.up();
}

const option = async (preview, group, field) => (await preview.document()).merged[group]?.[field];
const DIGITS = /^painted\("[0-9a-f]{8}", "([0-9a-f]*)"\)$/;
const weights = (text) => DIGITS.exec(text)[1].match(/../g).map((pair) => parseInt(pair, 16) / 255);

test("a stroke paints the density: more triangles there, one step of undo each", async (t) => {
  const preview = await painting(t);
  const before = await preview.meshes();
  const first = await preview.after("sim", () => stroke(preview));
  assert.ok(first.sim.faces > before.sim.faces, `${first.sim.faces} of ${before.sim.faces}`);
  assert.deepEqual([first.model, first.render], [before.model, before.render]);
  const painted = weights(await option(preview, "sim", "density"));
  assert.equal(painted.length, before.model.points);
  const count = painted.filter((weight) => weight > 0).length;
  assert.ok(count > 3 && count < painted.length / 4, `${count} points of ${painted.length} are painted`);
  const second = await preview.after("sim", () => stroke(preview, { from: [-60, 60], to: [-60, 120] }));
  assert.ok(second.sim.faces > first.sim.faces);
  assert.deepEqual(await preview.after("sim", () => preview.page.keyboard.press("Control+z")), first);
  assert.deepEqual(await preview.after("sim", () => preview.page.keyboard.press("Control+z")), before);
  assert.equal((await preview.document()).canUndo, false);
  // The brush goes back too: a stroke after an undo begins with what is there then.
  await preview.after("sim", () => stroke(preview));
  assert.deepEqual(weights(await option(preview, "sim", "density")), painted);
  assertClean(preview);
});

test("Alt takes away, Shift smooths, and both sides are painted at once", async (t) => {
  const preview = await painting(t, { symmetric: true, smooth: 1 });
  const total = async () => weights(await option(preview, "sim", "density")).reduce((sum, each) => sum + each, 0);
  const most = async () => Math.max(...weights(await option(preview, "sim", "density")));
  await preview.after("sim", () => stroke(preview));
  const painted = weights(await option(preview, "sim", "density"));
  const mirror = await preview.state(({ garment }) => garment.mirror.points);
  assert.equal(painted.length, mirror.length, "the points of the cage, however it was shown before");
  assert.ok(painted.every((weight, point) => weight === painted[mirror[point]]));
  const [sum, peak] = [await total(), await most()];
  await preview.page.keyboard.down("Shift");
  await preview.after("sim", () => stroke(preview));
  await preview.page.keyboard.up("Shift");
  assert.ok((await most()) < peak, "peaks are lower");
  await preview.page.keyboard.down("Alt");
  await preview.after("sim", () => stroke(preview));
  await preview.page.keyboard.up("Alt");
  assert.ok((await total()) < sum);
  // Beside the garment, a drag turns the view.
  const aim = await preview.evaluate(() => preview.view.aim().direction);
  await stroke(preview, { from: [-290, 280], to: [-230, 280] });
  assert.notDeepEqual(await preview.evaluate(() => preview.view.aim().direction), aim);
  await preview.page.keyboard.press("Escape");
  assert.equal(await preview.state(({ brush }) => brush), null);
  assertClean(preview);
});

test("painted weights are saved as a primvar of the layer, and are there again when it is opened", async (t) => {
  const preview = await painting(t);
  await preview.after("sim", () => stroke(preview));
  const density = await option(preview, "sim", "density");
  const file = join(temporaryFolder(t), "look.usda");
  await preview.evaluate((path) => preview.store.send({ type: "save", path, overwrite: false }), file);
  await preview.when(() => preview.store.state.save?.status === "saved");
  const text = readFileSync(file, "utf8");
  assert.match(text, /float\[\] primvars:tailor:painted_sim_density = \[/);
  assert.match(text, /interpolation = "vertex"/);
  assert.match(text, /uniform token tailor:sim:density = "tailor:painted_sim_density"/);
  const numbers = /primvars:tailor:painted_sim_density = \[([^\]]*)\]/.exec(text)[1].split(",").map(Number);
  assert.deepEqual(numbers.map((number) => Math.fround(number)), weights(density).map(Math.fround));
  const shown = await preview.points("sim");
  assert.deepEqual((await build(t, file)).sim, shown, "a build of the layer makes the mesh on screen");
  const again = await show(t, file);
  assert.equal(await option(again, "sim", "density"), density);
  assertClean(preview);
  assertClean(again);
});

test("a stroke goes on from a primvar or a set, and folds and pins are painted too", async (t) => {
  const preview = await painting(t);
  await preview.page.keyboard.press("p");
  await preview.after("sim", () => preview.set("sim.density", "simDensity"));
  await preview.page.keyboard.press("p");
  await preview.when(() => preview.store.state.brush?.isReady);
  await preview.after("sim", () => stroke(preview));
  assert.ok(weights(await option(preview, "sim", "density")).filter((weight) => weight > 0.3).length > 50, "what the file has painted");
  await preview.page.keyboard.press("p");
  await preview.after("sim", () => preview.set("sim.density", "neckband"));
  await preview.page.keyboard.press("p");
  await preview.when(() => preview.store.state.brush?.isReady);
  const same = await preview.meshes();
  await preview.after("sim", () => stroke(preview));
  const density = weights(await option(preview, "sim", "density"));
  assert.ok(density.filter((weight) => weight === 1).length > 10, "the neckband is dense as before");
  assert.ok((await preview.meshes()).sim.faces > same.sim.faces);

  await preview.page.getByLabel("What is painted").selectOption("fold.neck.weights");
  await preview.when(() => preview.store.state.brush?.isReady);
  await preview.page.keyboard.down("Alt");
  await stroke(preview, { from: [0, -160], to: [40, -160] });
  await preview.page.keyboard.up("Alt");
  await preview.quiet();
  const fold = weights((await preview.document()).merged.fold.neck.weights);
  assert.ok(fold.includes(1) && fold.some((weight) => weight < 1), "a fold has its whole thickness where nothing is painted");

  await preview.page.getByLabel("What is painted").selectOption("cloth.pins");
  await preview.when(() => preview.store.state.brush?.isReady);
  await stroke(preview);
  await preview.quiet();
  const pins = weights((await option(preview, "cloth", "pins"))[0]);
  assert.deepEqual([...new Set(pins)].sort(), [0, 1], "a point is pinned or not");
  await preview.when(() => preview.store.state.cloth?.figures?.pinned > 0);
  assertClean(preview);
});
