// What cloth looks like: at rest, in shadow, from the back, in colour, and in pictures that are saved.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { assertClean, open, show } from "./support/browser.mjs";
import { sheetFile } from "./support/garments.mjs";
import { decode, differing, encode, rgb } from "./support/png.mjs";
import { example, Server } from "./support/server.mjs";

/** A square cloth with a narrow groove aslant, and a small square 0.2 off its front. Points from 4 on are the groove's, from
 *  10 on the small square's. */
function layers(test) {
  const at = (y) => -2 + 0.1 * y;
  const groove = [-5, 5].flatMap((y) => [`(${at(y)}, ${y}, 0)`, `(${at(y) + 0.01}, ${y}, -0.03)`, `(${at(y) + 0.02}, ${y}, 0)`]);
  const points = ["(-5, -5, 0)", "(5, -5, 0)", "(5, 5, 0)", "(-5, 5, 0)", ...groove];
  const flap = ["(0, -1, 0.2)", "(3, -1, 0.2)", "(3, 2, 0.2)", "(0, 2, 0.2)"];
  return sheetFile(
    test,
    `    def Mesh "model"
    {
        int[] faceVertexCounts = [4, 4, 4, 4, 4]
        int[] faceVertexIndices = [0, 4, 7, 3, 4, 5, 8, 7, 5, 6, 9, 8, 6, 1, 2, 9, 10, 11, 12, 13]
        point3f[] points = [${[...points, ...flap].join(", ")}]
        uniform token subdivisionScheme = "none"
    }`,
  );
}

const MODEL = { roles: ["model"], wires: false, smooth: 0 };

async function layered(t, settings = {}) {
  const preview = await show(t, layers(t), { ready: false, rests: true });
  await preview.isDrawn(["model"]);
  await preview.settings({ ...MODEL, shadows: true, ...settings });
  await preview.page.keyboard.press("4");
  await preview.picture();
  return preview;
}

/** Places of points on the picture. */
function places(preview, points) {
  return preview.evaluate((points) => points.map((point) => preview.view.project("model", point)), points);
}

const light = (colour) => colour[0] + colour[1] + colour[2];

/** The canvas in the frame in which the view draws it anew. */
async function plain(preview) {
  const data = await preview.evaluate(async () => {
    preview.store.settings({});
    const canvas = document.querySelector("canvas");
    return new Promise((resolve) => requestAnimationFrame(() => resolve(canvas.toDataURL())));
  });
  return decode(Buffer.from(data.split(",")[1], "base64"));
}

/** Has what draws a name: a script for a page. */
const nameRenderer = (name) => `
  const { getParameter } = WebGL2RenderingContext.prototype;
  const UNMASKED_RENDERER = 0x9246;
  WebGL2RenderingContext.prototype.getParameter = function (parameter) {
    return parameter === UNMASKED_RENDERER ? ${JSON.stringify(name)} : getParameter.call(this, parameter);
  };`;

/** How much the darkest pixel across the groove changes from row to row. */
function unevenness(image, [from, to]) {
  const rows = [];
  for (let y = Math.ceil(to.y) + 8; y < from.y - 8; y++) {
    const x = Math.round(from.x + ((to.x - from.x) * (y - from.y)) / (to.y - from.y));
    rows.push(Math.min(...[-2, -1, 0, 1, 2].map((beside) => light(rgb(image, x + beside, y)))));
  }
  return rows.slice(1).reduce((sum, row, i) => sum + Math.abs(row - rows[i]), 0) / rows.length;
}

test("a groove of less than a pixel has no gaps in the picture at rest", async (t) => {
  const preview = await layered(t, { shadows: false });
  const ends = await places(preview, [5, 8]);
  const [moving, resting] = [await plain(preview), await preview.picture()];
  const share = moving.width / resting.width;
  const [before, after] = [unevenness(moving, ends.map(({ x, y }) => ({ x: share * x, y: share * y }))), unevenness(resting, ends)];
  assert.ok(after < 0.6 * before, `${before} of a plain picture, ${after} at rest`);
  assertClean(preview);
});

test("cloth below another layer is darker, and the switch ends it", async (t) => {
  const preview = await layered(t);
  const [corner] = await places(preview, [11]);
  const nearby = (image) => light(rgb(image, Math.round(corner.x) - 20, Math.round(corner.y) + 3));
  const far = (image) => light(rgb(image, Math.round(corner.x) - 20, Math.round(corner.y) + 60));
  const shaded = await preview.picture();
  await preview.page.getByRole("toolbar", { name: "Drawing" }).getByRole("button", { name: "Shadows" }).click();
  const bare = await preview.picture();
  assert.ok(nearby(shaded) < nearby(bare) - 15, `${nearby(shaded)} with shadows, ${nearby(bare)} without`);
  assert.ok(Math.abs(far(shaded) - far(bare)) < 15, "far from the layer all is as it was");
  assert.equal(await preview.state(({ settings }) => settings.shadows), false);
  assertClean(preview);
});

test("the back of cloth is darker and of the same hue", async (t) => {
  const preview = await layered(t, { shadows: false });
  const [a, b] = await places(preview, [0, 2]);
  const middle = (image) => rgb(image, Math.round(0.7 * a.x + 0.3 * b.x), Math.round((a.y + b.y) / 2));
  const front = middle(await preview.picture());
  await preview.page.keyboard.press("6");
  const back = middle(await preview.picture());
  assert.ok(light(back) < light(front) - 15, `front ${front}, back ${back}`);
  const warmth = ([red, , blue]) => red / blue;
  assert.ok(Math.abs(warmth(front) - warmth(back)) < 0.06, `front ${front}, back ${back}`);
  assertClean(preview);
});

const hasSamples = () => preview.view.samples() >= 4;

/** Drags the camera a little. */
async function turn(preview) {
  const box = await preview.page.locator("canvas").boundingBox();
  await preview.page.mouse.move(box.x + 100, box.y + 300);
  await preview.page.mouse.down();
  await preview.page.mouse.move(box.x + 160, box.y + 300);
  await preview.when(() => preview.view.samples() === 0, undefined, 2000);
  await preview.page.mouse.up();
}

test("samples are drawn once the view is at rest, and a move shows a plain picture at once", async (t) => {
  const preview = await layered(t, { shadows: false });
  await preview.when(() => preview.view.samples() === 16);
  await turn(preview);
  await preview.when(() => preview.view.samples() === 16);
  assertClean(preview);
});

test("where a sample takes long, a picture waits longer and has fewer of them, and a saved one has all", async (t) => {
  const preview = await layered(t, { shadows: false });
  await preview.evaluate(() => {
    // A graphics card that needs 0.7 s for a sample.
    const { fenceSync, getSyncParameter } = WebGL2RenderingContext.prototype;
    const began = new WeakMap();
    window.fences = 0;
    WebGL2RenderingContext.prototype.fenceSync = function (...args) {
      const fence = fenceSync.apply(this, args);
      began.set(fence, performance.now());
      window.fences += 1;
      return fence;
    };
    WebGL2RenderingContext.prototype.getSyncParameter = function (fence, name) {
      return performance.now() - began.get(fence) < 700 ? this.UNSIGNALED : getSyncParameter.call(this, fence, name);
    };
  });
  for (let i = 0; i < 2; i++) {
    await turn(preview);
    await preview.when(hasSamples);
  }
  await sleep(1500);
  assert.equal(await preview.evaluate(() => preview.view.samples()), 4);
  // The edits of a drag may come a second apart here.
  await turn(preview);
  await preview.page.mouse.move(1, 1);
  await sleep(300);
  const fences = await preview.evaluate(() => window.fences);
  await sleep(1000);
  const since = (await preview.evaluate(() => window.fences)) - fences;
  assert.ok(since <= 1, `no sample is drawn between them, but a plain picture in place of a draft: ${since}`);
  await preview.when(hasSamples);
  await preview.picture();
  assert.equal(await preview.evaluate(() => preview.view.samples()), 16);
  assertClean(preview);
});

test("a moving picture has fewer pixels without a graphics card, and one at rest or saved has all", async (t) => {
  const server = await Server.start(t, layers(t));
  const shares = async (init) => {
    const preview = await open(t, server, { ready: false, rests: true, init });
    await preview.isDrawn(["model"]);
    await preview.settings(MODEL);
    await preview.when(hasSamples);
    const [whole, moving] = await preview.evaluate(async () => {
      const canvas = document.querySelector("canvas");
      const whole = canvas.width;
      preview.view.look("back");
      for (let i = 0; i < 2; i++) await new Promise(requestAnimationFrame);
      return [whole, canvas.width];
    });
    const { width } = await preview.picture();
    await preview.when(hasSamples);
    assert.deepEqual([width, await preview.evaluate(() => document.querySelector("canvas").width)], [whole, whole]);
    assertClean(preview);
    return moving / whole;
  };
  assert.equal(await shares(null), 0.5);
  assert.equal(await shares(nameRenderer("NVIDIA GeForce RTX 4070")), 1);
});

test("a sample is drawn in parts, so that an edit waits for one of its shadows at most", async (t) => {
  const preview = await show(t, layers(t), {
    ready: false,
    rests: true,
    init: `
      const { fenceSync, drawArrays } = WebGL2RenderingContext.prototype;
      window.most = window.draws = 0;
      WebGL2RenderingContext.prototype.drawArrays = function (...args) {
        window.draws += 1;
        window.most = Math.max(window.most, window.draws);
        return drawArrays.apply(this, args);
      };
      WebGL2RenderingContext.prototype.fenceSync = function (...args) {
        window.draws = 0;
        return fenceSync.apply(this, args);
      };`,
  });
  await preview.isDrawn(["model"]);
  await preview.settings({ ...MODEL, shadows: true });
  await preview.when(hasSamples);
  await preview.evaluate(() => (window.most = 0));
  const before = await preview.evaluate(() => preview.view.samples());
  await preview.when((before) => preview.view.samples() >= before + 2, before);
  // The ground, the cloth and its parts of a column, or a map of one light and what is added up.
  const most = await preview.evaluate(() => window.most);
  assert.ok(most <= 5, `${most} draws between two waits`);
  assertClean(preview);
});

test("a moving picture has several samples a pixel with a graphics card alone", async (t) => {
  const server = await Server.start(t, layers(t));
  const isSmooth = async (init) => {
    const preview = await open(t, server, { ready: false, init });
    await preview.isDrawn(["model"]);
    return preview.evaluate(() => document.querySelector("canvas").getContext("webgl2").getContextAttributes().antialias);
  };
  assert.equal(await isSmooth(nameRenderer("llvmpipe (LLVM 20.1, 256 bits)")), false);
  assert.equal(await isSmooth(nameRenderer("NVIDIA GeForce RTX 4070")), true);
});

test("cloth has the model's own colour, or one that is chosen and kept, with a weave", async (t) => {
  const preview = await show(t, example("tshirt.usda"), { ready: false });
  const { page } = preview;
  await preview.isDrawn(["model"]);
  await preview.settings(MODEL);
  await page.keyboard.press("4");
  const chest = (image) => rgb(image, image.width >> 1, Math.round(image.height * 0.6));
  const own = await preview.picture();
  const [red, , blue] = chest(own);
  assert.ok(blue > 1.25 * red, `jersey is blue: ${chest(own)}`);
  await page.getByRole("button", { name: "Fabric", exact: true }).click();
  await page.getByRole("button", { name: "Wine" }).click();
  const wine = await preview.picture();
  assert.ok(chest(wine)[0] > 1.5 * chest(wine)[2], `wine is red: ${chest(wine)}`);
  await page.getByRole("radio", { name: "Knit" }).check();
  await preview.when(() => observed.headers.model.blocks.uvs);
  await preview.quiet();
  await page.keyboard.press("Escape");
  const box = await page.locator("canvas").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height * 0.6);
  for (let i = 0; i < 5; i++) await page.mouse.wheel(0, -240);
  const knit = await preview.picture();
  await preview.settings({ fabric: { colour: "#7d2f3a", roughness: null, weave: "none" } });
  assert.ok(differing(knit, await preview.picture()) > 0.5, "stitches are seen from near");
  await page.reload();
  await preview.isDrawn(["model"]);
  assert.equal(await preview.state(({ settings }) => settings.fabric.colour), "#7d2f3a");
  assertClean(preview);
});

/** A square of 10 cm with UVs that it fills. */
function square(test) {
  return sheetFile(
    test,
    `    def Mesh "model"
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
        uniform token subdivisionScheme = "none"
    }`,
  );
}

test("a fabric takes an image and a normal map of a size on the cloth, and the browser keeps them", async (t) => {
  const preview = await show(t, square(t), { ready: false });
  const { page } = preview;
  await preview.isDrawn(["model"]);
  await preview.settings({ ...MODEL, shadows: false });
  await page.keyboard.press("4");
  await preview.isStill();
  const [low, high] = await places(preview, [0, 2]);
  /** Red against blue along the cloth, a little above its middle. */
  const warmth = (image, share) => {
    const [red, , blue] = rgb(image, Math.round(low.x + share * (high.x - low.x)), Math.round(low.y + 0.6 * (high.y - low.y)));
    return red - blue;
  };
  const sides = (image) => [1 / 8, 3 / 8, 5 / 8, 7 / 8].map((share) => Math.sign(warmth(image, share))).join();
  await page.getByRole("button", { name: "Fabric", exact: true }).click();
  assert.equal(await page.getByLabel("Size of the image, number").count(), 0, "no image has no size");
  const give = (label, colourAt) =>
    page.getByLabel(label).setInputFiles({ name: "fabric.png", mimeType: "image/png", buffer: encode(64, 64, colourAt) });
  const is = (image) => preview.when((image) => Boolean(preview.store.state.settings.fabric[image]), image);
  await give("File of the image", (x) => (x < 32 ? [220, 40, 40] : [40, 40, 220]));
  await is("image");
  await preview.quiet();
  const whole = await preview.picture();
  assert.equal(sides(whole), "1,1,-1,-1", "10 cm by default");
  const size = page.getByLabel("Size of the image, number");
  await size.fill("50 mm");
  await size.press("Enter");
  const halves = await preview.picture();
  assert.equal(sides(halves), "1,-1,1,-1", "5 cm");
  await give("File of the normal map", () => [220, 128, 200]);
  await is("relief");
  await preview.quiet();
  const bent = await preview.picture();
  assert.ok(differing(halves, bent) > 0.05, "normals that lean are lit otherwise");
  assert.equal(await page.getByRole("radiogroup", { name: "Weave" }).count(), 0, "the map is in place of the weave");
  await page.reload();
  await preview.isDrawn(["model"]);
  await page.keyboard.press("4");
  await preview.quiet();
  assert.ok(differing(bent, await preview.picture()) < 0.01, "the browser keeps all of it");
  await page.getByRole("button", { name: "Fabric", exact: true }).click();
  await page.getByRole("button", { name: "Remove the normal map" }).click();
  await page.getByRole("button", { name: "Wine" }).click();
  assert.equal(sides(await preview.picture()), "1,1,1,1", "a colour replaces the image");
  await page.getByLabel("File of the image").setInputFiles({ name: "notes.txt", mimeType: "text/plain", buffer: Buffer.from("no image") });
  await page.getByText("notes.txt is no image").waitFor();
  assertClean(preview);
});

test("a picture of 4k has its size and no ground, and a turntable is a film", async (t) => {
  const preview = await layered(t, { shadows: false });
  const { page } = preview;
  const started = page.waitForEvent("download", { timeout: 120_000 });
  await page.getByRole("button", { name: "Screenshot" }).click();
  await page.getByRole("menuitem", { name: "4k" }).click();
  const image = decode(readFileSync(await (await started).path()));
  assert.deepEqual([image.width, image.height, image.channels], [3840, 2160, 4]);
  const alpha = (x, y) => image.pixels[4 * (y * image.width + x) + 3];
  assert.deepEqual([alpha(0, 0), alpha(3839, 0), alpha(0, 2159), alpha(1920, 1200)], [0, 0, 0, 255]);
  const film = await preview.evaluate(async () => {
    const blob = await preview.view.turntable(1);
    return [...new Uint8Array(await blob.arrayBuffer()).subarray(0, 4), blob.size];
  });
  assert.deepEqual(film.slice(0, 4), [0x1a, 0x45, 0xdf, 0xa3], "WebM");
  assert.ok(film[4] > 2000, `${film[4]} bytes`);
  assertClean(preview);
});
