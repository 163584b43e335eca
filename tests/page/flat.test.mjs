// UV panels, the checker, and edge sets with their legend.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";

/** Degrees from 0 to 360 of a colour such as `#8090a0`. */
function hue(colour) {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  return ((Math.atan2(Math.sqrt(3) * (g - b), 2 * r - g - b) * 180) / Math.PI + 360) % 360;
}

test("the legend names edge sets in colours that differ, highlights and selects them", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const legend = preview.page.getByRole("region", { name: "Edge sets on view" });
  assert.equal(await legend.count(), 0);
  await preview.settings({ roles: ["model"], edgeSets: true, shadows: false });
  const names = await legend.getByRole("button").allInnerTexts();
  assert.ok(names.includes("armholes") && names.includes("side_seams"), names.join());
  assert.deepEqual(names, [...names].sort(new Intl.Collator("en", { numeric: true }).compare));

  // Names that were seen before change no colours.
  const colours = () => preview.evaluate((names) => names.map((name) => preview.view.colourOf(name)), names);
  const before = await colours();
  await preview.evaluate(() => preview.view.setGarment({ ...preview.store.state.garment, sets: [...preview.store.state.garment.sets].reverse() }));
  assert.deepEqual(await colours(), before, "the order of the file changes no colours");
  const all = await preview.evaluate(() => {
    const edges = preview.store.state.garment.sets.filter(({ kind }) => kind === "edge").map(({ name }) => name);
    const sorted = [...edges, "UV seams"].sort(new Intl.Collator("en", { numeric: true }).compare);
    return sorted.map((name) => preview.view.colourOf(name));
  });
  const turns = all.slice(1).map((colour, i) => Math.abs(((hue(colour) - hue(all[i]) + 540) % 360) - 180));
  assert.ok(Math.min(...turns) > 60, `neighbours differ by ${turns.map(Math.round)} degrees`);

  const armholes = legend.getByRole("button", { name: "armholes" });
  await armholes.click();
  await preview.when(() => preview.store.state.selection?.expression === "armholes");
  assertClean(preview);
});

test("a square of the checker is a round length of the garment", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const legend = preview.page.getByRole("figure", { name: "UV checker" });
  await preview.settings({ roles: ["model"], shading: "checker", shadows: false });
  await legend.waitFor();
  assert.match(await legend.innerText(), /one square: (1|2|5|10) cm/);
  assertClean(preview);
});

test("flat panels have their names, a scale bar and the direction of the warp", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const notes = page.getByRole("group", { name: "Panels" });
  assert.equal(await notes.count(), 0);
  await preview.settings({ roles: ["model"], flat: true, shadows: false });
  await notes.waitFor();
  const names = await notes.locator(".plan-label").allInnerTexts();
  for (const name of ["front", "back", "sleeve_left"]) assert.ok(names.includes(name), names.join());
  assert.ok(!names.includes("sleeves"), "a set of several panels is the name of none");

  // The unit is the length of a seam on the canvas for its length on the garment, if both ends are of one panel.
  const ratios = await preview.evaluate(() => {
    const { sets, numbers } = observed.elements.model;
    const { offset, length } = sets.find(({ name }) => name === "side_seams");
    const at = (point) => observed.points.model.subarray(3 * point, 3 * point + 3);
    const all = [];
    for (let i = offset; i < offset + length; i += 2) {
      const [p, q] = [numbers[i], numbers[i + 1]];
      const [a, b] = [p, q].map((point) => preview.view.project("model", point));
      const long = Math.hypot(...at(p).map((value, axis) => value - at(q)[axis]));
      if (a && b) all.push(Math.hypot(a.x - b.x, a.y - b.y) / (long * preview.store.state.plan[0].unit));
    }
    return all.sort((a, b) => a - b);
  });
  const middle = ratios[ratios.length >> 1];
  assert.ok(Math.abs(middle - 1) < 0.15, `the seam is ${middle} of its length`);

  const bar = async () => {
    const scale = page.locator(".plan-scale");
    const { width } = await scale.locator("i").boundingBox();
    return width / parseFloat(/([\d.]+) cm/.exec(await scale.innerText())[1]);
  };
  const before = await bar();
  const box = await page.locator("canvas").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const { unit } = await preview.state(({ plan }) => plan[0]);
  await page.mouse.wheel(0, -300);
  await preview.when((unit) => preview.store.state.plan[0].unit > 1.2 * unit, unit);
  assert.ok((await bar()) > 1.2 * before, "the bar follows the zoom");

  const warp = page.locator(".plan-warp");
  assert.equal(await warp.getAttribute("data-warp"), "v");
  await preview.set("cloth.warp", "u");
  await preview.when(() => document.querySelector(".plan-warp").dataset.warp === "u");
  await preview.settings({ flat: false });
  await preview.when(() => document.querySelector(".plan-scale") === null);
  assertClean(preview);
});
