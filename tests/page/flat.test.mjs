// UV panels, the checker, and edge sets with their legend.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";
import { example } from "./support/server.mjs";
import { pointAt } from "./support/picking.mjs";
import { inked } from "./support/png.mjs";

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
  const names = await preview.evaluate(() => preview.view.edgeSets());
  assert.ok(names.includes("armholes") && names.includes("side_seams"), names.join());
  assert.deepEqual(await legend.getByRole("button").allInnerTexts(), names.map((name) => name.replaceAll("_", " ")));
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
  for (const name of ["front", "back", "sleeve left"]) assert.ok(names.includes(name), names.join());
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

test("names of flat panels cover neither each other nor other panels", async (t) => {
  const preview = await show(t, example("sewn/coat.usda"), { viewport: SCREEN });
  const { page } = preview;
  await preview.settings({ roles: ["sim"], flat: true, shadows: false });
  const names = page.locator(".plan-label");
  await names.first().waitFor();
  await preview.isStill();
  const canvas = await page.locator("canvas").boundingBox();
  const panels = await preview.state(({ plan }) => plan[0].panels);
  const labels = await names.evaluateAll((all) => all.map((one) => ({ name: one.textContent.replaceAll("\n", " "), ...one.getBoundingClientRect().toJSON() })));
  // What is written, and not the room for it.
  const overflow = await names.evaluateAll((all) => all.filter((one) => one.scrollWidth > one.clientWidth + 1).map((one) => one.textContent));
  assert.deepEqual(overflow, []);
  const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
  for (const label of labels) {
    assert.deepEqual(labels.filter((other) => other !== label && overlap(label, other)), [], label.name);
    const at = { ...label, x: label.x - canvas.x, y: label.y - canvas.y };
    const covered = panels.filter(({ name }) => name.replaceAll("_", " ") !== label.name).filter((panel) => overlap(at, panel));
    // A name in the middle of its own panel may reach the box of a curved neighbour.
    const own = panels.find(({ name }) => name.replaceAll("_", " ") === label.name);
    if (!overlap(at, own)) assert.deepEqual(covered, [], label.name);
  }
  assert.ok(labels.length > 0.8 * panels.length, `${labels.length} of ${panels.length} panels have their name`);
  assertClean(preview);
});

test("flat panels have the mesh in space beside them, and what the pointer is on is marked in both", async (t) => {
  const preview = await show(t, sewnShirt(t), { viewport: SCREEN });
  const { page } = preview;
  await preview.settings({ layout: "large", large: "model", flat: true, shadows: false, wires: false });
  await preview.isStill();
  const box = await page.locator("canvas").boundingBox();
  const place = (point, flat) => preview.evaluate(([point, flat]) => preview.view.project("model", point, flat), [point, flat]);
  const middle = async (edge, flat) => {
    const [a, b] = await Promise.all(edge.map((point) => place(point, flat)));
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
  };
  const hover = async ({ x, y }) => {
    await pointAt(preview, { x: box.x + x, y: box.y + y });
    await preview.when(() => preview.store.state.hovered !== null);
    return preview.state(({ hovered }) => hovered);
  };

  /** Points that are inside a panel and in view: their edges are at one place of each. */
  const points = await preview.evaluate(() => {
    const count = preview.view.stats("model").points;
    const { sets, numbers } = observed.elements.model;
    const { offset, length } = sets.find(({ name }) => name === "uvSeams");
    const cut = new Set(numbers.slice(offset, offset + length));
    const inView = (point) => [true, false].every((flat) => preview.view.project("model", point, flat) !== null);
    return [...Array(count).keys()].filter((point) => !cut.has(point) && inView(point));
  });
  for (const flat of [true, false]) {
    let edge = null;
    for (let at = 0; at < points.length && edge === null; at += 7) {
      const found = await hover(await place(points[at], flat));
      edge = found?.edge?.every((point) => points.includes(point)) ? found.edge : null;
    }
    // At a point several edges are as near as one another.
    const found = await hover(await middle(edge, flat));
    assert.deepEqual([...found.edge].sort(), [...edge].sort());
    const there = await middle(edge, !flat);
    // The middle of the line that is drawn on the mesh as it is seen in the other way.
    const drawn = (await preview.state(({ outlines }) => outlines)).map(({ x, y, path }) => {
      const [a, b, c, d] = path.match(/[-\d.]+/g).map(Number);
      return { x: x + (a + c) / 2, y: y + (b + d) / 2 };
    });
    const near = drawn.some(({ x, y }) => Math.hypot(x - there.x, y - there.y) < 4);
    assert.ok(near, `${flat ? "in space" : "on the panels"} it is marked at ${JSON.stringify([there, drawn])}`);
    await page.mouse.move(1, 1);
    await preview.when(() => preview.store.state.hovered === null);
    assert.equal(await page.locator("svg.outline").count(), 0);
  }

  // Also where a split view began in space, which needs no UVs.
  await preview.settings({ flat: false });
  await page.keyboard.press("x");
  await preview.settings({ flat: true });
  await preview.quiet();
  await page.mouse.move(1, 1);
  assert.ok(inked(await preview.picture(), [0, 0.2]) > 0.05, "the panels that were kept are there");
  const places = await Promise.all(points.map((point) => place(point, true)));
  const { x } = await page.getByRole("slider", { name: "Split" }).first().boundingBox();
  assert.ok(await hover(places.find((at) => box.x + at.x < x - 20)), "the pointer finds them");
  await page.keyboard.press("x");

  const aim = () => preview.evaluate(() => preview.view.aim());
  const plan = () => preview.state(({ plan }) => plan[0].panels.map(({ x, y }) => [Math.round(x), Math.round(y)]));
  const drag = async (x) => {
    await page.mouse.move(box.x + x, box.y + 560);
    await page.mouse.down();
    await page.mouse.move(box.x + x + 60, box.y + 560, { steps: 3 });
    await page.mouse.up();
    await preview.isStill();
  };
  const [first, panels] = [await aim(), await plan()];
  await drag(120);
  assert.deepEqual(await aim(), first, "a drag of the panels leaves the view in space");
  const moved = await plan();
  assert.notDeepEqual(moved, panels);
  await drag(box.width - 200);
  assert.deepEqual(await plan(), moved, "a drag in space leaves the panels");
  assert.notDeepEqual((await aim()).direction, first.direction);
  assertClean(preview);
});
