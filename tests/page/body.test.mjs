// The body under a garment.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { body, SHEET } from "./support/bodies.mjs";
import { sheetFile } from "./support/garments.mjs";

test("a body is drawn under the garment, hidden and shown, and what crosses it is named", async (t) => {
  const garment = sheetFile(t, SHEET);
  const file = body(join(dirname(garment), "box.usda"), [0.4, 0.4, -3], [1.6, 1.6, 0.5]);
  const preview = await show(t, garment, { args: ["--body", file] });
  const { page } = preview;
  const button = page.getByRole("button", { name: "Body", exact: true });
  await button.waitFor();
  assert.equal(await button.getAttribute("aria-pressed"), "true");
  assert.match(await button.getAttribute("title"), /box\.usda/);
  await preview.when(() => preview.store.view.hasBody());
  const crossing = await preview.state(({ garment }) => garment.warnings.find(({ code }) => code === "fit-crosses"));
  assert.match(crossing.problem, /4 faces cross the body/);
  assert.deepEqual(crossing.elements.faces.toSorted((a, b) => a - b), [0, 1, 4, 5]);

  await button.click();
  await preview.when(() => !preview.store.view.hasBody());
  assert.equal(await button.getAttribute("aria-pressed"), "false");
  await button.click();
  await preview.when(() => preview.store.view.hasBody());

  // A body that is mended is read again.
  body(file, [0.4, 0.4, -3], [1.6, 1.6, -0.5]);
  await preview.when(() => !preview.store.state.garment.warnings.some(({ code }) => code === "fit-crosses"));
  assertClean(preview);
});

test("without a body there is no button", async (t) => {
  const preview = await show(t, sheetFile(t, SHEET));
  assert.equal(await preview.page.getByRole("button", { name: "Body", exact: true }).count(), 0);
  assertClean(preview);
});

test("the body of the recipe is the one that is shown", async (t) => {
  const garment = sheetFile(t, SHEET);
  const folder = dirname(garment);
  body(join(folder, "thin.usda"), [0, 0, -2], [4, 4, -0.5]);
  body(join(folder, "thick.usda"), [0, 0, -2], [4, 4, 0.5]);
  const recipe = join(folder, "sheet.tailor");
  writeFileSync(recipe, JSON.stringify({ source: "sheet.usda", fit: { from: "thin.usda", to: "thick.usda" } }));
  const preview = await show(t, recipe);
  await preview.when(() => preview.store.view.hasBody());
  assert.match(await preview.state(({ garment }) => garment.body), /thick\.usda/);
  // The cloth lay half a unit over the thin body, and lies as far over the thick one.
  const heights = Array.from(await preview.points("model")).filter((_, at) => at % 3 === 2);
  assert.ok(Math.min(...heights) > 0.6, `${heights}`);

  const slider = preview.page.getByRole("slider", { name: "Share of the fit" });
  const heightsAt = async (share) => {
    await slider.fill(String(share));
    await preview.when((share) => preview.store.state.fit.share === share, share);
    await preview.quiet();
    return Array.from(await preview.points("model")).filter((_, at) => at % 3 === 2);
  };
  assert.equal(Math.max(...(await heightsAt(0)).map(Math.abs)), 0, "the garment as it was made");
  const half = await heightsAt(0.5);
  assert.ok(Math.min(...half) > 0.2 && Math.max(...half) < Math.max(...heights), `${half}`);
  assert.match(await slider.getAttribute("aria-valuetext"), /50 %, nothing crosses/);
  assert.deepEqual(await heightsAt(1), heights);
  assertClean(preview);
});
