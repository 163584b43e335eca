// Draws the pictures of docs/preview: `cargo xtask picture`. The first argument is the folder.

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
  { name: "flat", settings: { shading: "checker", flat: true } },
  { name: "over", settings: { layout: "over", roles: ["sim", "render"] } },
  { name: "seam", settings: { roles: ["render"] }, act: openCard },
  { name: "select", settings: { roles: ["model", "render"] }, act: selectHem },
  { name: "warnings", act: openWarning },
  { name: "save", act: (page) => page.getByRole("button", { name: "Save", exact: true }).click() },
];

async function openCard(page) {
  await page.locator('[data-card="seam.side"] .card-title').click();
  await page.locator('[data-card="seam.side"]').scrollIntoViewIfNeeded();
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
for (const end of ends) await end();
process.exit();
