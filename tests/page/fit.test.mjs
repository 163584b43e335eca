// The fit of a garment to another body: its options, the way to the body, and what crosses it there.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { body, SHEET } from "./support/bodies.mjs";
import { assertClean, show } from "./support/browser.mjs";
import { assertSame, build, sheetFile } from "./support/garments.mjs";

const ROLES = ["model", "sim", "render"];

/** A cloth half a unit over the body thin.usda. On thick.usda it lies higher. */
function sheet(t) {
  const garment = sheetFile(t, SHEET);
  body(join(dirname(garment), "thin.usda"), [0, 0, -2], [4, 4, -0.5]);
  body(join(dirname(garment), "thick.usda"), [0, 0, -2], [4, 4, 0.5]);
  return garment;
}

/** The cloth with a recipe that fits it to a body. */
function fitted(t, fit = { from: "thin.usda", to: "thick.usda" }) {
  const recipe = join(dirname(sheet(t)), "sheet.tailor");
  writeFileSync(recipe, JSON.stringify({ source: "sheet.usda", fit }));
  return recipe;
}

const heights = async (preview, role) => Array.from(await preview.points(role)).filter((_, at) => at % 3 === 2);

async function choose(preview, key, file) {
  await preview.row(key).getByRole("button", { name: /^Files for/ }).click();
  await preview.page.getByRole("menuitem", { name: file, exact: true }).click();
}

/** Moves the slider, and waits until all meshes are there. */
async function slide(preview, share) {
  await preview.page.getByRole("slider", { name: "Share of the fit" }).fill(String(share));
  await preview.when((share) => preview.store.state.fit?.share === share, share);
  await preview.quiet();
}

test("bodies are chosen from the files beside the garment, and the garment is fitted", async (t) => {
  const garment = sheet(t);
  const preview = await show(t, garment);
  const { page } = preview;
  await preview.row("fit.from").getByRole("button", { name: /^Files for/ }).click();
  await preview.when(() => preview.store.state.bodies.isComplete, null, 60_000);
  await page.keyboard.press("Escape");
  const offered = await preview.state(({ bodies }) => bodies.files);
  assert.deepEqual(offered.slice(0, 2), ["thick.usda", "thin.usda"].map((name) => join(dirname(garment), name)));
  assert.ok(offered.length <= 40 && !offered.includes(garment), `${offered}`);
  const section = page.getByRole("region", { name: "Fit" });
  assert.deepEqual(
    await section.locator("[data-key]").evaluateAll((rows) => rows.map((row) => row.dataset.key)),
    ["fit.from", "fit.to", "fit.rigid", "fit.keepLength", "fit.ease", "fit.rest"],
  );
  await choose(preview, "fit.from", "thin.usda");
  await choose(preview, "fit.to", "thick.usda");
  await preview.when(() => preview.store.state.fit && preview.store.view.hasBody());
  await preview.quiet();
  const lowest = async (role) => Math.min(...(await heights(preview, role)));
  for (const role of ROLES) assert.ok((await lowest(role)) > 0.6, `${role} lies over the thick body`);
  const field = preview.row("fit.to").getByRole("textbox");
  assert.equal(await field.inputValue(), "thick.usda");

  // What is saved builds the same, bit for bit, from a path that is relative to the file.
  const saved = join(dirname(garment), "fitted.tailor");
  await page.evaluate((path) => preview.store.send({ type: "save", path, overwrite: false }), saved);
  await preview.when(() => preview.store.state.save?.status === "saved");
  assert.match(await preview.state(({ save }) => save.text), /"to": "\.\/thick\.usda"/);
  const built = await build(t, saved);
  for (const role of ["sim", "render"]) assertSame(await preview.points(role), built[role], role);

  await page.evaluate(() => preview.store.command({ type: "undo" }));
  await preview.when(() => preview.store.state.fit === null && !preview.store.view.hasBody());
  await preview.quiet();
  for (const role of ROLES) assert.ok(Math.abs(await lowest(role)) < 1e-6, `${role} is as it was made`);
  await page.evaluate(() => preview.store.command({ type: "redo" }));
  await preview.when(() => preview.store.state.fit !== null);

  // A layer names the body as an asset beside it.
  const layer = join(dirname(garment), "fitted.usda");
  await page.evaluate((path) => preview.store.send({ type: "save", path, overwrite: false }), layer);
  await preview.when((path) => preview.store.state.save?.path === path, layer);
  const answer = await preview.state(({ save }) => save);
  assert.equal(answer.fault, null);
  assert.match(answer.text, /uniform asset tailor:fit:to = @\.\/thick\.usda@/);
  assertClean(preview);
});

test("a fit that fails says so at its option, and the last garment stays", async (t) => {
  const preview = await show(t, fitted(t));
  const before = await preview.points("model");
  const row = preview.row("fit.to");
  await row.getByRole("textbox").fill("./nobody.usda");
  await row.getByRole("textbox").press("Enter");
  const alert = row.getByRole("alert");
  await alert.waitFor();
  assert.match(await alert.innerText(), /nobody\.usda/);
  assertSame(await preview.points("model"), before, "the last garment");
  assert.equal(await row.getByRole("textbox").getAttribute("aria-invalid"), "true");

  // The file is there later.
  body(join(dirname(preview.server.garment), "nobody.usda"), [0, 0, -2], [4, 4, 0.25]);
  await preview.page.evaluate(() => preview.store.send({ type: "reload" }));
  await alert.waitFor({ state: "detached" });
  await preview.differs("model", { model: { checksum: before.reduce((sum, each) => sum + each, 0), faces: 16 } });
  await preview.quiet();
  assertClean(preview);
});

test("a selection is added to the sets of the fit", async (t) => {
  const preview = await show(t, fitted(t));
  await preview.page.evaluate(() => preview.store.selector.take("borders"));
  await preview.when(() => preview.store.state.selection !== null);
  await preview.row("fit.rigid").getByRole("button", { name: "Add to Rigid" }).click();
  await preview.page.getByRole("menuitem", { name: /The selection/ }).click();
  await preview.when(() => preview.store.state.document.edits.fit.rigid?.length === 1);
  await preview.quiet();
  assert.equal(await preview.page.getByRole("region", { name: "Fit" }).getByRole("alert").count(), 0);
  assert.equal(await preview.state(({ fit }) => fit.share), 1);
  assertClean(preview);
});

test("the slider moves all meshes, and its end is what a build writes", async (t) => {
  const recipe = fitted(t);
  const built = await build(t, recipe);
  const preview = await show(t, recipe);
  const end = await preview.points("model");
  const assertEnd = async () => {
    assertSame(await preview.points("model"), end, "model");
    for (const role of ["sim", "render"]) assertSame(await preview.points(role), built[role], role);
  };
  await assertEnd();
  const ends = Object.fromEntries(await Promise.all(ROLES.map(async (role) => [role, await heights(preview, role)])));
  await slide(preview, 0);
  for (const role of ROLES) {
    const far = Math.max(...(await heights(preview, role)).map(Math.abs));
    assert.ok(far < 1e-5, `${role} is as it was made: ${far}`);
  }
  await slide(preview, 0.5);
  for (const role of ROLES) {
    const half = await heights(preview, role);
    assert.ok(Math.min(...half) > 0.2 && Math.max(...half) < Math.max(...ends[role]), `${role}: ${half}`);
  }

  // An edit is shown at the same place of the way.
  await preview.after("sim", () => preview.set("sim.maxEdgeLength", 0.5));
  assert.equal(await preview.state(({ fit }) => fit.share), 0.5);
  const half = await heights(preview, "sim");
  assert.ok(Math.min(...half) > 0.2 && Math.max(...half) < Math.max(...ends.sim), `${half}`);
  await preview.after("sim", () => preview.page.evaluate(() => preview.store.command({ type: "undo" })));
  await slide(preview, 1);
  await assertEnd();
  assertClean(preview);
});

/** Pixels in the colour of crossings. */
function red({ channels, pixels }) {
  let count = 0;
  for (let at = 0; at < pixels.length; at += channels) {
    const [r, g, b] = pixels.subarray(at, at + 3);
    if (r > 100 && r > 1.3 * g && r > 1.3 * b) count += 1;
  }
  return count;
}

test("crossings are those at the place of the slider, counted, listed and drawn", async (t) => {
  // The first body goes through four faces of the stiff cloth, and the second one through one of them.
  const recipe = fitted(t, { from: "wide.usda", to: "narrow.usda", rigid: ["faces"] });
  body(join(dirname(recipe), "wide.usda"), [0.4, 0.4, -3], [1.6, 1.6, 0.5]);
  body(join(dirname(recipe), "narrow.usda"), [0.4, 0.4, -3], [0.6, 0.6, -1.5]);
  const preview = await show(t, recipe);
  const slider = preview.page.getByRole("slider", { name: "Share of the fit" });
  const listed = () => preview.page.locator(".warning-text", { hasText: /cross(es)? the body/ }).allInnerTexts();
  await preview.settings({ figures: true, body: false, roles: ["render"] });
  const assertCrossing = async (share, expected, words) => {
    await slide(preview, share);
    const { faces } = await preview.state(({ fit }) => fit.finding.elements);
    assert.deepEqual(faces.toSorted((a, b) => a - b), expected);
    assert.match(await slider.getAttribute("aria-valuetext"), words);
    const [text, ...others] = await listed();
    assert.deepEqual(others, []);
    assert.match(text, new RegExp(`${expected.length} faces? cross(es)? the body`));
    return red(await preview.picture());
  };
  const few = await assertCrossing(1, [5], /1 face crosses, none new/);
  const many = await assertCrossing(0, [0, 1, 4, 5], /4 faces cross, none new/);
  assert.ok(few > 20 && many > 2 * few, `${few} and ${many} red pixels`);
  // A click on the warning marks it as any other, and the slider takes the marks along.
  await preview.page.locator("button.warning", { hasText: /cross(es)? the body/ }).click();
  await assertCrossing(1, [5], /1 face crosses/);
  assert.deepEqual(await preview.state(({ marked, fit }) => marked === fit.finding && marked.elements.faces), [5]);
  assertClean(preview);
});
