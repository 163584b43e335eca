// Several pages, and pages whose server is gone.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, open } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";
import { Server } from "./support/server.mjs";

const OFFSET = "seam.side.normalOffset";

test("two pages show the same, and each undoes what the other did", async (t) => {
  const server = await Server.start(t, sewnShirt(t));
  const [one, other] = [await open(t, server), await open(t, server)];
  const first = await one.meshes();
  assert.deepEqual(await other.meshes(), first);

  const edited = await other.after("render", () => one.drag("render.level", 0.5, 3));
  await one.quiet();
  assert.deepEqual(await one.meshes(), edited);
  const { edits, unsaved } = await other.document();
  assert.deepEqual([edits, unsaved], [(await one.document()).edits, true]);
  assert.equal(await other.field("render.level").inputValue(), String(edits.render.level));

  const undone = await one.after("render", () => other.page.keyboard.press("Control+z"));
  await other.quiet();
  assert.deepEqual([undone, await other.meshes()], [first, first]);
  assert.equal((await one.document()).canUndo, false);

  // Edits of both at once: both end with the same.
  await Promise.all([one.set(OFFSET, -0.5), other.set(OFFSET, -0.6)]);
  await Promise.all([one.quiet(), other.quiet()]);
  assert.deepEqual(await one.meshes(), await other.meshes());
  assert.deepEqual((await one.document()).edits, (await other.document()).edits);
  [one, other].forEach(assertClean);
});

test("what one page shows is its own affair", async (t) => {
  const server = await Server.start(t, sewnShirt(t));
  const [one, other] = [await open(t, server), await open(t, server)];
  await one.page.keyboard.press("2");
  await one.when(() => preview.view.stats("sim") === null);
  const frames = await one.evaluate(() => observed.frames.sim);
  await other.after("sim", () => other.set("sim.seed", 3).then(() => other.set("sim.maxEdgeLength", 2)));
  await one.quiet();
  assert.equal(await one.evaluate(() => observed.frames.sim), frames, "a hidden mesh is not sent");
  await one.page.keyboard.press("2");
  await one.when(() => preview.view.stats("sim") !== null);
  assert.deepEqual((await one.meshes()).sim, (await other.meshes()).sim);
  [one, other].forEach(assertClean);
});

test("a page whose server has ended says so, keeps its meshes and throws nothing", async (t) => {
  const garment = sewnShirt(t);
  const server = await Server.start(t, garment);
  const preview = await open(t, server);
  const { page } = preview;
  await preview.after("render", () => preview.set(OFFSET, -0.6));
  const before = await preview.meshes();
  await server.stop();
  const banner = page.locator(".banner.is-lost");
  await banner.waitFor();
  assert.match(await banner.innerText(), /command has ended/);
  assert.ok(await page.getByRole("button", { name: "Save", exact: true }).isDisabled());
  assert.ok(await preview.slider("render.level").isDisabled());
  assert.deepEqual(await preview.meshes(), before);
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+s");
  assert.equal(await page.locator("dialog").count(), 0);

  // The new one has another secret, so that an old page stays out.
  const next = await Server.start(t, garment, "--port", String(server.port));
  assert.notEqual(next.secret, server.secret);
  await page.waitForTimeout(2500);
  assert.ok(await banner.isVisible());
  assert.deepEqual(await preview.meshes(), before);
  assert.deepEqual(preview.thrown, []);
});

test("the banner promises nothing that cannot happen", async (t) => {
  const server = await Server.start(t, sewnShirt(t));
  const preview = await open(t, server);
  await server.stop();
  const banner = preview.page.locator(".banner.is-lost");
  await banner.waitFor();
  assert.doesNotMatch(await banner.innerText(), /reconnects/);
});

test("a connection that breaks while the server runs comes back", async (t) => {
  const server = await Server.start(t, sewnShirt(t));
  const preview = await open(t, server);
  await preview.after("render", () => preview.set(OFFSET, -0.6));
  const before = await preview.meshes();
  const { edits } = await preview.document();
  await preview.evaluate(() => observed.sockets.at(-1).close());
  await preview.page.locator(".banner.is-lost").waitFor();
  await preview.page.locator(".banner.is-lost").waitFor({ state: "detached" });
  await preview.quiet();
  assert.deepEqual([await preview.meshes(), (await preview.document()).edits], [before, edits]);
  await preview.after("render", () => preview.set(OFFSET, -0.4));
  assertClean(preview);
});
