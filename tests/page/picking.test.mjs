// Elements of the model are picked on any mesh, and on both sides of a symmetric garment.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { bareShirt } from "./support/garments.mjs";
import { placeOf, pointAt } from "./support/picking.mjs";

const selectionOf = (preview) => preview.state(({ selection }) => selection);

/** Waits for a selection with so many elements. */
const counts = (preview, count) => preview.when((count) => preview.store.state.selection?.count === count, count);

/** What the pointer finds at a place on the canvas; null where it finds nothing. */
async function hoverAt(preview, at) {
  const box = await preview.page.locator("canvas").boundingBox();
  await pointAt(preview, { x: box.x + at.x, y: box.y + at.y });
  const isThere = preview.when(() => preview.store.state.hovered !== null, undefined, 3000);
  if (!(await isThere.then(() => true, () => false))) return null;
  return preview.state(({ hovered, outlines }) => ({ ...hovered, outlines }));
}

/** The points of a mesh on the chest, where nothing lies before it and the camera looks at it from the front. */
const onChest = (role) => {
  const points = observed.points[role];
  const isThere = (at) => Math.abs(points[3 * at]) < 12 && points[3 * at + 1] > 95 && points[3 * at + 1] < 125 && points[3 * at + 2] > 5;
  return Array.from({ length: points.length / 3 }, (_, at) => at).filter(isThere);
};

/** Points at the middle of an edge on a mesh, by what is drawn where the pointer is near it. */
async function overEdge(preview, role) {
  const points = await preview.evaluate(onChest, role);
  for (const point of points.filter((_, at) => at % Math.ceil(points.length / 60) === 0)) {
    const at = await preview.evaluate(([role, point]) => preview.view.project(role, point), [role, point]);
    const near = at && (await hoverAt(preview, at));
    if (near?.role !== role || !near.edge) continue;
    const own = near.outlines.find(({ x, width }) => at.x >= x && at.x < x + width);
    const [a, b, c, d] = own.path.match(/[-\d.]+/g).map(Number);
    const found = await hoverAt(preview, { x: own.x + (a + c) / 2, y: own.y + (b + d) / 2 });
    if (found?.edge?.join() === near.edge.join()) return { ...found, point };
  }
  assert.fail(`no edge is found on the mesh ${role}`);
}

/** The distance of a place from an edge between two others. */
function fromEdge(place, a, b) {
  const dot = (u, v) => u.reduce((sum, value, axis) => sum + value * v[axis], 0);
  const [along, own] = [b, place].map((to) => to.map((value, axis) => value - a[axis]));
  const t = Math.min(Math.max(dot(own, along) / dot(along, along), 0), 1);
  return Math.hypot(...own.map((value, axis) => value - t * along[axis]));
}

for (const role of ["render", "sim"]) {
  test(`a click on the mesh ${role} takes the edge of the model below it, which is drawn on all meshes`, async (t) => {
    const preview = await show(t, bareShirt(t), { viewport: SCREEN });
    const { meanEdge } = await preview.state(({ garment }) => garment);
    const found = await overEdge(preview, role);
    const [a, b, place] = await preview.evaluate(
      ([role, point, edge]) => {
        const place = (points, at) => [...points.slice(3 * at, 3 * at + 3)];
        return [...edge.map((end) => place(observed.points.model, end)), place(observed.points[role], point)];
      },
      [role, found.point, found.edge],
    );
    assert.ok(fromEdge(place, a, b) < 0.5 * meanEdge, `from ${a} to ${b} is the edge at ${place}`);
    assert.deepEqual(found.outlines.map(({ path }) => path.startsWith("M")), [true, true, true], "it is drawn on three meshes");
    assert.equal(await preview.page.locator("svg.outline").count(), 3);
    const box = await preview.page.locator("canvas").boundingBox();
    const before = await preview.picture();
    await preview.page.mouse.click(box.x + found.x, box.y + found.y);
    await counts(preview, 1);
    const { elements } = await selectionOf(preview);
    assert.deepEqual([...elements.edges[0]].sort(), [...found.edge].sort());
    await preview.page.mouse.move(1, 1);
    const after = await preview.picture();
    assert.notDeepEqual(after.pixels, before.pixels, "the selection is drawn");
    assertClean(preview);
  });
}

test("an edge of the model is picked also where it is refined for display", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  await preview.after("model", () => preview.settings({ smooth: 1 }));
  const { edge, x, y } = await overEdge(preview, "model");
  const { points } = await preview.state(({ garment }) => garment);
  assert.ok(Math.max(...edge) < points, `${edge} are points of the model`);
  const box = await preview.page.locator("canvas").boundingBox();
  await preview.page.mouse.click(box.x + x, box.y + y);
  await counts(preview, 1);
  assert.deepEqual([...(await selectionOf(preview)).elements.edges[0]].sort(), [...edge].sort());
  assertClean(preview);
});

test("L says what it needs, takes the line, and then goes on straight through the junctions at its ends", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { keyboard } = preview.page;
  await keyboard.press("l");
  await preview.page.getByText("select edges or faces first").waitFor();
  // A seam that ends at others.
  const names = await preview.state(({ garment }) => garment.sets.map(({ name }) => name).filter((name) => /^uvSeams\.\d+$/.test(name)));
  let grown = 0;
  for (const name of names) {
    await preview.evaluate((name) => preview.store.selector.take(name), name);
    await preview.when((name) => preview.store.state.selection?.expression === name, name);
    await keyboard.press("l");
    const isLoop = () => Object.keys(preview.store.state.progress).length === 0 && observed.sent.at(-1).set?.startsWith("loops(");
    await preview.when(isLoop);
    await preview.quiet();
    const { count } = await selectionOf(preview);
    await keyboard.press("l");
    await preview.when(() => observed.sent.at(-1).set?.startsWith("onward("));
    await preview.quiet();
    const more = (await selectionOf(preview)).count;
    assert.ok(more >= count, `${name}: ${count}, then ${more}`);
    grown += Number(more > count);
  }
  assert.ok(grown > 0, "some seam goes on");
  assertClean(preview);
});

test("both sides are selected, sewn and edited at once, and one switch ends it", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { page } = preview;
  await page.getByRole("button", { name: "Both sides" }).click();
  const mirror = await preview.state(({ garment }) => garment.mirror);
  assert.equal(mirror.axis, "x");
  const seams = Object.entries(mirror.twins).filter(([name, twin]) => /^uvSeams\.\d+$/.test(name) && twin !== name);
  assert.ok(seams.length > 1, "seams have twins");

  const seam = await placeOf(preview, "uvSeams");
  await page.mouse.click(seam.x, seam.y);
  await counts(preview, 2);
  const { elements } = await selectionOf(preview);
  const places = await preview.evaluate(
    (edges) => edges.map((edge) => edge.map((point) => [...observed.points.model.slice(3 * point, 3 * point + 3)])),
    elements.edges,
  );
  const middles = places.map(([a, b]) => a.map((value, axis) => (value + b[axis]) / 2));
  assert.ok(Math.abs(middles[0][0] + middles[1][0]) < 0.5, `one is on each side: ${middles}`);
  await page.keyboard.press("l");
  await preview.when(() => preview.store.state.selection?.count > 2);
  await preview.after("render", () => page.keyboard.press("n"));
  await page.keyboard.press("Enter");
  const [both] = await preview.cards();
  assert.equal((await preview.cards()).length, 1, "one seam has both sides");
  await preview.after("render", () => page.keyboard.press("Control+z"));

  const [left, right] = seams[0];
  const sewn = { seam: { left: { edges: [left], width: 0.4 }, right: { edges: [right], width: 0.4 } } };
  await preview.after("render", () => preview.evaluate((sewn) => preview.store.edit(() => sewn), sewn));
  assert.match(await preview.card("seam.left").innerText(), /⇄ right/);
  assert.match(await preview.card("seam.right").innerText(), /⇄ left/);
  await preview.openCard("seam.left");
  const widths = async () => {
    const { edits } = await preview.document();
    return [edits.seam.left.width, edits.seam.right.width];
  };
  await preview.after("render", async () => {
    await preview.field("seam.left.width").fill("0.6");
    await page.keyboard.press("Enter");
  });
  assert.deepEqual(await widths(), [0.6, 0.6]);
  await page.locator("canvas").focus();
  await page.keyboard.press("y");
  await preview.when(() => !preview.store.state.settings.symmetric);
  assert.doesNotMatch(await preview.card("seam.left").innerText(), /⇄/);
  await preview.after("render", async () => {
    await preview.field("seam.left.width").fill("0.5");
    await page.keyboard.press("Enter");
  });
  assert.deepEqual(await widths(), [0.5, 0.6], `${both} was undone, and one side is edited`);
  assertClean(preview);
});
