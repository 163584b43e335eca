// Unsaved edits outlive the server.

import assert from "node:assert/strict";
import { existsSync, readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { assertClean, open, show } from "./support/browser.mjs";
import { copyOf } from "./support/server.mjs";

function kept(server) {
  const folder = join(server.state, "usdtailor", "unsaved");
  return existsSync(folder) ? readdirSync(folder) : [];
}

async function until(holds, what) {
  for (let i = 0; i < 100; i++) {
    if (holds()) return;
    await new Promise((done) => setTimeout(done, 50));
  }
  assert.fail(what);
}

function bannerOf(preview) {
  const banner = preview.page.locator(".banner", { hasText: "were not saved" });
  return { banner, restore: banner.getByRole("button", { name: "Restore" }), discard: banner.getByRole("button", { name: "Discard" }) };
}

/** A page whose server was killed with an unsaved edit, and the page of the next server. */
async function restarted(t, level) {
  const garment = copyOf(t, "tshirt.usda");
  const preview = await show(t, garment);
  assert.deepEqual(kept(preview.server), [], "nothing is kept without edits");
  await preview.after("render", () => preview.set("render.level", level));
  await until(() => kept(preview.server).length === 1, "the edits are kept within a second or two");
  await preview.server.stop();
  await preview.page.getByText("It offers the unsaved edits again").waitFor();
  return open(t, await preview.server.again(t));
}

test("the edits of a server that was killed come back", async (t) => {
  const next = await restarted(t, 1);
  const { banner, restore } = bannerOf(next);
  await banner.waitFor();
  assert.deepEqual((await next.document()).edits, {}, "they are offered, and not applied");
  await next.after("render", () => restore.click());
  const { edits, unsaved, canUndo } = await next.document();
  assert.deepEqual(edits, { render: { level: 1 } });
  assert.ok(unsaved && canUndo);
  await banner.waitFor({ state: "detached" });

  await next.page.keyboard.press("Control+s");
  const dialog = next.page.getByRole("dialog", { name: "Save the edits" });
  await dialog.getByLabel("Path").fill(join(dirname(next.server.garment), "look.usda"));
  await dialog.locator('button[type="submit"]').click();
  await dialog.waitFor({ state: "detached" });
  await until(() => kept(next.server).length === 0, "saved edits are not kept");
  assertClean(next);
});

test("discarded edits are forgotten", async (t) => {
  const next = await restarted(t, 0);
  const { banner, discard } = bannerOf(next);
  await discard.click();
  await banner.waitFor({ state: "detached" });
  assert.deepEqual((await next.document()).edits, {});
  await until(() => kept(next.server).length === 0, "nothing is kept");
  await next.server.stop();
  const last = await open(t, await next.server.again(t));
  assert.equal(await bannerOf(last).banner.count(), 0);
  assertClean(last);
});
