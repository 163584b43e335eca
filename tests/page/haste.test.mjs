// Many edits: none is lost that counts, and nothing piles up.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { assertClean, blank, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";
import { Server } from "./support/server.mjs";
import { connect } from "./support/socket.mjs";

const OFFSET = "seam.side.normalOffset";

test("of two hundred edits in two seconds the last one is shown, and not each was built", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const before = await preview.evaluate(() => observed.frames.render);
  const longest = await preview.evaluate(async (key) => {
    let [longest, last] = [0, performance.now()];
    const lag = () => {
      longest = Math.max(longest, performance.now() - last);
      last = performance.now();
    };
    const timer = setInterval(lag, 5);
    const start = performance.now();
    for (let i = 1; i <= 200; i++) {
      preview.store.set(key, -0.3 - i / 500, "continuous");
      while (performance.now() < start + i * 10) await new Promise((resolve) => setTimeout(resolve));
    }
    clearInterval(timer);
    return longest;
  }, OFFSET);
  await preview.when(() => preview.store.state.document.edits.seam?.side.normalOffset === -0.7);
  await preview.quiet();
  const frames = (await preview.evaluate(() => observed.frames.render)) - before;
  t.diagnostic(`${frames} render meshes came, and the page was busy for ${Math.round(longest)} ms at most`);
  assert.ok(frames > 1 && frames < 200, `${frames} frames`);
  assert.ok(longest < 1500, `the page stood still for ${longest} ms`);

  const last = await preview.meshes();
  const { revision } = await preview.document();
  assert.equal(await preview.evaluate(() => observed.headers.render.revision), revision, "the newest one is shown");
  await preview.after("render", () => preview.set(OFFSET, -0.2));
  assert.deepEqual(await preview.after("render", () => preview.set(OFFSET, -0.7)), last);
  for (let i = 0; i < 2; i++) await preview.after("render", () => preview.page.keyboard.press("Control+z"));
  await preview.page.keyboard.press("Control+z");
  await preview.when(() => !preview.store.state.document.canUndo);
  assertClean(preview);
});

test("a key that is held on a slider is one step of undo", async (t) => {
  const preview = await show(t, sewnShirt(t));
  await preview.openCard("seam.side");
  const before = await preview.meshes();
  await preview.slider(OFFSET).focus();
  await preview.after("render", async () => {
    for (let i = 0; i < 40; i++) await preview.page.keyboard.down("ArrowLeft");
    await preview.page.keyboard.up("ArrowLeft");
  });
  assert.ok((await preview.document()).edits.seam.side.normalOffset < -0.4);
  assert.deepEqual(await preview.after("render", () => preview.page.keyboard.press("Control+z")), before);
  assert.equal((await preview.document()).canUndo, false);
});

const resident = ({ process: { pid } }) =>
  Number(/VmRSS:\s+(\d+) kB/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1024;

/** Edits each time that the render mesh of the last edit is there. The simulation mesh changes now and then. */
function editOften(page, count) {
  return page.evaluate(async (count) => {
    for (let i = 0; i < count; i++) {
      if (i % 5 === 0) window.longest = 9 + Math.random();
      const side = { normalOffset: -Math.random(), width: 0.2 + Math.random() };
      await edit({ render: { level: 0 }, seam: { side }, sim: { maxEdgeLength: longest, minEdgeLength: 8 } });
    }
  }, count);
}

test("a thousand edits take no more memory than two hundred", { skip: process.platform !== "linux" }, async (t) => {
  const server = await Server.start(t, sewnShirt(t));
  const page = await blank(t, `${server.address}page.css`);
  await page.evaluate(connect);
  const start = performance.now();
  await editOften(page, 200);
  const early = resident(server);
  await editOften(page, 800);
  const late = resident(server);
  const time = ((performance.now() - start) / 1000).toFixed(1);
  t.diagnostic(`${early.toFixed(0)} MB after 200 edits, ${late.toFixed(0)} MB after 1000, in ${time} s`);
  assert.ok(late < 1.3 * early, `${late} MB after ${early} MB`);
});

test("a mesh is there as soon as it is built", async (t) => {
  const server = await Server.start(t, sewnShirt(t));
  const page = await blank(t, `${server.address}page.css`);
  await page.evaluate(connect);
  const times = await page.evaluate(async () => {
    const times = [];
    for (let i = 1; i <= 41; i++) {
      times.push(await edit({ render: { level: 0 }, seam: { side: { normalOffset: -i / 50 } } }));
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
    return times;
  });
  const waits = times.map(({ total, work }) => total - work).sort((a, b) => a - b);
  t.diagnostic(`half of the edits waited for more than ${waits[20].toFixed(1)} ms beside the work`);
  assert.ok(waits[20] < 25, `${waits[20]} ms`);
});
