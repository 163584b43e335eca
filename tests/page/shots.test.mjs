// A cache is played on the simulation mesh and the render mesh.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { assertClean, open, show } from "./support/browser.mjs";
import { copyOf, run, Server, temporaryFolder } from "./support/server.mjs";

/** The points of a mesh that the view draws. */
const points = (preview, role) => preview.evaluate((role) => preview.view.stats(role).checksum, role);

/** A cache of a mesh that rises by a unit a frame, as a `.npy` of doubles. */
function rising(mesh, frames, to) {
  const count = mesh.length / 3;
  const header = `{'descr': '<f8', 'fortran_order': False, 'shape': (${frames}, ${count}, 3), }`.padEnd(117, " ") + "\n";
  const data = Buffer.alloc(10 + header.length + 24 * frames * count);
  data.write("\x93NUMPY\x01\x00", "latin1");
  data.writeUInt16LE(header.length, 8);
  data.write(header, 10, "latin1");
  let at = 10 + header.length;
  for (let frame = 0; frame < frames; frame++) {
    for (let i = 0; i < mesh.length; i++) at = data.writeDoubleLE(mesh[i] + (i % 3 === 1 ? frame : 0), at);
  }
  writeFileSync(to, data);
}

/** The points of the simulation mesh that the command writes. */
async function simPoints(garment, folder) {
  const output = join(folder, "built.usda");
  assert.equal((await run("build", garment, "-o", output, "--flatten", "-q")).code, 0);
  const text = readFileSync(output, "utf8");
  const mesh = text.slice(text.indexOf('def Mesh "sim"'));
  const list = /point3f\[\] points = \[(.*?)\]\n/s.exec(mesh)[1];
  return list.match(/-?[\d.]+(?:e-?\d+)?/g).map(Number);
}

test("a cache plays, is scrubbed both ways, and leaves the meshes as they are at bind", async (t) => {
  const garment = copyOf(t, "tshirt.usda");
  const folder = temporaryFolder(t);
  const cache = join(folder, "cache.npy");
  rising(await simPoints(garment, folder), 6, cache);
  const preview = await show(t, garment, { args: ["--cache", cache] });
  const { page } = preview;
  await preview.when(() => preview.store.state.shot !== null);
  assert.deepEqual(await preview.state(({ shot }) => [shot.frames, shot.frame, shot.fault]), [6, null, null]);
  const bind = [await points(preview, "sim"), await points(preview, "render")];
  const heightOf = (role) =>
    preview.evaluate((role) => preview.view.stats(role).least[1], role);
  const low = [await heightOf("sim"), await heightOf("render")];

  const scrub = async (frame) => {
    await page.getByRole("slider", { name: "Frame" }).fill(String(frame));
    await preview.when((frame) => preview.store.state.shot.frame === frame, frame);
    await preview.quiet();
  };
  await scrub(4);
  const fourth = [await points(preview, "sim"), await points(preview, "render")];
  // Both meshes rise by as much as the cache.
  for (const [i, role] of ["sim", "render"].entries()) assert.ok(Math.abs((await heightOf(role)) - low[i] - 4) < 1e-3);
  await scrub(1);
  await scrub(4);
  assert.deepEqual([await points(preview, "sim"), await points(preview, "render")], fourth);

  await page.getByRole("button", { name: "Play" }).click();
  await preview.when(() => preview.store.state.isPlaying && preview.store.state.shot.frame !== 4);
  await page.keyboard.press("Escape");
  await page.getByRole("button", { name: "Pause" }).click();
  await page.getByRole("button", { name: "Bind" }).click();
  await preview.when(() => preview.store.state.shot.frame === null);
  await preview.quiet();
  assert.deepEqual([await points(preview, "sim"), await points(preview, "render")], bind);
  assertClean(preview);
});

test("a frame follows an edit of the render mesh, and a cache of another mesh is named", async (t) => {
  const garment = copyOf(t, "tshirt.usda");
  const folder = temporaryFolder(t);
  const cache = join(folder, "cache.npy");
  rising(await simPoints(garment, folder), 3, cache);
  const server = await Server.start(t, garment, "--cache", cache);
  const preview = await open(t, server);
  await preview.when(() => preview.store.state.shot !== null);
  const low = await preview.evaluate(() => preview.view.stats("render").least[1]);
  await preview.evaluate(() => preview.store.player.show(2));
  await preview.when(() => preview.store.state.shot.frame === 2);
  await preview.evaluate(() => preview.store.set("render.level", 1));
  await preview.quiet();
  await preview.when((low) => Math.abs(preview.view.stats("render").least[1] - low - 2) < 0.2, low);
  // Another simulation mesh has other points.
  await preview.evaluate(() => preview.store.set("sim.maxEdgeLength", 6));
  await preview.when(() => preview.store.state.shot?.fault);
  assert.match(await preview.page.getByRole("alert").allTextContents().then((all) => all.join()), /it has \d+ points, and .* has/);
  assertClean(preview);
});
