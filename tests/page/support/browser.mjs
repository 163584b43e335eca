// A browser for the tests of one file, and pages that note all that goes wrong in them.

import assert from "node:assert/strict";
import { after } from "node:test";
import { chromium } from "playwright-core";
import { observe } from "./observe.mjs";
import { Preview } from "./preview.mjs";
import { Server } from "./server.mjs";

const FLAGS = [
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--ignore-gpu-blocklist",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

/** Drawing is slow without a GPU, so that windows are small where their size does not matter. */
const SMALL = { width: 720, height: 480 };
/** The smallest screen that the page is laid out for. */
export const SCREEN = { width: 1280, height: 720 };

let browser = null;

async function launched() {
  browser ??= chromium.launch({
    executablePath: process.env.CHROMIUM,
    chromiumSandbox: false,
    args: FLAGS,
  });
  return browser;
}

after(async () => (await browser)?.close());

/** Runs in a page: an artist who has chosen columns beside one another, where each mesh is as large as the others, and no
 *  shadows, which are slow without a graphics card, and who picks one side of a garment at a time. */
function chooseColumns() {
  const key = "usdtailor.preview";
  if (!localStorage.getItem(key)) localStorage.setItem(key, JSON.stringify({ layout: "side", shadows: false, symmetric: false }));
}

/** Runs in a page: a graphics card that is never done with the first sample of a picture at rest. Without a card, the others
 *  take seconds after each change; pictures that are asked for have them all the same. */
function rarelyRest() {
  WebGL2RenderingContext.prototype.getSyncParameter = function () {
    return this.UNSIGNALED;
  };
}

/** Opens the page of a server in a context of its own, and waits until all meshes are drawn. `isNew` leaves the settings to
 *  the page, `rests` has it draw whole pictures at rest, and `init` is a script that runs before it. */
export async function open(owner, server, { ready = true, isNew = false, rests = false, init = null, ...options } = {}) {
  const context = await (await launched()).newContext({ viewport: SMALL, ...options });
  owner.after(() => context.close());
  await context.addInitScript(observe);
  if (!isNew) await context.addInitScript(chooseColumns);
  if (!rests) await context.addInitScript(rarelyRest);
  if (init) await context.addInitScript(init);
  const page = await context.newPage();
  page.setDefaultTimeout(20_000);
  page.setDefaultNavigationTimeout(40_000);
  const preview = new Preview(page, server);
  await page.goto(server.address);
  if (ready) await preview.isDrawn();
  return preview;
}

/** A page of Playwright at an address, which is not that of the preview. */
export async function blank(owner, address) {
  const context = await (await launched()).newContext();
  owner.after(() => context.close());
  const page = await context.newPage();
  await page.goto(address);
  return page;
}

/** A server for a garment with one page. */
export async function show(owner, garment, { args = [], ...options } = {}) {
  return open(owner, await Server.start(owner, garment, ...args), options);
}

/** Nothing was thrown here or in the server, no error was logged, and no request went elsewhere. */
export function assertClean({ problems, origins, server }) {
  assert.deepEqual(problems, []);
  assert.doesNotMatch(server.errors, /panicked/);
  assert.deepEqual([...origins], [new URL(server.address).origin], "requests stay at the server");
}
