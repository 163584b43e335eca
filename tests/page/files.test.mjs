// The files of the garment are followed while other programs write them.

import assert from "node:assert/strict";
import { readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";

/** Longest wait until a change of a file is on the screen. It is to be 0.5 s where drawing is not slow. [ms] */
const PATIENCE = 2000;

/** The text of a garment whose first point is `height` in front of where it was. */
function moved(text, height) {
  const change = text.replace(
    /(point3f\[\] points = \[\(\S+, \S+, )(\S+)\)/,
    (_, start, z) => `${start}${Number(z) + height})`,
  );
  assert.notEqual(change, text);
  return change;
}

/** Writes, waits for the mesh of the garment, and says how long it took. */
async function timed(t, preview, what, write) {
  const before = await preview.meshes();
  const start = performance.now();
  write();
  await preview.differs("model", before);
  const time = performance.now() - start;
  t.diagnostic(`${what}: on the screen after ${Math.round(time)} ms`);
  assert.ok(time < PATIENCE, `${what} took ${time} ms`);
  await preview.quiet();
  const after = await preview.meshes();
  for (const role of ["model", "sim", "render"]) assert.notEqual(after[role].checksum, before[role].checksum, role);
  return after;
}

test("a garment that another program writes is shown anew, and the edits stay", async (t) => {
  const garment = sewnShirt(t);
  const text = readFileSync(garment, "utf8");
  const preview = await show(t, garment);
  await preview.after("render", () => preview.set("seam.side.normalOffset", -0.6));
  const first = await preview.meshes();
  const { edits } = await preview.document();

  await timed(t, preview, "a file that is written", () => writeFileSync(garment, moved(text, 0.7)));
  assert.deepEqual((await preview.document()).edits, edits);
  await timed(t, preview, "a file that is replaced by rename", () => {
    writeFileSync(`${garment}.new`, moved(text, 1.3));
    renameSync(`${garment}.new`, garment);
  });
  await timed(t, preview, "a file that is removed and written", () => {
    rmSync(garment);
    writeFileSync(garment, moved(text, 1.9));
  });
  const back = await timed(t, preview, "the file as it was", () => writeFileSync(garment, text));
  assert.deepEqual(back, first, "the edits hold over the new garment");
  assert.ok((await preview.document()).canUndo);
  assertClean(preview);
});

test("a file that breaks is told, the last garment stays, and a mended one ends it", async (t) => {
  const garment = sewnShirt(t);
  const text = readFileSync(garment, "utf8");
  const preview = await show(t, garment);
  const banner = preview.page.locator(".banner");
  const before = await preview.meshes();
  writeFileSync(garment, text.slice(0, 5000));
  await banner.waitFor();
  assert.match(await banner.innerText(), /The last good garment stays/);
  await preview.quiet();
  assert.deepEqual(await preview.meshes(), before);
  // Of the last garment, edits are still shown.
  await preview.after("render", () => preview.set("seam.side.normalOffset", -0.6));

  await timed(t, preview, "a mended file", () => writeFileSync(garment, moved(text, 0.7)));
  await banner.waitFor({ state: "detached" });
  rmSync(garment);
  await banner.waitFor();
  writeFileSync(garment, moved(text, 0.7));
  await banner.waitFor({ state: "detached" });
  assertClean(preview);
});

test("a layer below the one that is open is followed too", async (t) => {
  const garment = sewnShirt(t);
  const text = readFileSync(garment, "utf8");
  const look = join(dirname(garment), "look.usda");
  const layer = (width) => `#usda 1.0
(
    defaultPrim = "Tshirt"
    metersPerUnit = 0.01
    subLayers = [@./tshirt.usda@]
    upAxis = "Y"
)
over "Tshirt"
{
    over "model"
    {
        uniform float tailor:seam:side:width = ${width}
    }
}
`;
  writeFileSync(look, layer(0.8));
  const preview = await show(t, look);
  await timed(t, preview, "a layer below", () => writeFileSync(garment, moved(text, 0.7)));
  const before = await preview.meshes();
  const after = await preview.after("render", () => writeFileSync(look, layer(1.2)));
  assert.deepEqual([after.model, after.sim], [before.model, before.sim], "options alone move the render mesh alone");
  assertClean(preview);
});

test("the files are read again at the press of a button", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const count = () => preview.evaluate(() => observed.messages.filter(({ type }) => type === "garment").length);
  const before = await count();
  await preview.page.getByRole("button", { name: "Read the files again" }).click();
  await preview.when((n) => observed.messages.filter(({ type }) => type === "garment").length > n, before);
  await preview.quiet();
  assertClean(preview);
});
