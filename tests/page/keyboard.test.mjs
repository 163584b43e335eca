// The page without a pointer, for screen readers, and as the system asks for it.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, open, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";
import { brightness, differing } from "./support/png.mjs";
import { example, Server } from "./support/server.mjs";
import { nameless } from "./support/layout.mjs";

test("tabs reach a slider soon, which arrow keys then move", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const seen = [];
  for (let i = 0; i < 40 && seen.at(-1) !== "range"; i++) {
    await page.keyboard.press("Tab");
    seen.push(await preview.evaluate(() => document.activeElement.type ?? document.activeElement.tagName));
  }
  assert.equal(seen.at(-1), "range", seen.join());
  const key = await preview.evaluate(() => document.activeElement.closest("[data-key]").dataset.key);
  assert.equal(key, "sim.maxEdgeLength");
  await preview.after("sim", () => page.keyboard.press("Shift+ArrowRight"));
  await page.keyboard.press("Shift+Tab");
  await page.keyboard.press("Tab");
  assert.equal(await preview.evaluate(() => document.activeElement.type), "range", "and back");
  assertClean(preview);
});

test("a seam is made, opened and deleted by keys alone", async (t) => {
  const preview = await show(t, example("tshirt.usda"));
  const { page } = preview;
  const before = await preview.meshes();
  await page.getByRole("button", { name: "New seam" }).focus();
  await page.keyboard.press("Enter");
  await page.keyboard.type("chest");
  await preview.after("render", () => page.keyboard.press("Enter"));
  await page.waitForFunction(() => document.activeElement.getAttribute("aria-label") === "Name of chest_line");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.activeElement.dataset.card === "seam.chest_line");
  const body = preview.card("seam.chest_line").locator(".card-body");
  await body.waitFor();
  await page.keyboard.press("Enter");
  await body.waitFor({ state: "detached" });
  await preview.card("seam.chest_line").getByRole("button", { name: "More of chest_line" }).focus();
  await page.keyboard.press("Enter");
  await page.keyboard.press("ArrowUp");
  assert.deepEqual(await preview.after("render", () => page.keyboard.press("Enter")), before);
  assertClean(preview);
});

test("all controls have a name that a screen reader can say", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  assert.deepEqual(await preview.evaluate(nameless), [], "at first");
  await preview.openCard("seam.side");
  await page.getByRole("button", { name: "More", exact: true }).or(page.locator("button.more")).first().click();
  await page.getByRole("button", { name: "Show figures" }).click();
  await preview.settings({ shading: "values" });
  await page.getByRole("button", { name: "More of side" }).click();
  assert.deepEqual(await preview.evaluate(nameless), [], "with cards, figures and a menu open");
  await page.keyboard.press("Escape");
  await page.keyboard.press("Control+s");
  await page.getByRole("dialog", { name: "Save the edits" }).waitFor();
  assert.deepEqual(await preview.evaluate(nameless), [], "with the dialog open");
  assert.equal(await page.evaluate(() => document.documentElement.lang), "en");
  assertClean(preview);
});

test("the keys are listed at ?, and Escape closes the list", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const { page } = preview;
  const dialog = page.getByRole("dialog", { name: "Keys" });
  await page.keyboard.press("?");
  await dialog.waitFor();
  assert.match(await dialog.innerText(), /Undo[\s\S]+Save[\s\S]+usdtailor \d/);
  const before = await preview.state(({ settings }) => settings.wires);
  await page.keyboard.press("w");
  assert.equal(await preview.state(({ settings }) => settings.wires), before, "keys of the page rest");
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "detached" });
  await page.keyboard.press("w");
  assert.equal(await preview.state(({ settings }) => settings.wires), !before);
  await preview.field("render.level").focus();
  await page.keyboard.press("w");
  assert.equal(await preview.state(({ settings }) => settings.wires), !before, "a field takes letters");
  assertClean(preview);
});

test("light and dark follow the system until one is chosen, which is remembered", async (t) => {
  const preview = await show(t, sewnShirt(t), { colorScheme: "light" });
  const { page } = preview;
  const theme = () => preview.evaluate(() => document.documentElement.dataset.theme);
  const ground = () => preview.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const [light, lightGround] = [await preview.picture(), await ground()];
  await page.emulateMedia({ colorScheme: "dark" });
  await preview.when(() => document.documentElement.dataset.theme === "dark");
  const dark = await preview.picture();
  assert.ok(brightness(dark) < 0.7 * brightness(light) && differing(light, dark) > 0.5);
  assert.notEqual(await ground(), lightGround);
  await page.getByRole("button", { name: "Light theme" }).click();
  assert.deepEqual([await theme(), await ground()], ["light", lightGround]);
  await page.reload();
  await preview.isDrawn();
  assert.equal(await theme(), "light", "the system is dark, and light was chosen");
  assertClean(preview);
});

test("nothing flies and nothing glides for whom motion is too much", async (t) => {
  const server = await Server.start(t, sewnShirt(t));
  const moves = async (reducedMotion) => {
    const preview = await open(t, server, { reducedMotion });
    const flies = await preview.evaluate(() => {
      const place = () => JSON.stringify(preview.view.project("model", 0));
      const before = place();
      preview.view.mark({ role: "model", elements: { points: [0, 1] } });
      return place() === before;
    });
    const glides = await preview.evaluate(
      () =>
        [...document.querySelectorAll("*")].filter((element) => {
          const { transitionDuration, animationDuration } = getComputedStyle(element);
          return [transitionDuration, animationDuration].some((time) => Number.parseFloat(time) > 0.011);
        }).length,
    );
    await preview.picture();
    const place = await preview.evaluate(() => preview.view.project("model", 0));
    assertClean(preview);
    return { flies, place, glides };
  };
  const usual = await moves("no-preference");
  assert.ok(usual.flies && usual.glides > 0, "the camera takes its time");
  const reduced = await moves("reduce");
  assert.ok(!reduced.flies && reduced.glides === 0, JSON.stringify(reduced));
  assert.ok(Math.hypot(usual.place.x - reduced.place.x, usual.place.y - reduced.place.y) < 1, "both arrive");
});
