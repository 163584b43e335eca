// Heat: fixed scales, how many values are where on them, and the way to the worst.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";

test("heat has fixed scales with a histogram, and flies to the worst triangle", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const legend = preview.page.locator("figure.legend");
  const scale = async (values, role) => {
    await preview.settings({ roles: [role], shading: "values", values, shadows: false });
    await preview.when((name) => preview.store.state.heat?.name === name, values);
    await preview.quiet();
    return legend.locator(".legend-scale span").allInnerTexts();
  };
  const counted = () =>
    legend.locator("rect").evaluateAll((bars) => bars.reduce((sum, { dataset }) => sum + Number(dataset.count), 0));

  assert.deepEqual(await scale("thicknessWeight", "model"), ["0", "0.5", "1"]);
  assert.equal(await counted(), (await preview.meshes()).model.points);
  assert.equal(await legend.getByRole("button").count(), 0, "a weight has no worst value");

  assert.deepEqual(await scale("quality:length", "sim"), ["0.5×", "1×", "2×"]);
  assert.equal(await counted(), (await preview.meshes()).sim.faces);
  assert.deepEqual(await scale("quality:angle", "sim"), ["0°", "30°", "60°"]);

  const before = await preview.evaluate(() => preview.view.aim());
  await legend.getByRole("button", { name: "Fly to the worst" }).click();
  const after = await preview.evaluate(() => preview.view.aim());
  assert.ok(after.distance < before.distance / 2, `from ${before.distance} to ${after.distance}`);
  assertClean(preview);
});
