// What the page says: lengths in units that artists use, sets in words, where warnings are and how they end.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { sewnShirt, variantSheet } from "./support/garments.mjs";
import { example } from "./support/server.mjs";

test("lengths are in centimetres, whatever the unit of the garment", async (t) => {
  const garment = variantSheet(t);
  const text = readFileSync(garment, "utf8");
  writeFileSync(garment, text.replace("metersPerUnit = 0.01", "metersPerUnit = 0.1"));
  const preview = await show(t, garment, { viewport: SCREEN });
  const seam = { edges: ["borders.1"], width: 0.05, normalOffset: -0.02 };
  await preview.after("render", () => preview.evaluate((seam) => preview.store.edit(() => ({ seam: { hem: seam } })), seam));
  assert.match(await preview.card("seam.hem").innerText(), /0\.5 × −0\.2 cm/);
  await preview.openCard("seam.hem");
  const field = preview.field("seam.hem.width");
  assert.equal(await field.inputValue(), "0.5");
  assert.match(await preview.row("seam.hem.width").innerText(), /cm/);
  const type = async (text, width) => {
    await preview.after("render", async () => {
      await field.fill(text);
      await preview.page.keyboard.press("Enter");
    });
    assert.equal((await preview.document()).edits.seam.hem.width, width, text);
  };
  await type("0.8", 0.08);
  await type("7 mm", 0.07);
  await preview.after("render", () => preview.drag("seam.hem.width", 0.2));
  const { width } = (await preview.document()).edits.seam.hem;
  assert.equal(await field.inputValue(), String(Number((10 * width).toPrecision(6))), "a slider is in the same unit");
  assertClean(preview);
});

test("cards come first, their sets are in words, and meshes are switches with an eye", async (t) => {
  const preview = await show(t, sewnShirt(t), { viewport: SCREEN });
  const { page } = preview;
  const card = await page.locator("[data-card]").first().boundingBox();
  assert.ok(card.y > 0 && card.y + card.height < SCREEN.height, `the first card is seen: ${JSON.stringify(card)}`);
  await preview.openCard("seam.side");
  assert.ok(await preview.card("seam.side").getByRole("button", { name: "side seams", exact: true }).isVisible());
  const role = page.getByRole("button", { name: "Render", exact: true });
  const eye = () => role.locator("path").getAttribute("d");
  const open = await eye();
  await role.click();
  await preview.when(() => !preview.store.state.settings.roles.includes("render"));
  assert.notEqual(await eye(), open, "a mesh that is hidden has a closed eye");
  // Heat of a mesh that is not there yet is announced: the answers of the server wait.
  const [said, then] = await preview.evaluate(async () => {
    const [socket, held] = [observed.sockets.at(-1), []];
    const { onmessage } = socket;
    socket.onmessage = (event) => held.push(event);
    const legend = async () => {
      await new Promise(requestAnimationFrame);
      return document.querySelector(".legends").innerText;
    };
    preview.store.settings({ shading: "values", values: "quality:length" });
    const said = await legend();
    while (held.length === 0) await new Promise(requestAnimationFrame);
    socket.onmessage = onmessage;
    held.forEach((event) => onmessage(event));
    while (preview.store.state.heat === null) await new Promise(requestAnimationFrame);
    return [said, await legend()];
  });
  assert.match(said, /heat is being made/i);
  assert.doesNotMatch(then, /being made/i);
  assertClean(preview);
});

test("a warning has a way from place to place, and is fixed where its cure is a value", async (t) => {
  const preview = await show(t, example("sewn/coat.usda"), { viewport: SCREEN, args: ["--set", "render.level=1"] });
  const { page } = preview;
  await preview.evaluate(() => preview.store.settings({ figures: true }));
  const findings = () => preview.state(({ products }) => products.render.warnings);
  // Of those with a cure, one with several places.
  const rows = page.locator("li").filter({ has: page.getByRole("button", { name: "Fix it" }) });
  let row = null;
  for (let at = 0; at < (await rows.count()) && row === null; at++) {
    await rows.nth(at).locator("button.warning").click();
    if (await preview.state(({ place }) => place)) row = rows.nth(at);
  }
  assert.ok(row, "the coat has a warning with places and a cure");
  await preview.isStill();
  const marked = await preview.state(({ marked }) => marked);
  const { count } = await preview.state(({ place }) => place);
  assert.match(await row.innerText(), new RegExp(`place 1 of ${count}`));
  const target = () => preview.evaluate(() => preview.view.aim().target);
  const first = await target();
  await row.getByRole("button", { name: "Next" }).click();
  await preview.isStill();
  assert.notDeepEqual(await target(), first, "the camera goes to the next one");
  await row.getByRole("button", { name: "Previous" }).click();
  await preview.isStill();
  assert.deepEqual(await target(), first);

  const field = { "narrow-seam": "width", "shallow-seam": "normalOffset", "thin-layer": "thickness" }[marked.code];
  const [kind, name] = marked.place.split(".");
  const asked = () => preview.evaluate(([kind, name, field]) => preview.store.state.document.merged[kind][name][field], [kind, name, field]);
  const before = await asked();
  await preview.after("render", () => row.getByRole("button", { name: "Fix it" }).click());
  const share = (await asked()) / before;
  assert.ok(share <= marked.amount && share > 0.9 * marked.amount, `${share} of what was asked, where ${marked.amount} is left`);
  const after = (await findings()).find(({ code, place }) => code === marked.code && place === marked.place);
  assert.ok(!after || after.amount > marked.amount, "less is missing then");
  assertClean(preview);
});

test("Space plays after the slider of the cache was used", async (t) => {
  const preview = await show(t, example("tshirt.usda"), { ready: false });
  await preview.isDrawn(["model"]);
  const plays = await preview.evaluate(() => {
    const slider = document.createElement("input");
    slider.type = "range";
    document.body.append(slider);
    preview.store.update({ shot: { frames: 3, frame: 0, fault: null } });
    let played = 0;
    preview.store.player.toggle = () => (played += 1);
    slider.focus();
    slider.dispatchEvent(new KeyboardEvent("keydown", { key: " ", bubbles: true }));
    slider.remove();
    preview.store.update({ shot: null });
    return played;
  });
  assert.equal(plays, 1);
  assertClean(preview);
});
