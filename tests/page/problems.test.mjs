// Warnings and errors are shown where they are.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { sewnShirt, substitute } from "./support/garments.mjs";
import { differing } from "./support/png.mjs";
import { example } from "./support/server.mjs";

test("a warning that is clicked marks its place, and Escape ends the mark", async (t) => {
  const preview = await show(t, example("sewn/coat.usda"));
  const { page } = preview;
  const before = await preview.picture();
  const count = Number(/\d+/.exec(await page.getByTestId("warning-count").textContent()));
  assert.ok(count > 0, "the coat has warnings");
  await page.getByTestId("warning-count").click();
  const warnings = page.locator("button.warning");
  assert.equal(await warnings.count(), count);
  for (let i = 0; i < count; i++)
    assert.ok((await warnings.nth(i).innerText()).length > 40, "the problem and its cure");

  const withPlace = page.locator('button.warning[title^="Show where"]').first();
  await withPlace.click();
  assert.equal(await withPlace.getAttribute("aria-pressed"), "true");
  const marked = await preview.picture();
  assert.ok(before.height !== marked.height || differing(before, marked) > 0.02, "the camera flies there");
  await page.keyboard.press("Escape");
  assert.equal(await withPlace.getAttribute("aria-pressed"), "false");
  const ended = await preview.picture();
  const share = differing(marked, ended);
  assert.ok(share > 0.0002 && share < 0.5, `only the marks go: ${share}`);

  await withPlace.click();
  await withPlace.click();
  assert.equal(await preview.state(({ marked }) => marked), null, "a second click ends it too");
  assertClean(preview);
});

/** A shirt with a face that is turned over, UV shells too small for its triangles, and an operator that does not run. */
async function flawedShirt(t) {
  const path = sewnShirt(t);
  substitute(path, /(faceVertexIndices = \[)(\d+), (\d+), (\d+), (\d+)/, "$1$5, $4, $3, $2");
  const preview = await show(t, path, { viewport: SCREEN });
  await preview.evaluate(() =>
    preview.store.edit((options) => ({
      ...options,
      sim: { minEdgeLength: 10, maxEdgeLength: 14, smallestShell: 5 },
      render: { operators: ["seam.side", "fold.neck"] },
    })),
  );
  await preview.when(() => preview.store.state.products.sim?.warnings.some(({ code }) => code === "small-shells"));
  await preview.quiet();
  await preview.page.getByTestId("warning-count").click();
  return preview;
}

test("warnings are listed from the worst, each with the colour of its severity", async (t) => {
  const preview = await flawedShirt(t);
  const all = await preview.page.locator("button.warning").evaluateAll((buttons) =>
    buttons.map((button) => ({
      severity: /is-(fault|quality|note)/.exec(button.className)[1],
      colour: getComputedStyle(button.querySelector(".warning-icon")).color,
      words: button.innerText,
    })),
  );
  const order = ["fault", "quality", "note"];
  const ranks = all.map(({ severity }) => order.indexOf(severity));
  assert.deepEqual(ranks, [...ranks].sort(), "the worst come first");
  assert.deepEqual([...new Set(all.map(({ severity }) => severity))], order, "the shirt has all of them");
  assert.equal(new Set(all.map(({ colour }) => colour)).size, 3);
  for (const { severity, words } of all) assert.ok(words.includes(severity), "and it is said in words");
  assert.match(await preview.page.locator(".warning-count").last().getAttribute("class"), /is-fault/);
  assertClean(preview);
});

test("a warning marks its places in the column of its mesh, which is shown", async (t) => {
  const preview = await flawedShirt(t);
  const { page } = preview;
  const roles = () => preview.state(({ settings }) => settings.roles);
  await preview.settings({ roles: ["render"] });
  const mark = async (words) => {
    await page.locator("button.warning").filter({ hasText: words }).first().click();
    await preview.quiet();
    const marked = await preview.picture();
    await page.keyboard.press("Escape");
    return [marked, await preview.picture()];
  };
  const ofModel = await mark("fault · model");
  assert.deepEqual(await roles(), ["model", "render"], "the model has the face that is turned over");
  assert.ok(differing(...ofModel, [0, 0.46]) > 0.0002, "it is marked on the model");
  assert.equal(differing(...ofModel, [0.5, 0.9]), 0, "and not on the render mesh");

  const ofSim = await mark(/quality · simulation · \d+ faces/);
  assert.deepEqual(await roles(), ["model", "sim", "render"]);
  assert.ok(differing(...ofSim, [0.33, 0.61]) > 0.0002, "it is marked on the simulation mesh");
  assert.equal(differing(...ofSim, [0, 0.3]) + differing(...ofSim, [0.64, 0.9]), 0, "and on no other");
  const stored = await page.evaluate(() => JSON.parse(localStorage.getItem("usdtailor.preview")));
  assert.deepEqual(stored.roles, ["render"], "what the artist chose is kept");
  assertClean(preview);
});

test("an option out of range is told beside it, and the last good mesh stays", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const before = await preview.meshes();
  await preview.set("render.level", 9);
  const row = preview.row("render.level");
  const fault = row.getByRole("alert");
  await fault.waitFor();
  assert.match(await fault.innerText(), /\w+ .+/s);
  assert.equal(await preview.field("render.level").getAttribute("aria-invalid"), "true");
  const notes = await preview.field("render.level").getAttribute("aria-describedby");
  assert.ok(await row.locator(`[id="${notes}"] .fault`).isVisible(), "the field is described by its fault");
  await preview.quiet();
  assert.deepEqual(await preview.meshes(), before);

  // An option that is good changes its mesh only when all of the recipe is.
  await preview.page.keyboard.press("Control+z");
  await fault.waitFor({ state: "detached" });
  assert.equal(await preview.field("render.level").getAttribute("aria-invalid"), "false");
  await preview.after("render", () => preview.set("render.level", 0));
  assertClean(preview);
});

test("a seam without edges is an error in its card until it has some", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const before = await preview.meshes();
  await preview.openCard("seam.side");
  const row = preview.row("seam.side.edges");
  await row.getByRole("button", { name: "Remove side seams" }).click();
  await row.getByRole("alert").waitFor();
  assert.equal(await row.getByRole("group", { name: "Edges" }).getAttribute("aria-invalid"), "true");
  assert.match(await preview.card("seam.side").getAttribute("class"), /has-fault/);
  await preview.quiet();
  assert.deepEqual(await preview.meshes(), before);
  await row.getByRole("button", { name: "Add to Edges" }).click();
  const menu = page.getByRole("menuitem", { name: "chest line" });
  await preview.after("render", () => menu.click());
  assert.equal(await page.locator(".fault, .banner").count(), 0);
  assert.doesNotMatch(await preview.card("seam.side").getAttribute("class"), /has-fault/);
  assertClean(preview);
});

test("a field does not take what is not a number", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const field = preview.field("render.level");
  await field.fill("much");
  assert.equal(await field.getAttribute("aria-invalid"), "true");
  await field.press("Enter");
  assert.equal(await field.inputValue(), "1");
  await field.fill("77");
  // Its mesh has a million faces, and is not waited for.
  await field.press("Enter");
  const { most } = await preview.state(
    ({ garment }) => garment.options.find(({ key }) => key === "render.level").domain,
  );
  assert.equal(await field.inputValue(), String(most), "the nearest value that may be");
  await field.fill("0");
  await field.press("Escape");
  assert.equal(await field.inputValue(), String(most));
  assertClean(preview);
});
