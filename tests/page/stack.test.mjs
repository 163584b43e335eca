// Seams and folds are made, changed and removed.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { bareShirt, sewnShirt } from "./support/garments.mjs";
import { placeOf } from "./support/picking.mjs";
import { example } from "./support/server.mjs";

test("an edge that is clicked on the model becomes a seam", async (t) => {
  const preview = await show(t, example("tshirt.usda"), { viewport: SCREEN });
  const { x, y } = await placeOf(preview, "chest_line");
  assert.ok(await preview.page.locator(".hover-label", { hasText: "chest line" }).isVisible());
  await preview.page.mouse.click(x, y);
  const popover = preview.page.getByRole("dialog", { name: "What was clicked" });
  const row = popover.locator(".pick-row", { hasText: "chest line" });
  const before = await preview.meshes();
  const after = await preview.after("render", () => row.getByRole("button", { name: "New seam" }).click());
  await popover.waitFor({ state: "detached" });
  assert.deepEqual(await preview.cards(), ["seam.chest_line"]);
  await preview.card("seam.chest_line").locator(".card-body").waitFor();
  assert.ok(after.render.faces > before.render.faces, "a seam has faces");
  // The shirt is in centimetres.
  const depth = (await preview.document()).edits.seam.chest_line.normalOffset;
  const width = await preview.state(({ products }) => products.render.lengths["seam.chest_line.width"]);
  assert.deepEqual([depth, width], [-0.1, 0.5], "it is 1 mm deep and 5 mm wide");
  assert.deepEqual([after.sim, after.model], [before.sim, before.model]);
  assert.deepEqual(await preview.state(({ products }) => products.render.operators), ["seam.chest_line"]);

  await preview.page.mouse.click(x, y);
  await row.getByRole("button", { name: "Go to seam chest_line" }).waitFor();
  await preview.page.keyboard.press("Escape");
  await popover.waitFor({ state: "detached" });
  assertClean(preview);
});

test("a fold comes from the menu, and a copy has a name of its own", async (t) => {
  const preview = await show(t, example("tshirt.usda"));
  const before = await preview.meshes();
  await preview.page.getByRole("button", { name: "New fold" }).click();
  await preview.page.getByLabel("Find in New fold").fill("pock");
  const folded = await preview.after("render", () => preview.page.keyboard.press("Enter"));
  assert.deepEqual(await preview.cards(), ["fold.pocket"]);
  assert.ok(folded.render.faces > before.render.faces);

  await preview.pickOf("fold.pocket", "Duplicate");
  await preview.card("fold.pocket_2").waitFor();
  const { edits } = await preview.document();
  assert.deepEqual(edits.fold.pocket_2, edits.fold.pocket);
  await preview.quiet();
  await preview.pickOf("fold.pocket_2", "Delete");
  await preview.card("fold.pocket_2").waitFor({ state: "detached" });
  await preview.quiet();
  assert.deepEqual((await preview.meshes()).render, folded.render);
  assertClean(preview);
});

test("a seam is renamed, turned off and on, and deleted", async (t) => {
  const preview = await show(t, example("tshirt.usda"));
  const before = await preview.meshes();
  await preview.page.getByRole("button", { name: "New seam" }).click();
  const sewn = await preview.after("render", () => preview.page.getByRole("menuitem", { name: "armholes" }).click());

  await preview.pickOf("seam.armholes", "Rename");
  const field = preview.page.getByLabel("Name of armholes");
  await field.fill("2nd one");
  assert.equal(await field.getAttribute("aria-invalid"), "true");
  await field.fill("sleeve");
  await field.press("Enter");
  await preview.card("seam.sleeve").waitFor();
  await preview.quiet();
  assert.deepEqual(await preview.cards(), ["seam.sleeve"]);
  assert.deepEqual(await preview.state(({ products }) => products.render.operators), ["seam.sleeve"]);
  assert.deepEqual((await preview.meshes()).render, sewn.render, "a name moves nothing");

  const onOff = preview.card("seam.sleeve").getByRole("switch", { name: "sleeve on" });
  assert.deepEqual((await preview.after("render", () => onOff.click())).render, before.render);
  assert.match(await preview.card("seam.sleeve").getAttribute("aria-label"), /off$/);
  assert.deepEqual((await preview.after("render", () => onOff.click())).render, sewn.render);
  const deleted = await preview.after("render", () => preview.pickOf("seam.sleeve", "Delete"));
  assert.deepEqual(deleted, before);
  assert.deepEqual([await preview.cards(), (await preview.document()).edits], [[], {}]);
  assertClean(preview);
});

test("a name is typed with spaces, and one that is taken is refused in words", async (t) => {
  const preview = await show(t, bareShirt(t));
  for (const set of ["borders.1", "borders.2"]) {
    await preview.evaluate((set) => preview.store.selector.take(set), set);
    await preview.when((set) => preview.store.state.selection?.expression === set, set);
    await preview.after("render", () => preview.page.keyboard.press("n"));
    const field = preview.page.getByLabel(/^Name of/);
    await field.fill("");
    await field.pressSequentially("hem line");
    await field.press("Enter");
    if (set === "borders.1") {
      await preview.card("seam.hem_line").waitFor();
      assert.deepEqual(await preview.cards(), ["seam.hem_line"]);
    }
  }
  await preview.page.getByText('there is a seam "hem_line" already').first().waitFor();
});

test("an operator of the garment is turned off in place of deleted, and keeps its name", async (t) => {
  const preview = await show(t, sewnShirt(t));
  assert.deepEqual(await preview.cards(), ["fold.neck", "seam.shoulder", "seam.side"]);
  await preview.card("seam.side").getByRole("button", { name: "More of side" }).click();
  const rename = preview.page.getByRole("menuitem", { name: "Rename" });
  assert.equal(await rename.getAttribute("aria-disabled"), "true");
  await preview.page.keyboard.press("Escape");
  const before = await preview.meshes();
  const after = await preview.after("render", () => preview.pickOf("seam.side", "Delete"));
  assert.ok(after.render.faces < before.render.faces);
  assert.deepEqual((await preview.document()).edits, { seam: { side: { enabled: false } } });
  assert.equal((await preview.cards()).length, 3);
  assert.equal(await preview.card("seam.side").getByRole("switch", { name: "side on" }).isChecked(), false);
  await preview.page.getByText("“side” is authored in the garment; turned off").waitFor();
  assertClean(preview);
});
