// Cards: where a new one comes, several at once, values from one to another, sliders and numbers by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";

const OFFSET = "seam.side.normalOffset";

const shirt = (t, options) => show(t, sewnShirt(t), options);
const head = (preview, full) => preview.card(full).locator(".card-head");
const focusOnCard = (preview, full) => preview.when((full) => document.activeElement.dataset.card === full, full);

async function add(preview, kind, set) {
  await preview.page.getByRole("button", { name: `New ${kind}` }).click();
  const find = preview.page.getByLabel(`Find in New ${kind}`);
  await find.fill(set);
  await preview.after("render", () => find.press("Enter"));
}

const named = (preview, name) =>
  preview.when((name) => document.activeElement.getAttribute("aria-label") === `Name of ${name}`, name);

test("a new card is the last one, opens alone, in sight, and its name can be typed", async (t) => {
  const preview = await shirt(t, { viewport: SCREEN });
  await preview.openCard("seam.side");
  await add(preview, "fold", "pocket");
  await named(preview, "pocket");
  const order = ["fold.neck", "seam.shoulder", "seam.side", "fold.pocket"];
  assert.deepEqual(await preview.cards(), order);
  assert.deepEqual((await preview.document()).edits.render.operators, order);
  assert.deepEqual(await preview.state(({ open }) => [...open]), ["fold.pocket"]);
  await preview.page.waitForTimeout(600);
  const [card, panel] = await Promise.all(
    [preview.page.getByLabel("Name of pocket"), preview.page.locator(".recipe-scroll")].map((at) => at.boundingBox()),
  );
  assert.ok(card.y > panel.y && card.y + card.height < panel.y + panel.height, "the name is in sight");

  await preview.page.keyboard.type("chest_pocket");
  await preview.after("render", () => preview.page.keyboard.press("Enter")).catch(() => preview.quiet());
  await focusOnCard(preview, "fold.chest_pocket");
  assert.deepEqual(await preview.cards(), [...order.slice(0, 3), "fold.chest_pocket"]);
  assert.deepEqual(await preview.state(({ open }) => [...open]), ["fold.chest_pocket"]);
  assertClean(preview);
});

test("a copy keeps the sets, is the last one, opens alone, and its name can be typed", async (t) => {
  const preview = await shirt(t);
  await preview.pickOf("seam.shoulder", /^Duplicate/);
  await named(preview, "shoulder_2");
  assert.deepEqual((await preview.cards()).at(-1), "seam.shoulder_2");
  const { merged } = await preview.document();
  assert.deepEqual(merged.seam.shoulder_2, merged.seam.shoulder);
  await preview.page.keyboard.press("Escape");
  await focusOnCard(preview, "seam.shoulder_2");
  assert.deepEqual(await preview.state(({ open }) => [...open]), ["seam.shoulder_2"]);
  await preview.quiet();
  await preview.page.keyboard.press("Control+z");
  await preview.card("seam.shoulder_2").waitFor({ state: "detached" });
  assert.deepEqual((await preview.document()).edits, {}, "it was one step");
  assertClean(preview);
});

test("names and values are not cut off at 1280 by 720", async (t) => {
  const preview = await shirt(t, { viewport: SCREEN });
  const name = "a_name_of_a_seam_that_goes_from_the_left_shoulder_down_to_the_lowest_hem";
  await preview.pickOf("seam.side", /^Duplicate/);
  await named(preview, "side_2");
  await preview.page.keyboard.type(name);
  await preview.page.keyboard.press("Enter");
  await preview.card(`seam.${name}`).waitFor();
  await preview.set(`seam.${name}.normalOffset`, -12.3456);
  await preview.set(`seam.${name}.width`, 123.456);
  await preview.quiet();
  const cut = () =>
    preview.evaluate(() => {
      const measure = document.createElement("canvas").getContext("2d");
      const isCut = (element) => {
        const { clientWidth, scrollWidth } = element;
        if (element.tagName !== "INPUT") return scrollWidth > clientWidth + 1;
        const style = getComputedStyle(element);
        measure.font = style.font;
        const room = clientWidth - Number.parseFloat(style.paddingLeft) - Number.parseFloat(style.paddingRight);
        return measure.measureText(element.value || element.placeholder).width > room + 1;
      };
      const all = document.querySelectorAll(".card-name, .card-summary, .card-title, .number input, .option-label");
      return [...all].filter(isCut).map((element) => element.value || element.placeholder || element.textContent);
    });
  assert.deepEqual(await cut(), [], "with the card open");
  await preview.card(`seam.${name}`).locator(".card-title").click();
  await preview.card(`seam.${name}`).locator(".card-body").waitFor({ state: "detached" });
  assert.ok((await preview.card(`seam.${name}`).innerText()).includes(name));
  assert.deepEqual(await cut(), [], "with the card closed");
  assertClean(preview);
});

test("a value is set in all selected cards of a kind as one step, and one that differs says so", async (t) => {
  const preview = await shirt(t);
  await preview.set("seam.shoulder.width", 0.5);
  await preview.quiet();
  const before = await preview.document();
  await head(preview, "seam.shoulder").click({ modifiers: ["Control"] });
  assert.deepEqual(await preview.state(({ open }) => [...open]), [], "a click that selects opens nothing");
  await head(preview, "fold.neck").click({ modifiers: ["Control"] });
  await head(preview, "seam.side").click({ modifiers: ["Control"] });
  assert.match(await preview.card("seam.side").getAttribute("aria-label"), /, selected$/);
  await preview.page.getByText("3 cards selected.").waitFor();
  await preview.openCard("seam.side");
  assert.equal(await preview.state(({ chosen }) => chosen.size), 3, "a selected card opens with the others selected");

  const width = preview.row("seam.side.width");
  await width.getByText("mixed").waitFor();
  assert.equal(await preview.field("seam.side.width").getAttribute("placeholder"), "mixed");
  assert.equal(await preview.row(OFFSET).getByText("mixed").count(), 0, "both have -0.3");
  await preview.after("render", async () => {
    await preview.field("seam.side.width").fill("7mm");
    await preview.page.keyboard.press("Enter");
  });
  await width.getByText("mixed").waitFor({ state: "detached" });
  const { merged } = await preview.document();
  assert.deepEqual([merged.seam.shoulder.width, merged.seam.side.width], [0.7, 0.7]);
  assert.equal(merged.fold.neck.width, undefined);

  await preview.after("render", () => preview.drag(OFFSET, -0.1, 3));
  const { normalOffset } = (await preview.document()).merged.seam.shoulder;
  assert.ok(normalOffset < -0.3);
  assert.equal((await preview.document()).merged.seam.side.normalOffset, normalOffset);
  await preview.after("render", () => preview.page.keyboard.press("Control+z"));
  await preview.after("render", () => preview.page.keyboard.press("Control+z"));
  assert.deepEqual((await preview.document()).edits, before.edits, "two changes were two steps");

  await preview.card("seam.side").focus();
  await preview.page.keyboard.press("Escape");
  await preview.page.getByText("cards selected").waitFor({ state: "detached" });
  await preview.after("render", async () => {
    await preview.field("seam.side.width").fill("0.9");
    await preview.page.keyboard.press("Enter");
  });
  assert.equal((await preview.document()).merged.seam.shoulder.width, 0.5, "the others are as they were");
  assertClean(preview);
});

test("a range of cards is selected with Shift, by the mouse and by keys", async (t) => {
  const preview = await shirt(t);
  const chosen = () => preview.state(({ chosen }) => [...chosen]);
  await head(preview, "fold.neck").click({ modifiers: ["Control"] });
  await head(preview, "seam.side").click({ modifiers: ["Shift"] });
  assert.deepEqual(await chosen(), ["fold.neck", "seam.shoulder", "seam.side"]);
  await preview.card("seam.shoulder").focus();
  await preview.page.keyboard.press("Control+Space");
  assert.deepEqual(await chosen(), ["fold.neck", "seam.side"]);
  await preview.page.getByRole("button", { name: "Clear", exact: true }).click();
  assert.deepEqual(await chosen(), []);
  await preview.card("seam.side").focus();
  await preview.page.keyboard.press("Shift+Space");
  assert.deepEqual(await chosen(), ["seam.shoulder", "seam.side"]);
  await head(preview, "fold.neck").locator(".card-title").click();
  assert.deepEqual(await chosen(), [], "another card that is clicked ends it");
  assertClean(preview);
});

test("values are copied from card to card without the sets, as one step", async (t) => {
  const preview = await shirt(t);
  for (const [field, value] of [["width", 0.8], ["depth", 0.1], ["asymmetry", 0.5]]) {
    await preview.set(`seam.side.${field}`, value);
  }
  await preview.quiet();
  const before = await preview.document();
  await preview.card("seam.side").focus();
  await preview.page.keyboard.press("Control+c");
  await preview.card("seam.shoulder").focus();
  await preview.after("render", () => preview.page.keyboard.press("Control+v"));
  const { merged } = await preview.document();
  const { edges, ...values } = merged.seam.side;
  assert.deepEqual(merged.seam.shoulder, { ...values, edges: merged.seam.shoulder.edges });
  assert.notDeepEqual(merged.seam.shoulder.edges, edges);
  await preview.after("render", () => preview.page.keyboard.press("Control+z"));
  assert.deepEqual((await preview.document()).edits, before.edits, "one step");

  await preview.pickOf("seam.side", "Copy values");
  await preview.after("render", () => preview.pickOf("seam.shoulder", "Paste values"));
  assert.equal((await preview.document()).merged.seam.shoulder.asymmetry, 0.5);
  const after = (await preview.document()).edits;
  await preview.card("fold.neck").focus();
  await preview.page.keyboard.press("Control+v");
  await preview.page.getByText("the copied values are of a seam").waitFor();
  await preview.quiet();
  assert.deepEqual((await preview.document()).edits, after, "a fold has no such values");
  assertClean(preview);
});

test("a slider is as wide as the panel, and Shift makes a drag a tenth as far", async (t) => {
  const preview = await shirt(t, { viewport: SCREEN });
  await preview.openCard("seam.side");
  const slider = preview.slider(OFFSET);
  await slider.scrollIntoViewIfNeeded();
  const [track, card] = await Promise.all([slider, preview.card("seam.side")].map((at) => at.boundingBox()));
  assert.ok(track.width > 0.85 * card.width, `${track.width} of ${card.width}`);
  const { mouse, keyboard } = preview.page;
  const valueOf = async () => (await preview.document()).merged.seam.side.normalOffset;
  const way = async (keys) => {
    const box = await slider.boundingBox();
    const share = await slider.evaluate(({ value, min, max }) => (value - min) / (max - min));
    const [x, y] = [box.x + 6 + share * (box.width - 12), box.y + box.height / 2];
    const from = await valueOf();
    for (const key of keys) await keyboard.down(key);
    await mouse.move(x, y);
    await mouse.down();
    for (let i = 1; i <= 10; i++) await mouse.move(x + 6 * i, y);
    await mouse.up();
    for (const key of keys) await keyboard.up(key);
    await preview.quiet();
    return (await valueOf()) - from;
  };
  const usual = await way([]);
  const fine = await way(["Shift"]);
  assert.ok(usual > 0 && Math.abs(fine / usual - 0.1) < 0.03, `${fine} and ${usual}`);
  await preview.page.keyboard.press("Control+z");
  await preview.page.keyboard.press("Control+z");
  await preview.quiet();
  assert.deepEqual((await preview.document()).edits, {}, "each drag is one step");
  assertClean(preview);
});

test("a number is dragged to change it and clicked to type it", async (t) => {
  const preview = await shirt(t, { viewport: SCREEN });
  await preview.openCard("seam.side");
  const field = preview.field(OFFSET);
  await field.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await field.boundingBox();
  const { mouse, keyboard } = preview.page;
  const drag = async (way) => {
    await mouse.move(x + width / 2, y + height / 2);
    await mouse.down();
    for (let i = 1; i <= 5; i++) await mouse.move(x + width / 2 + (way * i) / 5, y + height / 2);
    await mouse.up();
    await preview.quiet();
  };
  const before = await preview.meshes();
  const step = Number(await preview.slider(OFFSET).getAttribute("data-step"));
  await drag(-20);
  const dragged = (await preview.document()).merged.seam.side.normalOffset;
  assert.ok(Math.abs(dragged - (-0.3 - 10 * step)) < step * 1.01, `${dragged}`);
  assert.equal(await field.evaluate((field) => field === document.activeElement), false);
  await preview.after("render", () => keyboard.press("Control+z"));
  assert.deepEqual([await preview.meshes(), (await preview.document()).edits], [before, {}], "one step");

  await mouse.click(x + width / 2, y + height / 2);
  assert.ok(await field.evaluate((field) => field === document.activeElement), "a click edits");
  await keyboard.type("-0.4");
  await preview.after("render", () => keyboard.press("Enter"));
  assert.equal((await preview.document()).merged.seam.side.normalOffset, -0.4, "the old number was selected");
  assertClean(preview);
});
