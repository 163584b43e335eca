// Times of edits in the page, and the memory of the server: `cargo xtask preview-bench`. Any argument leaves the memory out.

import { readFileSync } from "node:fs";
import { setTimeout as sleep } from "node:timers/promises";
import { blank } from "./support/browser.mjs";
import { example, Server, SUIT } from "./support/server.mjs";
import { connect } from "./support/socket.mjs";

const COUNT = 50;
/** Long enough for a picture that is drawn without a graphics card, which takes time from the next build. [ms] */
const PAUSE = 700;
const PARTS = ["build", "encode", "transfer", "upload", "replaced", "total"];

const ends = [];
const owner = { after: (end) => ends.push(end) };

/** Edits of an option: those of the coat have the sizes of its own seams, the others are shares of the mean edge. */
const COAT = {
  garment: example("sewn/coat.usda"),
  options: ["render.level=1"],
  edits: [
    ["render", "seam.side.normalOffset", (i) => -0.1 - 0.002 * i],
    ["render", "seam.side.width", (i) => 0.4 + 0.005 * i],
    ["render", "render.level", (i) => 1 + ((i + 1) % 2)],
    ["sim", "sim.maxEdgeLength", (i) => 2.5 + 0.005 * i],
  ],
};

/** The mean edge. [cm] */
const MEAN = 2.63;
const PANELS = Array.from({ length: 10 }, (_, i) => `panel0${i}`).join();
const LAYERED_SUIT = {
  garment: SUIT,
  options: [
    "seam.s.edges=uvSeams",
    `seam.s.width=${0.3 * MEAN}`,
    `seam.s.normalOffset=${-0.05 * MEAN}`,
    `fold.hem.faces=${PANELS}`,
    `fold.hem.thickness=${0.08 * MEAN}`,
  ],
  edits: [
    ["render", "seam.s.normalOffset", (i) => -MEAN * (0.03 + 0.0005 * i)],
    ["render", "seam.s.width", (i) => MEAN * (0.25 + 0.0015 * i)],
    ["sim", "sim.maxEdgeLength", (i) => MEAN * (0.48 + 0.001 * i)],
  ],
};

const median = (numbers) => numbers.sort((a, b) => a - b)[numbers.length >> 1];

/** One edit, from the call to the picture. */
function edit(page, [role, key, value]) {
  return page.evaluate(
    async ([role, key, value]) => {
      const { store, timing } = preview;
      timing.length = 0;
      store.gestures.input = performance.timeOrigin + performance.now();
      store.set(key, value);
      for (;;) {
        const found = timing.find((each) => each.role === role && each.edited !== null);
        if (found) return found;
        await new Promise((resolve) => setTimeout(resolve, 5));
      }
    },
    [role, key, value],
  );
}

async function measure({ garment, options, edits }) {
  const start = performance.now();
  const server = await Server.start(owner, garment, ...options.flatMap((option) => ["--set", option]));
  const started = performance.now() - start;
  const page = await blank(owner, server.address);
  // What a graphics card draws at once costs the builds their cores here.
  await page.setViewportSize({ width: 640, height: 360 });
  await page.waitForFunction(() => window.preview?.view?.stats("model"), null, { polling: 20 });
  const shown = await page.evaluate(() => performance.now());
  console.log(`\n${garment}\naddress after ${started.toFixed(0)} ms, first mesh ${shown.toFixed(0)} ms after that is opened`);
  await page.waitForFunction(() => preview.view.stats("render") && preview.view.stats("sim"));
  await sleep(3000);
  console.log(["edit, medians [ms]".padEnd(24), ...PARTS.map((part) => part.padStart(9))].join(""));
  for (const [role, key, value] of edits) {
    const times = [];
    for (let i = 0; i < COUNT; i++) {
      times.push(await edit(page, [role, key, value(i)]));
      await sleep(PAUSE);
    }
    const medians = PARTS.map((part) => median(times.map((each) => each[part])).toFixed(1).padStart(9));
    console.log([key.padEnd(24), ...medians].join(""));
  }
  await page.context().close();
  await server.stop();
}

/** Memory after many edits, each built. [MB] */
async function memory() {
  const server = await Server.start(owner, example("coat.usda"));
  const page = await blank(owner, `${server.address}page.css`);
  await page.evaluate(connect);
  const resident = () => Number(/VmRSS:\s+(\d+) kB/.exec(readFileSync(`/proc/${server.process.pid}/status`, "utf8"))[1]);
  console.log("\nmemory of the server after random edits of the coat");
  for (const [from, to] of [[0, 500], [500, 2000], [2000, 10000]]) {
    await page.evaluate(
      async ([from, to]) => {
        for (let i = from; i < to; i++) {
          const side = { edges: ["side_seams"], normalOffset: -0.2 * Math.random(), width: 0.3 + 0.5 * Math.random() };
          await window.edit({ render: { level: i % 2 }, seam: { side } });
        }
      },
      [from, to],
    );
    console.log(`${String(to).padStart(6)} edits: ${(resident() / 1024).toFixed(1)} MB`);
  }
}

await measure(COAT);
await measure(LAYERED_SUIT);
if (process.argv.length < 3 && process.platform === "linux") await memory();
for (const end of ends) await end();
process.exit();
