// The drawing of a card, presets, and those that are saved beside the garment.

import assert from "node:assert/strict";
import { existsSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { assertClean, open, show } from "./support/browser.mjs";
import { sewnShirt, substitute, variantSheet } from "./support/garments.mjs";
import { Server } from "./support/server.mjs";

const choose = async (preview, name, preset) => {
  await preview.page.getByRole("button", { name: `Preset of ${name}` }).click();
  await preview.page.getByRole("menuitem", { name: preset }).click();
};
const inUse = (preview, full) => preview.card(full).locator(".preset-name").innerText();
const beside = (garment) => garment.replace(/\.usda$/, ".presets.json");

/** A flat cloth of squares of 1 cm in the x-y plane, with an operator along y = 3. */
async function sheet(t, kind, fields) {
  const garment = variantSheet(t);
  substitute(garment, /, -?[\d.e-]+\)/g, ", 0)");
  const preview = await show(t, garment);
  const edits = { render: { level: 3 }, [kind]: { a: fields } };
  await preview.after("render", () => preview.evaluate((edits) => preview.store.edit(() => edits), edits));
  await preview.openCard(`${kind}.a`);
  return preview;
}

/** Points of the render mesh near a plane x, as [y, z]. */
async function cutAt(preview, x) {
  const points = await preview.points("render");
  const at = [...Array(points.length / 3).keys()].filter((i) => Math.abs(points[3 * i] - x) < 0.01);
  return at.map((i) => [points[3 * i + 1], points[3 * i + 2]]);
}

/** The largest distance of points from the drawn curve. [mesh units] */
function distanceFromDrawing(preview, full, points) {
  const measure = ([full, points]) => {
    const svg = document.querySelector(`[data-card="${full}"] .profile`);
    const path = svg.querySelector(".profile-cloth");
    const scale = Number(svg.dataset.scale);
    const [x0, y0] = svg.dataset.origin.split(" ").map(Number);
    const length = path.getTotalLength();
    const drawn = [...Array(3000).keys()].map((i) => {
      const { x, y } = path.getPointAtLength((length * i) / 2999);
      return [(x - x0) / scale, (y0 - y) / scale];
    });
    return Math.max(...points.map(([x, y]) => Math.min(...drawn.map(([a, b]) => Math.hypot(a - x, b - y)))));
  };
  return preview.evaluate(measure, [full, points]);
}

test("the drawing of a seam is the cross-section of the render mesh, and follows a drag", async (t) => {
  const height = -0.12;
  const fields = { edges: ["fold"], width: 0.8, normalOffset: height, depth: 0.06, asymmetry: 0.4 };
  const preview = await sheet(t, "seam", fields);
  // Left of a walker along x is y.
  const section = (await cutAt(preview, 3)).map(([y, z]) => [3 - y, z]).filter(([x]) => x > -0.5 && x < 0.9);
  assert.ok(section.length > 8 && Math.min(...section.map(([, z]) => z)) < 0.9 * height, `${section}`);
  const off = await distanceFromDrawing(preview, "seam.a", section);
  assert.ok(off < 0.08 * -height, `${off}`);
  const label = await preview.card("seam.a").locator(".profile").getAttribute("aria-label");
  assert.equal(label, "Cross-section: width 0.8 cm, height of the centre -0.12 cm");

  const path = () => preview.card("seam.a").locator(".profile-cloth").getAttribute("d");
  const before = await path();
  await preview.after("render", () => preview.drag("seam.a.width", 0.2, 3));
  assert.notEqual(await path(), before);
  assertClean(preview);
});

test("the drawing of a fold is the cross-section of the render mesh on either side", async (t) => {
  const preview = await sheet(t, "fold", { faces: ["rings(borders, 1)"], thickness: 0.12 });
  const flatten = async () => (await cutAt(preview, 3)).map(([y, z]) => [-y, z]).filter(([x]) => x > -0.7);
  const inner = await flatten();
  assert.ok(Math.min(...inner.map(([, z]) => z)) < -0.1, `${inner}`);
  assert.ok((await distanceFromDrawing(preview, "fold.a", inner)) < 0.012);
  for (const turn of [0, 1.5]) {
    await preview.after("render", () => preview.set("fold.a.turn", turn));
    const off = await distanceFromDrawing(preview, "fold.a", await flatten());
    // The mesh is around its limit where it turns most.
    assert.ok(off < 0.025, `turn ${turn}: ${off}`);
    assert.ok((await distanceFromDrawing(preview, "fold.a", inner)) > 0.03, `turn ${turn} is drawn as 1`);
  }
  await preview.after("render", () => preview.set("fold.a.turn", 1));
  await preview.after("render", () => preview.set("fold.a.side", "outer"));
  const outer = await flatten();
  assert.ok(Math.max(...outer.map(([, z]) => z)) > 0.1, `${outer}`);
  assert.ok((await distanceFromDrawing(preview, "fold.a", outer)) < 0.012);
  assertClean(preview);
});

test("a preset is one step, is drawn in the menu, and is named until a value differs", async (t) => {
  const preview = await show(t, sewnShirt(t));
  await preview.openCard("seam.side");
  assert.equal(await inUse(preview, "seam.side"), "Own values");
  const before = await preview.meshes();
  await preview.page.getByRole("button", { name: "Preset of side" }).click();
  const items = preview.page.getByRole("menuitem");
  const names = ["Dart", "Flat-felled", "French", "Piping", "Plain", "Topstitch", "Welt"];
  assert.deepEqual((await items.locator(".menu-label").allInnerTexts()).slice(0, 7), names);
  const drawn = await items.locator(".profile-cloth").evaluateAll((paths) => paths.map((path) => path.getAttribute("d")));
  assert.equal(new Set(drawn).size, 7, "each looks different");
  await preview.page.keyboard.type("felled");
  const felled = await preview.after("render", () => preview.page.keyboard.press("Enter"));
  assert.notEqual(felled.render.checksum, before.render.checksum);
  assert.equal(await inUse(preview, "seam.side"), "Flat-felled");
  const { merged } = await preview.document();
  assert.deepEqual([merged.seam.side.width, merged.seam.side.edges], [1, ["side_seams"]], "10 mm are 1 cm");
  await preview.after("render", () => preview.set("seam.side.width", 1.1));
  assert.equal(await inUse(preview, "seam.side"), "Own values");
  await preview.after("render", () => preview.page.keyboard.press("Control+z"));
  assert.deepEqual(await preview.after("render", () => preview.page.keyboard.press("Control+z")), before);
  assert.deepEqual((await preview.document()).edits, {});

  await preview.openCard("fold.neck");
  await preview.page.getByRole("button", { name: "Preset of neck" }).click();
  const folds = await items.locator(".profile-cloth").evaluateAll((paths) => paths.map((path) => path.getAttribute("d")));
  assert.equal(new Set(folds).size, 4, "a thicker fold is drawn thicker");
  await preview.page.keyboard.press("Escape");
  await preview.after("render", () => choose(preview, "neck", "Bound edge"));
  assert.equal((await preview.document()).merged.fold.neck.side, "outer");
  assertClean(preview);
});

/** What else the seam of the shirt has. */
const OTHERS = { crease: false, depth: "0mm", asymmetry: 0, offset: "0mm", side: "both", rows: 1, rowGap: "0mm", end: "taper", through: false };

test("a preset is saved beside the garment without the sets, for all pages", async (t) => {
  const garment = sewnShirt(t);
  const server = await Server.start(t, garment);
  const [first, second] = [await open(t, server), await open(t, server)];
  await first.set("seam.side.width", 0.9);
  await first.openCard("seam.side");
  await choose(first, "side", "Save as preset…");
  const name = first.page.getByLabel("Name of the preset");
  await name.fill('Our "felled", 2.5 oz');
  await name.press("Enter");
  await first.page.getByText("is in", { exact: false }).waitFor();
  await first.when(() => document.querySelector(".preset-name").textContent.startsWith("Our"));
  const saved = () => JSON.parse(readFileSync(beside(garment), "utf8"));
  assert.deepEqual(saved(), {
    seam: { 'Our "felled", 2.5 oz': { ...OTHERS, width: "9mm", normalOffset: "-3mm" } },
  });
  writeFileSync(`${garment}.new`, "");
  const mode = (path) => statSync(path).mode & 0o777;
  assert.equal(mode(beside(garment)), mode(`${garment}.new`), "the permissions of any new file");
  const { edits, unsaved } = await first.document();
  assert.deepEqual([edits, unsaved], [{ seam: { side: { width: 0.9 } } }, true], "the recipe is not saved by that");

  await second.openCard("seam.shoulder");
  await second.after("render", () => choose(second, "shoulder", /Our/));
  const { merged } = await second.document();
  assert.deepEqual([merged.seam.shoulder.width, merged.seam.shoulder.edges], [0.9, ["shoulder_seams"]]);

  await choose(second, "shoulder", /^Remove/);
  await first.when(() => preview.store.state.presets.saved.seam?.["Our \"felled\", 2.5 oz"] === undefined);
  assert.deepEqual(saved(), { seam: {} });
  await second.page.getByRole("button", { name: "Put back" }).click();
  await first.when(() => preview.store.state.presets.saved.seam?.["Our \"felled\", 2.5 oz"] !== undefined);
  assertClean(first);
  assertClean(second);
});

test("presets are followed, and a file with a fault is reported, kept and not written over", async (t) => {
  const garment = sewnShirt(t);
  writeFileSync(beside(garment), JSON.stringify({ seam: { "From before": { width: "6mm" } } }));
  const preview = await show(t, garment);
  const names = () => preview.state(({ presets }) => Object.keys(presets.saved.seam ?? {}));
  assert.deepEqual(await names(), ["From before"]);
  const before = await preview.meshes();
  writeFileSync(beside(garment), JSON.stringify({ seam: { Later: { width: "0.25in" } } }));
  await preview.when(() => preview.store.state.presets.saved.seam?.Later?.width === 0.635);
  assert.deepEqual(await names(), ["Later"]);

  const broken = '{"seam": {"Later": {"widht": 3}}}';
  writeFileSync(beside(garment), broken);
  await preview.page.getByText("widht").waitFor();
  assert.deepEqual(await names(), ["Later"], "the last good ones stay");
  await preview.openCard("seam.side");
  await choose(preview, "side", "Save as preset…");
  await preview.page.getByLabel("Name of the preset").fill("Mine");
  await preview.page.keyboard.press("Enter");
  await preview.page.getByText("“Mine” is not changed").waitFor();
  assert.equal(readFileSync(beside(garment), "utf8"), broken, "nothing is lost");

  rmSync(beside(garment));
  await preview.when(() => Object.keys(preview.store.state.presets.saved).length === 0);
  await preview.page.getByText("widht").first().waitFor({ state: "hidden" }).catch(() => undefined);
  assert.equal(await preview.state(({ faults }) => faults.presets.length), 0);
  assert.ok(!existsSync(beside(garment)));
  assert.deepEqual(await preview.meshes(), before, "presets alone change no mesh");
  assertClean(preview);
});
