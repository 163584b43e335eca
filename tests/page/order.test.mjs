// Operators are put into another order.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";

const USUAL = ["fold.neck", "seam.shoulder", "seam.side"];

/** A page with the cards in the middle of the panel, which scrolls if a card is dragged to its ends. */
async function shirt(t) {
  const preview = await show(t, sewnShirt(t), { viewport: { width: 720, height: 700 } });
  await preview.page.getByRole("button", { name: "Simulation mesh", exact: true }).click();
  await preview.row("sim.maxEdgeLength").waitFor({ state: "detached" });
  return preview;
}

const ran = ({ products }) => products.render.operators;

/** Drags a card by its handle so far that its middle is below, or above, that of another. */
async function dragCard(preview, full, onto) {
  const page = preview.page;
  const handle = preview.card(full).locator(".handle");
  const [start, from, to] = await Promise.all(
    [handle, preview.card(full), preview.card(onto)].map((at) => at.boundingBox()),
  );
  const x = start.x + start.width / 2;
  const y = start.y + start.height / 2;
  const way = to.y - from.y + Math.sign(to.y - from.y) * 3;
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 6; i++) await page.mouse.move(x, y + (way * i) / 6);
  await page.mouse.up();
}

test("a card that is dragged arrives in the order, and operators run in it", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  assert.deepEqual(await preview.cards(), USUAL);
  const after = await preview.after("render", () => dragCard(preview, "fold.neck", "seam.shoulder"));
  const order = ["seam.shoulder", "fold.neck", "seam.side"];
  assert.deepEqual(await preview.cards(), order);
  assert.deepEqual((await preview.document()).edits, { render: { operators: order } });
  assert.deepEqual(await preview.state(ran), order);
  assert.deepEqual(after.sim, before.sim);

  const back = await preview.after("render", () => dragCard(preview, "fold.neck", "seam.shoulder"));
  assert.deepEqual(back, before);
  assert.deepEqual((await preview.document()).edits, {}, "the usual order needs no list");
  assertClean(preview);
});

test("a drag that Escape ends changes nothing", async (t) => {
  const preview = await shirt(t);
  const { x, y } = await preview.card("fold.neck").locator(".handle").boundingBox();
  await preview.page.mouse.move(x + 5, y + 5);
  await preview.page.mouse.down();
  await preview.page.mouse.move(x + 5, y + 90, { steps: 4 });
  await preview.page.locator('.is-dragged[data-card="fold.neck"]').waitFor();
  await preview.page.keyboard.press("Escape");
  await preview.page.locator(".is-dragged").waitFor({ state: "detached" });
  await preview.page.mouse.up();
  await preview.quiet();
  assert.deepEqual(await preview.cards(), USUAL);
  assert.deepEqual((await preview.document()).edits, {});
});

test("Alt and arrow keys move the focused card, which keeps the focus", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const before = await preview.meshes();
  const focused = () => preview.evaluate(() => document.activeElement.dataset.card);
  await preview.card("seam.side").focus();
  await preview.page.keyboard.press("Alt+ArrowUp");
  const order = ["fold.neck", "seam.side", "seam.shoulder"];
  await preview.when((order) => preview.store.state.products.render.operators.join() === order, order.join());
  await preview.quiet();
  assert.deepEqual([await preview.cards(), await focused()], [order, "seam.side"]);
  assert.deepEqual((await preview.document()).edits, { render: { operators: order } });
  assert.match(await preview.state(({ spoken }) => spoken), /seam\.side is now 2 of 3/);
  assert.equal((await preview.meshes()).render.faces, before.render.faces, "both seams are still made");

  await preview.card("fold.neck").focus();
  await preview.page.keyboard.press("Alt+ArrowUp");
  await preview.quiet();
  assert.deepEqual(await preview.cards(), order, "the first stays");
  await preview.card("seam.side").focus();
  await preview.page.keyboard.press("Alt+ArrowDown");
  await preview.when((order) => preview.store.state.products.render.operators.join() === order, USUAL.join());
  await preview.quiet();
  assert.deepEqual([await preview.cards(), await preview.meshes()], [USUAL, before]);
  assertClean(preview);
});

test("a focus that goes to another card right after a move stays there", async (t) => {
  const preview = await show(t, sewnShirt(t));
  await preview.card("fold.neck").focus();
  const focused = await preview.evaluate(async () => {
    const key = new KeyboardEvent("keydown", { key: "ArrowUp", altKey: true, bubbles: true, cancelable: true });
    document.activeElement.dispatchEvent(key);
    document.querySelector('[data-card="seam.side"]').focus();
    for (let frame = 0; frame < 4; frame++) await new Promise(requestAnimationFrame);
    return document.activeElement.dataset.card;
  });
  assert.equal(focused, "seam.side");
  assertClean(preview);
});

test("a card moves twice before the first move is answered", async (t) => {
  const preview = await show(t, sewnShirt(t));
  await preview.card("seam.side").focus();
  await preview.page.keyboard.press("Alt+ArrowUp");
  await preview.page.keyboard.press("Alt+ArrowUp");
  const order = ["seam.side", "fold.neck", "seam.shoulder"];
  await preview.when((order) => preview.store.state.products.render.operators.join() === order, order.join());
  await preview.quiet();
  assert.deepEqual(await preview.cards(), order);
  assertClean(preview);
});
