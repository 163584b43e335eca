// Draws the pictures of docs/preview: `cargo xtask picture`. The first argument is the folder.

import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { open, SCREEN } from "./support/browser.mjs";
import { example, Server } from "./support/server.mjs";

const folder = process.argv[2];
const ends = [];
const owner = { after: (end) => ends.push(end) };

/** What the view shows unless a picture says otherwise. */
const PLAIN = {
  roles: ["model", "sim", "render"],
  layout: "side",
  shading: "cloth",
  wires: true,
  edgeSets: false,
  flat: false,
  smooth: 0,
};

const PICTURES = [
  { name: "cloth", settings: { layout: "large", large: "render" }, act: (page) => page.locator('[data-card="seam.shoulder"] .card-title').hover() },
  { name: "dark", settings: { layout: "large", large: "render" }, theme: "dark" },
  { name: "face-sets", settings: { shading: "faceSets", wires: false } },
  { name: "edge-sets", settings: { edgeSets: true } },
  { name: "checker", settings: { shading: "checker", wires: false } },
  { name: "heat", settings: { shading: "values", values: "quality:angle", roles: ["sim"] } },
  { name: "painted", settings: { shading: "values", values: "simDensity", wires: false } },
  { name: "flat", settings: { layout: "large", large: "model", flat: true, wires: false } },
  { name: "over", settings: { layout: "over", roles: ["sim", "render"] } },
  { name: "seam", settings: { roles: ["render"] }, act: openCard },
  { name: "select", settings: { roles: ["model", "render"] }, act: selectHem },
  { name: "warnings", act: openWarning },
  { name: "save", act: (page) => page.getByRole("button", { name: "Save", exact: true }).click() },
  // The last one, as it edits.
  { name: "split", settings: { layout: "large", large: "render", wires: false }, act: splitView },
];

async function openCard(page) {
  await page.locator('[data-card="seam.side"] .card-title').click();
  await page.locator('[data-card="seam.side"]').scrollIntoViewIfNeeded();
}

/** Deeper side seams on the right. */
async function splitView(page) {
  await page.keyboard.press("x");
  await page.evaluate(() => preview.store.set("seam.side.normalOffset", -1));
  await sleep(3000);
}

async function selectHem(page) {
  await page.keyboard.press("e");
  await page.keyboard.type("rings(borders.largest, 2)");
  await page.keyboard.press("Enter");
}

async function openWarning(page) {
  await page.getByTestId("warning-count").click();
  await page.locator(".warning").first().click();
}

/** A pocket and a dart while the view moves, beside the same at rest. */
async function drawRest() {
  const preview = await open(owner, server, { viewport: { width: 780, height: 520 } });
  await preview.settings({ ...PLAIN, roles: ["render"], wires: false });
  await preview.quiet();
  await preview.evaluate(() => {
    const canvas = document.querySelector("canvas");
    const { x, y, width, height } = canvas.getBoundingClientRect();
    const at = { clientX: x + 0.56 * width, clientY: y + 0.62 * height };
    for (let i = 0; i < 3; i++) canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -240, cancelable: true, ...at }));
  });
  await sleep(1500);
  const text = await preview.evaluate(async () => {
    const canvas = document.querySelector("canvas");
    const both = new OffscreenCanvas(2 * canvas.width, canvas.height);
    const draw = (image, x) => both.getContext("2d").drawImage(image, x, 0);
    preview.store.settings({});
    await new Promise((resolve) => requestAnimationFrame(() => resolve(draw(canvas, 0))));
    draw(await createImageBitmap(await preview.view.screenshot()), canvas.width);
    const blob = await both.convertToBlob({ type: "image/jpeg", quality: 0.85 });
    const bytes = new Uint8Array(await blob.arrayBuffer());
    return bytes.reduce((text, byte) => text + String.fromCharCode(byte), "");
  });
  writeFileSync(join(folder, "rest.jpg"), Buffer.from(text, "latin1"));
}

const server = await Server.start(owner, example("sewn/coat.usda"));
for (const { name, settings, theme = "light", act } of PICTURES) {
  const preview = await open(owner, server, { viewport: SCREEN, deviceScaleFactor: 1.5, colorScheme: theme });
  await preview.settings({ ...PLAIN, ...settings });
  await preview.quiet();
  await preview.page.keyboard.press("f");
  await act?.(preview.page);
  await sleep(1500);
  await preview.picture();
  const path = join(folder, `${name}.jpg`);
  await preview.page.screenshot({ path, type: "jpeg", quality: 85 });
  console.log(path);
  await preview.page.context().close();
}
await drawRest();
for (const end of ends) await end();
process.exit();
