// Edits are saved, and `usdtailor build` makes of the file what was on the screen.

import assert from "node:assert/strict";
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { assertSame, build, sewnShirt } from "./support/garments.mjs";
import { copyOf } from "./support/server.mjs";

/** Edits of each kind: of both meshes, of an operator of the garment, an operator of their own, the order. */
async function edit(preview) {
  const before = await preview.meshes();
  await preview.evaluate(() =>
    preview.store.edit(() => ({
      sim: { maxEdgeLength: 2.37, seed: 5 },
      render: { level: 2, operators: ["seam.side", "fold.neck", "seam.hem"] },
      seam: { side: { normalOffset: -0.123456 }, hem: { edges: ["hem_stitch"], normalOffset: -0.2, width: 0.7 } },
      fold: { neck: { thickness: 0.33 } },
    })),
  );
  await preview.differs("render", before);
  await preview.differs("sim", before);
  await preview.quiet();
}

function dialogOf(preview) {
  const dialog = preview.page.getByRole("dialog", { name: "Save the edits" });
  const button = dialog.locator('button[type="submit"]');
  return { dialog, button, path: dialog.getByLabel("Path"), text: dialog.locator("pre") };
}

/** The answer of the server on the path that is in the dialog. */
const planned = (preview, path) =>
  preview.when((path) => preview.store.state.save?.path === path && preview.store.state.save.status, path);

async function assertBuilds(t, preview, file) {
  const built = await build(t, file);
  for (const role of ["sim", "render"])
    assertSame(await preview.points(role), built[role], `${role} is that on screen`);
  return built;
}

test("a layer is saved after a look at it, and its build is what was on the screen", async (t) => {
  const garment = sewnShirt(t);
  const preview = await show(t, garment);
  await edit(preview);
  const { dialog, button, path, text } = dialogOf(preview);
  assert.ok(await preview.page.getByText("Not saved").isVisible());
  await preview.page.keyboard.press("Control+s");
  const file = join(dirname(garment), "tshirt_look.usda");
  assert.equal(await path.inputValue(), file);
  await planned(preview, file);
  const shown = await text.innerText();
  assert.equal(Math.fround(/float tailor:seam:hem:width = (\S+)/.exec(shown)[1]), Math.fround(0.7));
  assert.match(shown, /TailorSeamAPI:hem/);
  assert.ok(!existsSync(file), "a look writes nothing");
  await button.click();
  await dialog.waitFor({ state: "detached" });
  await preview.page.getByText(`Saved ${file}`).waitFor();
  await preview.quiet();
  assert.equal((await preview.document()).unsaved, false);
  assert.equal(readFileSync(file, "utf8").trim(), shown.trim(), "the text is what the dialog showed");
  assert.deepEqual(readdirSync(dirname(file)).sort(), ["tshirt.usda", "tshirt_look.usda"]);

  const built = await assertBuilds(t, preview, file);
  const byRecipe = await build(t, garment, "--recipe", file);
  assert.equal(built.products, byRecipe.products, "--recipe gives the same");
  assertClean(preview);
});

test("a .tailor file is saved, and its build is what was on the screen", async (t) => {
  const garment = sewnShirt(t);
  const preview = await show(t, garment);
  await edit(preview);
  const { dialog, button, path, text } = dialogOf(preview);
  await preview.page.getByRole("button", { name: "Save" }).click();
  await dialog.getByRole("radio", { name: ".tailor file" }).check();
  const file = join(dirname(garment), "tshirt.tailor");
  assert.equal(await path.inputValue(), file);
  await planned(preview, file);
  const { source, seam } = JSON.parse(await text.innerText());
  assert.deepEqual([source, seam.side], ["./tshirt.usda", { normalOffset: -0.123456 }]);
  await button.click();
  await dialog.waitFor({ state: "detached" });
  const built = await assertBuilds(t, preview, file);

  const set = {
    "sim.maxEdgeLength": 2.37,
    "sim.seed": 5,
    "render.level": 2,
    "render.operators": "seam.side,fold.neck,seam.hem",
    "seam.side.normalOffset": -0.123456,
    "seam.hem.edges": "hem_stitch",
    "seam.hem.normalOffset": -0.2,
    "seam.hem.width": 0.7,
    "fold.neck.thickness": 0.33,
  };
  const bySet = await build(t, garment, ...Object.entries(set).flatMap(([key, value]) => ["--set", `${key}=${value}`]));
  assert.equal(built.products, bySet.products, "--set gives the same");
  assertClean(preview);
});

test("a file that exists is written after a second click, and the garment itself never", async (t) => {
  const garment = sewnShirt(t);
  const authored = readFileSync(garment, "utf8");
  const preview = await show(t, garment);
  const { dialog, button, path } = dialogOf(preview);
  const file = join(dirname(garment), "look.usda");
  const saveTo = async (where) => {
    await preview.page.getByRole("button", { name: "Save" }).click();
    await path.fill(where);
    await planned(preview, where);
  };
  await preview.after("render", () => preview.set("seam.side.normalOffset", -0.4));
  await saveTo(file);
  await button.click();
  await dialog.waitFor({ state: "detached" });
  const first = readFileSync(file, "utf8");

  await preview.after("render", () => preview.set("seam.side.normalOffset", -0.5));
  await saveTo(file);
  assert.equal(await button.innerText(), "Update");
  assert.ok((await dialog.locator(".save-note").innerText()).length > 20, "what happens to the rest of the file");
  await button.click();
  await dialog.getByText("Update: click again").waitFor();
  assert.equal(readFileSync(file, "utf8"), first, "one click writes nothing");
  await button.click();
  await dialog.waitFor({ state: "detached" });
  assert.match(readFileSync(file, "utf8"), /normalOffset = -0\.5/);
  await assertBuilds(t, preview, file);

  await saveTo(garment);
  await button.click();
  if (/again/.test(await button.innerText())) await button.click();
  await dialog.getByRole("alert").waitFor();
  assert.equal(await path.getAttribute("aria-invalid"), "true");
  assert.equal(readFileSync(garment, "utf8"), authored);

  await path.fill(join(dirname(garment), "none", "look.usda"));
  await preview.when(() => preview.store.state.save?.path.includes("none"));
  if (await button.isEnabled()) await button.click();
  await dialog.getByRole("alert").waitFor();
  await preview.page.keyboard.press("Escape");
  await dialog.waitFor({ state: "detached" });
  assertClean(preview);
});

test("a layer holds numbers as they were typed", async (t) => {
  const preview = await show(t, sewnShirt(t));
  await preview.set("seam.side.width", 0.7);
  await preview.page.keyboard.press("Control+s");
  const { text } = dialogOf(preview);
  await preview.when(() => preview.store.state.save?.text);
  assert.match(await text.innerText(), /tailor:seam:side:width = 0\.7$/m);
});

test("a set that the mesh offers is sewn from the menu by keys, and saved as an expression", async (t) => {
  const garment = copyOf(t, "tshirt.usda");
  const preview = await show(t, garment);
  const before = await preview.meshes();
  await preview.page.getByRole("button", { name: "New seam" }).click();
  await preview.page.getByLabel("Find in New seam").fill("uvSeams");
  const sewn = await preview.after("render", () => preview.page.keyboard.press("Enter"));
  assert.deepEqual(await preview.cards(), ["seam.uvSeams"]);
  assert.ok(sewn.render.faces > before.render.faces);
  assert.deepEqual((await preview.document()).edits.seam.uvSeams.edges, ["uvSeams"]);
  const file = join(dirname(garment), "tshirt_look.usda");
  await preview.evaluate((path) => preview.store.command({ type: "save", path, overwrite: false }), file);
  await preview.when(() => preview.store.state.save?.status === "saved");
  assert.match(readFileSync(file, "utf8"), /string tailor:seam:uvSeams:edges = "uvSeams"/);
  const built = await build(t, file);
  assertSame(await preview.points("render"), built.render, "the render mesh is that on screen");
  assertClean(preview);
});
