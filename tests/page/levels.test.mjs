// Levels of detail in the page.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";
import { run, temporaryFolder } from "./support/server.mjs";

test("each level shows the meshes that a build writes of it", async (t) => {
  const garment = sewnShirt(t);
  const preview = await show(t, garment);
  const { page } = preview;
  const levels = page.getByRole("radiogroup", { name: "Level of detail" });
  assert.equal(await levels.count(), 0, "there is one level");
  const row = page.locator('[data-key="lod.levels"]');
  await row.getByRole("spinbutton").fill("3");
  await row.getByRole("spinbutton").press("Enter");
  await levels.waitFor();
  await preview.quiet();
  const report = join(temporaryFolder(t), "report.json");
  await run("build", garment, "--lods", "3", "-o", join(temporaryFolder(t), "built.usda"), "--report", report, "--quiet");
  const built = JSON.parse(readFileSync(report, "utf8"));
  const wanted = [built, ...built.levels].map(({ sim, render }) => [sim.faces, render.faces]);
  const shown = () => preview.state(({ products }) => ["sim", "render"].map((role) => products[role].figures.faces));
  assert.deepEqual(await shown(), wanted[0]);
  for (const level of [1, 2, 0]) {
    await preview.after("sim", () => levels.getByRole("radio", { name: `LOD${level}` }).click());
    await preview.quiet();
    assert.deepEqual(await shown(), wanted[level]);
    assert.equal(await preview.state(({ document }) => document.level), level);
  }
  // The last level that there is.
  await preview.after("sim", () => levels.getByRole("radio", { name: "LOD2" }).click());
  await preview.after("sim", async () => {
    await row.getByRole("spinbutton").fill("2");
    await row.getByRole("spinbutton").press("Enter");
  });
  await preview.quiet();
  assert.deepEqual(await shown(), wanted[1]);
  assertClean(preview);
});
