// Cloth, fabrics and pins in the panel, and the build of what is saved.

import assert from "node:assert/strict";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { assertClean, show } from "./support/browser.mjs";
import { sheetFile } from "./support/garments.mjs";
import { encode, rgb } from "./support/png.mjs";
import { copyOf, example, run, temporaryFolder } from "./support/server.mjs";

const figures = (preview) => preview.state((state) => state.cloth?.figures);

/** Waits for figures of the cloth. A text would be evaluated in the page, which its policy refuses. */
const whenCloth = (preview) => preview.when(() => preview.store.state.cloth?.figures);

test("mass, area and rest are those of the command, and so are the warnings", async (t) => {
  const garment = example("sewn/coat.usda");
  const preview = await show(t, garment);
  await whenCloth(preview);
  await preview.quiet();
  const output = join(temporaryFolder(t), "built.usda");
  const { stdout } = await run("build", garment, "-o", output, "--report", "-", "--quiet");
  const built = JSON.parse(stdout);
  assert.deepEqual(await figures(preview), built.cloth);
  const words = ({ code, place, problem }) => `${code} ${place} ${problem}`;
  const shown = await preview.state(({ garment, products, cloth }) =>
    [garment, ...Object.values(products), cloth].flatMap(({ warnings }) => warnings),
  );
  const of = (list) => [...new Set(list.map(words))].sort();
  assert.deepEqual(of(shown), of(built.warnings));
  assertClean(preview);
});

test("a fabric of a face set changes the mass, is renamed with what names it, and goes", async (t) => {
  const preview = await show(t, copyOf(t, "coat.usda"), { viewport: { width: 1280, height: 720 } });
  const { page } = preview;
  await whenCloth(preview);
  const before = (await figures(preview)).mass;
  await page.getByRole("button", { name: "New fabric" }).click();
  await page.getByRole("menuitem", { name: /Whole garment/ }).click();
  const card = page.locator('[data-card="fabric.fabric"]');
  const preset = card.getByLabel("Preset", { exact: true });
  await preset.dispatchEvent("pointerdown");
  await preset.selectOption("leather");
  // Keys of the view change no list that a hand has left.
  assert.notEqual(await page.evaluate(() => document.activeElement.tagName), "SELECT");
  await preview.when((before) => preview.store.state.cloth?.figures.mass > 3 * before, before);
  // 0 shows the preset's own value.
  assert.equal(await card.getByLabel("Density, number").getAttribute("placeholder"), "auto 0.65");
  await card.getByLabel("Thickness, number").fill("2 mm");
  await card.getByLabel("Thickness, number").press("Enter");
  await preview.when(() => Math.abs(preview.store.state.document.edits.fabric?.fabric.thickness - 0.002) < 1e-9);
  await card.getByRole("button", { name: "More of fabric" }).click();
  await page.getByRole("menuitem", { name: "Rename" }).click();
  await page.getByLabel("Name of fabric").fill("hide");
  await page.getByLabel("Name of fabric").press("Enter");
  await preview.when(() => preview.store.state.document.merged.cloth?.fabric === "hide");
  await preview.when(() => preview.store.state.cloth?.figures.fabrics.join() === "hide");
  await page.locator('[data-card="fabric.hide"]').getByRole("button", { name: "More of hide" }).click();
  await page.getByRole("menuitem", { name: "Delete" }).click();
  await preview.when(() => preview.store.state.document.merged.cloth?.fabric === "leather");
  await preview.quiet();
  assert.deepEqual(await preview.state(({ faults }) => faults.cloth), []);
  assertClean(preview);
});

test("a fabric that is not known is an error beside its option, and the figures stay", async (t) => {
  const preview = await show(t, copyOf(t, "coat.usda"));
  await whenCloth(preview);
  await preview.evaluate(() => preview.store.set("cloth.fabric", "felt"));
  await preview.when(() => preview.store.state.placed.at.has("cloth.fabric"));
  assert.ok((await figures(preview)).mass > 0);
});

test("Build saves first, runs the command, and shows what it prints and where", async (t) => {
  const garment = copyOf(t, "coat.usda");
  const preview = await show(t, garment, { viewport: { width: 1280, height: 720 } });
  const { page } = preview;
  await preview.evaluate(() => preview.store.set("render.level", 1));
  await preview.quiet();
  await page.getByRole("button", { name: "Build", exact: true }).click();
  const save = page.getByRole("dialog", { name: "Save the edits, then build" });
  await save.getByRole("button", { name: "Save" }).click();
  const dialog = page.getByRole("dialog", { name: "Build" });
  const proposal = () => document.querySelector("dialog[open] input[type=text]")?.value.endsWith("_look_tailored.usdc");
  await preview.when(proposal);
  const path = await dialog.getByLabel("Output").inputValue();
  await dialog.getByRole("button", { name: "Build", exact: true }).click();
  await preview.when(() => preview.store.state.build?.status === "built", undefined, 60_000);
  assert.ok(statSync(path).size > 0);
  const text = await dialog.getByLabel("What the command prints").textContent();
  assert.match(text, /triangles/);
  // The same bytes as the command line gives.
  const other = path.replace("_tailored", "_again");
  await run("build", path.replace("_tailored.usdc", ".usda"), "-o", other);
  assert.deepEqual(readFileSync(path), readFileSync(other));
  assertClean(preview);
});

test("an output that is another file is replaced only when it is asked for twice", async (t) => {
  const garment = copyOf(t, "coat.usda");
  await run("build", garment, "-o", garment.replace(".usda", "_tailored.usdc"));
  const preview = await show(t, garment, { viewport: { width: 1280, height: 720 } });
  const { page } = preview;
  await page.keyboard.press("Control+b");
  const dialog = page.getByRole("dialog", { name: "Build" });
  const path = await dialog.getByLabel("Output").inputValue();
  const before = statSync(path).mtimeMs;
  await dialog.getByRole("button", { name: "Build", exact: true }).click();
  await preview.when(() => preview.store.state.build?.status === "failed", undefined, 60_000);
  assert.equal(statSync(path).mtimeMs, before);
  await dialog.getByRole("button", { name: "Overwrite" }).click();
  await dialog.getByRole("button", { name: "Overwrite: click again" }).click();
  await preview.when(() => preview.store.state.build?.status === "built", undefined, 60_000);
  assert.ok(statSync(path).mtimeMs > before);
});

test("an image of the garment's material is on the cloth, upright, until a colour is chosen", async (t) => {
  const file = sheetFile(
    t,
    `    def Mesh "model" (prepend apiSchemas = ["MaterialBindingAPI"])
    {
        rel material:binding = </Sheet/print>
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
        uniform token subdivisionScheme = "none"
    }
    def Material "print"
    {
        token outputs:surface.connect = </Sheet/print/surface.outputs:surface>
        def Shader "surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </Sheet/print/image.outputs:rgb>
            token outputs:surface
        }
        def Shader "image"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./print.png@
            float3 outputs:rgb
        }
    }`,
  );
  // Red above blue.
  writeFileSync(join(dirname(file), "print.png"), encode(8, 8, (_, y) => (y < 4 ? [230, 20, 20] : [20, 20, 230])));
  const preview = await show(t, file, { ready: false });
  await preview.isDrawn(["model"]);
  await preview.settings({ roles: ["model"], wires: false, shadows: false });
  await preview.page.keyboard.press("4");
  /** Red against blue at a share of the height of the cloth, from below. */
  const warmth = async (share) => {
    await preview.isStill();
    const [low, high] = await preview.evaluate(() => [0, 3].map((point) => preview.view.project("model", point)));
    const at = { x: low.x + 40, y: low.y + share * (high.y - low.y) };
    const [red, , blue] = rgb(await preview.picture(), Math.round(at.x), Math.round(at.y));
    return red - blue;
  };
  await preview.when(() => preview.store.state.garment.looks[0].texture !== null);
  for (let i = 0; i < 40 && (await warmth(0.75)) < 60; i++) await sleep(250);
  assert.ok((await warmth(0.75)) > 60 && (await warmth(0.25)) < -60, "the image is there, red above");
  const { fabric } = await preview.state(({ settings }) => settings);
  await preview.settings({ fabric: { ...fabric, colour: "#808080" } });
  assert.ok(Math.abs(await warmth(0.75)) < 40, "a colour replaces it");
  assertClean(preview);
});
