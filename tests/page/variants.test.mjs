// Variants of the garment are chosen in the page.

import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { assertSame, build, variantSheet } from "./support/garments.mjs";

test("a variant changes the mesh, and a saved layer keeps it", async (t) => {
  const garment = variantSheet(t);
  const authored = readFileSync(garment, "utf8");
  const preview = await show(t, garment);
  const { page } = preview;
  await page.getByRole("button", { name: "New seam" }).click();
  await preview.after("render", () => page.getByRole("menuitem", { name: "fold" }).click());
  const choice = page.getByLabel("Variant cut");
  assert.deepEqual(await choice.locator("option").allInnerTexts(), ["long", "short"].sort());
  assert.equal(await choice.inputValue(), "short");
  const short = await preview.meshes();
  const long = await preview.after("model", () => choice.selectOption("long"));
  for (const role of ["sim", "render"]) assert.notEqual(long[role].checksum, short[role].checksum, role);
  assert.equal(await choice.inputValue(), "long");
  assert.deepEqual(Object.keys((await preview.document()).edits), ["seam"], "edits stay");

  await page.getByRole("button", { name: "Save" }).click();
  const dialog = page.getByRole("dialog", { name: "Save the edits" });
  const submit = dialog.locator('button[type="submit"]');
  const recipe = join(dirname(garment), "sheet.tailor");
  await dialog.getByRole("radio", { name: ".tailor file" }).check();
  await dialog.getByRole("alert").waitFor();
  assert.match(await dialog.getByRole("alert").innerText(), /variants/);
  if (await submit.isEnabled()) await submit.click();
  await preview.quiet();
  assert.ok(!existsSync(recipe) && (await dialog.isVisible()), "a .tailor file holds no variants");

  const file = join(dirname(garment), "sheet_look.usda");
  await dialog.getByRole("radio", { name: "USD layer" }).check();
  await preview.when((file) => preview.store.state.save?.path === file, file);
  assert.match(await dialog.locator("pre").innerText(), /string "?cut"? = "long"/);
  await submit.click();
  await dialog.waitFor({ state: "detached" });
  const built = await build(t, file);
  for (const role of ["sim", "render"]) assertSame(await preview.points(role), built[role], role);
  assert.equal(readFileSync(garment, "utf8"), authored);

  assert.deepEqual(await preview.after("model", () => choice.selectOption("short")), short);
  assertClean(preview);
});
