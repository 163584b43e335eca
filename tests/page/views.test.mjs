// Ways to look at a garment.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";
import { decode, differing, inked } from "./support/png.mjs";

const THIRDS = [
  [0, 1 / 3],
  [1 / 3, 2 / 3],
  [2 / 3, 1],
];

/** The picture after an action, which changes it and leaves a garment in each of the columns. */
async function changed(preview, before, what, act, columns = THIRDS, least = 0.01) {
  await act();
  await preview.quiet();
  const after = await preview.picture();
  for (const column of columns) assert.ok(inked(after, column) > 0.02, `${what}: the view is blank`);
  const share = differing(before, after);
  assert.ok(share > least, `${what} changes ${share} of the picture`);
  return after;
}

test("each shading draws the garments otherwise", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const shade = (name) =>
    page.getByRole("toolbar", { name: "Meshes and shading" }).getByRole("radio", { name }).check();
  let last = await preview.picture();
  const cloth = last;
  for (const name of ["Face sets", "UV checker", "Heat"]) last = await changed(preview, last, name, () => shade(name));

  const choice = page.getByRole("combobox", { name: "Heat of" });
  const names = await choice.locator("option").evaluateAll((options) => options.map(({ value }) => value));
  assert.ok(names.includes("simDensity") && names.includes("thicknessWeight"), names.join());
  const legend = page.locator("figure.legend");
  for (const name of ["thicknessWeight", "simDensity", "quality:length", "quality:angle"]) {
    if ((await choice.inputValue()) === name) continue;
    last = await changed(preview, last, name, async () => {
      await choice.selectOption(name);
      await preview.when((name) => preview.store.state.heat?.name === name, name);
    });
    assert.ok(await legend.isVisible());
  }
  assert.match(await legend.innerText(), /Smallest angle\s+[\d.]+°/);
  await shade("Cloth");
  await preview.quiet();
  assert.ok(differing(cloth, await preview.picture()) < 0.001, "cloth is as it was");
  assert.equal(await legend.count(), 0);
  assertClean(preview);
});

test("wires, edge sets, panels and smoothing change what is drawn, and their end brings it back", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const first = await preview.picture();
  const press = (name) => page.getByRole("toolbar", { name: "Drawing" }).getByRole("button", { name }).click();
  for (const [name, least] of [
    ["Wires", 0.01],
    ["Edge sets", 0.002],
    ["Flat panels", 0.05],
  ]) {
    const last = await changed(preview, first, name, () => press(name), THIRDS, least);
    await changed(preview, last, `${name} back`, () => press(name), THIRDS, least);
    assert.ok(differing(first, await preview.picture()) < 0.001, `${name} leaves nothing behind`);
  }
  const before = await preview.meshes();
  const smooth = page.getByRole("radiogroup", { name: "Display smoothing" }).getByRole("radio", { name: "1" });
  const last = await changed(preview, first, "smoothing", () => smooth.check(), THIRDS, 0.002);
  const after = await preview.meshes();
  assert.ok(after.model.faces > 3.9 * before.model.faces && after.render.faces > 3.9 * before.render.faces);
  assert.deepEqual(after.sim, before.sim, "triangles stay");
  const { edits } = await preview.document();
  assert.deepEqual(edits, {}, "what is shown is not an option");
  await changed(preview, last, "no smoothing", () => preview.settings({ smooth: 0 }), THIRDS, 0.002);
  assert.deepEqual(await preview.meshes(), before);
  assertClean(preview);
});

test("meshes are shown side by side or over one another, together or alone", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const side = await preview.picture();
  const middle = [[1 / 3, 2 / 3]];
  const layout = (name) => page.getByRole("radiogroup", { name: "Layout" }).getByRole("radio", { name }).check();
  const over = await changed(preview, side, "over", () => layout("Over one another"), middle);
  const alone = await changed(preview, over, "without the render mesh", () => page.keyboard.press("3"), middle, 0.001);
  await changed(preview, alone, "the model alone", () => page.keyboard.press("2"), middle, 0.001);
  assert.equal((await preview.meshes()).render, null);
  await page.keyboard.press("1");
  assert.deepEqual(await preview.state(({ settings }) => settings.roles), ["model"], "the last one stays");
  for (const key of ["2", "3"]) await page.keyboard.press(key);
  await layout("Side by side");
  await preview.isDrawn();
  assert.ok(differing(side, await preview.picture()) < 0.001, "all is as it was");
  assertClean(preview);
});

test("a mesh is shown alone by a double click on its name, or by Shift and its key, and all again", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const roles = () => preview.state(({ settings }) => settings.roles);
  const button = page.getByRole("group", { name: "Meshes" }).getByRole("button", { name: "Render" });
  await button.dblclick();
  assert.deepEqual(await roles(), ["render"]);
  await button.dblclick();
  assert.deepEqual(await roles(), ["model", "sim", "render"]);
  await page.keyboard.press("Shift+Digit2");
  assert.deepEqual(await roles(), ["sim"]);
  await page.keyboard.press("Shift+Digit1");
  assert.deepEqual(await roles(), ["model"]);
  await page.keyboard.press("Shift+Digit1");
  assert.deepEqual(await roles(), ["model", "sim", "render"]);
  assertClean(preview);
});

test("the garment is seen from each side, with all of it in view", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const sides = page.getByRole("group", { name: "Look from" });
  const seen = async (act) => {
    await act();
    await preview.quiet();
    return preview.picture();
  };
  const pictures = [await preview.picture()];
  for (const [key, name] of Object.entries({ 4: "front", 6: "back", 7: "top" })) {
    const picture = await seen(() => page.keyboard.press(key));
    for (const column of THIRDS) assert.ok(inked(picture, column) > 0.02, `${name}: the view is blank`);
    for (const other of pictures) assert.ok(differing(other, picture) > 0.01, `${name} is a side of its own`);
    pictures.push(picture);
  }
  const press = (name) => seen(() => sides.getByRole("button", { name, exact: true }).click());
  assert.ok(differing(pictures[1], await press("front")) < 0.002, "a button does as its key");
  assert.ok(differing(pictures[0], await press("three-quarter")) < 0.002, "the first view is at three quarters");
  await page.getByRole("toolbar", { name: "Drawing" }).getByRole("button", { name: "Flat panels" }).click();
  assert.ok(await sides.getByRole("button", { name: "back" }).isDisabled());
  assertClean(preview);
});

test("the camera is moved by the pointer, and F brings the garment back", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const first = await preview.picture();
  const box = await page.locator("canvas").boundingBox();
  const centre = [box.x + box.width / 2, box.y + box.height * 0.7];
  await page.mouse.move(...centre);
  await page.mouse.down();
  await page.mouse.move(centre[0] + 90, centre[1] + 20, { steps: 4 });
  await page.mouse.up();
  const turned = await preview.picture();
  assert.ok(differing(first, turned) > 0.02, "a drag turns");
  assert.equal(await page.locator(".pick").count(), 0, "a drag is not a click");
  await page.mouse.wheel(0, -400);
  const near = await preview.picture();
  assert.ok(inked(near) > 1.1 * inked(turned), "the wheel zooms");
  await page.keyboard.press("f");
  const framed = await preview.picture();
  assert.ok(inked(framed) < 0.95 * inked(near) && inked(framed) > 0.05);
  assertClean(preview);
});

test("the picture is saved as PNG", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const expected = await preview.picture();
  const started = preview.page.waitForEvent("download");
  await preview.page.getByRole("button", { name: "Screenshot" }).click();
  await preview.page.getByRole("menuitem", { name: "This view" }).click();
  const download = await started;
  assert.equal(download.suggestedFilename(), "tshirt.png");
  const image = decode(readFileSync(await download.path()));
  assert.deepEqual([image.width, image.height], [expected.width, expected.height]);
  assert.ok(differing(expected, image) < 0.01);
  assertClean(preview);
});
