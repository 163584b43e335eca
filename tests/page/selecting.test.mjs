// Sets are picked on the model, and seams and folds made of them.

import assert from "node:assert/strict";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { assertClean, SCREEN, show } from "./support/browser.mjs";
import { assertSame, bareShirt, build, substitute, variantSheet } from "./support/garments.mjs";
import { placeOf } from "./support/picking.mjs";

const expressionOf = (preview) => preview.state(({ selection }) => selection?.expression ?? null);

/** Waits for a selection whose expression matches; null is none. */
function selected(preview, pattern) {
  const is = (source) => {
    const expression = preview.store.state.selection?.expression ?? null;
    return source === null ? expression === null : expression !== null && new RegExp(source).test(expression);
  };
  return preview.when(is, pattern && pattern.source, 10_000).catch(async (error) => {
    throw new Error(`${pattern} is not ${await expressionOf(preview)}: ${error.message}`);
  });
}

async function save(preview, file) {
  await preview.evaluate((path) => preview.store.command({ type: "save", path, overwrite: true }), file);
  await preview.when((path) => preview.store.state.save?.status === "saved" && preview.store.state.save.path === path, file);
}

test("a bare shirt gets a hem and a seam by clicks and keys", async (t) => {
  const garment = bareShirt(t);
  const preview = await show(t, garment, { viewport: SCREEN });
  const { mouse, keyboard } = preview.page;
  const bar = preview.page.getByRole("toolbar", { name: "Selection" });
  const before = await preview.meshes();

  const hem = await placeOf(preview, "borders.1");
  await mouse.click(hem.x, hem.y);
  await selected(preview, /^pickedEdges\("[0-9a-f]{8}", "\d+-\d+"\)$/);
  assert.match(await bar.innerText(), /1 edge ·/);
  await keyboard.press("l");
  await selected(preview, /^borders\.1$/);
  assert.match(await bar.innerText(), /24 edges · 1\.13 m · closed/);
  await keyboard.press("+");
  await selected(preview, /^rings\(borders\.1\)$/);
  await keyboard.press("+");
  await selected(preview, /^rings\(borders\.1, 2\)$/);
  assert.match(await bar.innerText(), /48 faces/);
  await preview.after("render", () => keyboard.press("n"));
  assert.deepEqual(await preview.cards(), ["fold.fold"]);
  assert.equal(await expressionOf(preview), null, "the selection ends");

  const seam = await placeOf(preview, "uvSeams");
  await mouse.click(seam.x, seam.y);
  await keyboard.press("l");
  await selected(preview, /^uvSeams\.\d+$/);
  const chain = await expressionOf(preview);
  const name = chain.replace(".", "_");
  const sewn = await preview.after("render", () => bar.getByRole("button", { name: "New seam" }).click());
  assert.deepEqual(await preview.cards(), ["fold.fold", `seam.${name}`]);
  assert.ok(sewn.render.faces > before.render.faces);
  const { edits } = await preview.document();
  assert.deepEqual([edits.fold.fold.faces, edits.seam[name].edges], [["rings(borders.1, 2)"], [chain]]);
  await keyboard.press("Control+z");
  await preview.card(`seam.${name}`).waitFor({ state: "detached" });
  assertClean(preview);
});

test("a garment without seams shows the steps to the first one, until it is there", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { mouse, keyboard } = preview.page;
  const steps = preview.page.getByRole("note", { name: "How to make a seam" });
  const current = () => steps.locator("[aria-current=step]").innerText();
  assert.match(await current(), /Click\s+an edge/);
  await preview.settings({ flat: true });
  await steps.waitFor({ state: "detached" });
  await preview.settings({ flat: false });
  const seam = await placeOf(preview, "uvSeams");
  await mouse.click(seam.x, seam.y);
  await selected(preview, /^pickedEdges/);
  assert.match(await current(), /L\s+the whole line/);
  await keyboard.press("l");
  await selected(preview, /^uvSeams\.\d+$/);
  assert.match(await current(), /N\s+a seam along it/);
  await preview.after("render", () => keyboard.press("n"));
  await steps.waitFor({ state: "detached" });
  // The name of the new seam is kept.
  await keyboard.press("Enter");
  await preview.after("render", () => keyboard.press("Control+z"));
  await steps.getByRole("button", { name: "Hide these steps" }).click();
  await steps.waitFor({ state: "detached" });
  await preview.page.reload();
  await preview.page.waitForFunction(() => window.preview?.view?.stats("render"), null, { polling: 20 });
  assert.equal(await steps.count(), 0, "whoever hid them does not see them again");
  assertClean(preview);
});

test("shift adds, alt takes away, control adds the path, and each is undone", async (t) => {
  const preview = await show(t, variantSheet(t), { viewport: SCREEN });
  const { keyboard, mouse } = preview.page;
  // The middle row of the sheet.
  const points = await preview.evaluate(() => {
    const { sets, numbers } = observed.elements.model;
    const { offset, length } = sets.find(({ kind, family }) => kind === "edge" && !family.startsWith("tailor"));
    return [...numbers.slice(offset, offset + length)];
  });
  const ends = points.filter((_, at) => at % 2 === 0).concat(points.at(-1));
  const click = async (from, modifier) => {
    const [a, b] = await preview.evaluate((pair) => pair.map((p) => preview.view.project("model", p)), [ends[from], ends[from + 1]]);
    const box = await preview.page.locator("canvas").boundingBox();
    if (modifier) await keyboard.down(modifier);
    await mouse.click(box.x + (a.x + b.x) / 2, box.y + (a.y + b.y) / 2);
    if (modifier) await keyboard.up(modifier);
  };
  const run = (...numbers) => new RegExp(`"(${numbers.join("-")}|${[...numbers].reverse().join("-")})"\\)$`);
  await click(0);
  await selected(preview, run(ends[0], ends[1]));
  await click(1, "Shift");
  await selected(preview, run(ends[0], ends[1], ends[2]));
  assert.equal(await preview.page.getByRole("dialog", { name: "What was clicked" }).count(), 0, "no popover in the way");
  await click(4, "Control");
  await selected(preview, run(...ends.slice(0, 6)));
  await click(0, "Alt");
  await selected(preview, run(...ends.slice(1, 6)));
  await keyboard.press("Control+z");
  await selected(preview, run(...ends.slice(0, 6)));
  await keyboard.press("Control+Shift+z");
  await selected(preview, run(...ends.slice(1, 6)));
  await keyboard.press("Control+z");
  await keyboard.press("Control+z");
  await selected(preview, run(ends[0], ends[1], ends[2]));
  await keyboard.press("Escape");
  await selected(preview, null);
  assertClean(preview);
});

test("picked edges are saved with the mesh that they are of, and refused on another", async (t) => {
  const garment = bareShirt(t);
  const preview = await show(t, garment, { viewport: SCREEN });
  const { keyboard, mouse } = preview.page;
  const seam = await placeOf(preview, "uvSeams");
  await mouse.click(seam.x, seam.y);
  await selected(preview, /^pickedEdges/);
  await preview.after("render", () => keyboard.press("n"));
  assert.deepEqual(await preview.cards(), ["seam.seam"]);
  const [edges] = (await preview.document()).edits.seam.seam.edges;
  assert.match(edges, /^pickedEdges\("[0-9a-f]{8}", "\d+-\d+"\)$/);
  assert.match(await preview.card("seam.seam").innerText(), /1 picked edge/);

  for (const file of [join(dirname(garment), "look.usda"), join(dirname(garment), "look.tailor")]) {
    await save(preview, file);
    assertSame(await preview.points("render"), (await build(t, file)).render, "the render mesh is that on screen");
  }

  // Another mesh: its first face begins with another point.
  substitute(garment, /(faceVertexIndices = \[)(\d+), (\d+), (\d+), (\d+),/, "$1$3, $4, $5, $2,");
  await preview.when(() => preview.store.state.faults.recipe.some(({ text }) => text.includes("picked on other faces")));
  assert.ok(await preview.page.getByText("picked on other faces").first().isVisible());
  assert.deepEqual(await preview.cards(), ["seam.seam"], "nothing is dropped");
  assertClean(preview);
});

test("a selection is typed, sewn and taken up again by keys alone", async (t) => {
  const preview = await show(t, bareShirt(t));
  const { keyboard } = preview.page;
  await keyboard.press("e");
  const field = preview.page.getByLabel("Selection as an expression");
  await field.waitFor();
  await keyboard.type("uvSeam");
  await keyboard.press("Enter");
  await preview.page.getByText("did you mean uvSeams?").waitFor();
  assert.equal(await field.inputValue(), "uvSeam", "what cannot be used stays, to be mended");
  await keyboard.type("s - borders.highest");
  await keyboard.press("Enter");
  await selected(preview, /^uvSeams - borders\.highest$/);
  await keyboard.press("e");
  await keyboard.type("borders.highest");
  await keyboard.press("Enter");
  await selected(preview, /^borders\.highest$/);
  await preview.after("render", () => keyboard.press("n"));
  assert.deepEqual(await preview.cards(), ["seam.borders_highest"]);
  const chip = preview.card("seam.borders_highest").getByRole("button", { name: "borders.highest", exact: true });
  await chip.focus();
  await keyboard.press("Enter");
  await selected(preview, /^borders\.highest$/);
  assertClean(preview);
});

test("a border is picked from beyond the cloth, and its set added to a seam that exists", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { keyboard, mouse } = preview.page;
  const hem = await placeOf(preview, "borders.1");
  let y = hem.y;
  const isCloth = () => preview.state(({ hovered }) => hovered !== null);
  do {
    y += 1;
    await mouse.move(hem.x, y);
    await preview.page.waitForTimeout(700);
  } while ((await isCloth()) && y < hem.y + 40);
  await mouse.click(hem.x, y + 3);
  await selected(preview, /^pickedEdges/);
  await keyboard.press("l");
  await selected(preview, /^borders\.1$/);
  await preview.after("render", () => keyboard.press("n"));
  // The name of the new seam is kept.
  await keyboard.press("Enter");
  await keyboard.press("e");
  await keyboard.type("borders.highest");
  await keyboard.press("Enter");
  await selected(preview, /^borders\.highest$/);
  await preview.card("seam.borders_1").getByRole("button", { name: "Add to Edges" }).click();
  await preview.after("render", () => preview.page.getByRole("menuitem", { name: /The selection/ }).click());
  assert.deepEqual((await preview.document()).edits.seam.borders_1.edges, ["borders.1", "borders.highest"]);
  await keyboard.press("Control+z");
  await preview.when(() => preview.store.state.document.edits.seam.borders_1.edges.length === 1);
  assertClean(preview);
});

test("selected faces get smaller triangles, and again those of their surroundings", async (t) => {
  const garment = bareShirt(t);
  const preview = await show(t, garment, { viewport: SCREEN });
  const { page } = preview;
  const select = async (expression, pattern) => {
    await page.keyboard.press("e");
    await page.keyboard.type(expression);
    await page.keyboard.press("Enter");
    await selected(preview, pattern);
  };
  const density = async () => (await preview.document()).merged.sim?.density ?? "";
  await select("rings(borders.1, 2)", /^rings\(borders\.1, 2\)$/);
  const bar = page.getByRole("toolbar", { name: "Selection" });
  const isDisabled = (name) => bar.getByRole("button", { name }).isDisabled();
  assert.deepEqual([await isDisabled("Finer"), await isDisabled("Coarser")], [true, true], "the shirt has a painted density");
  await page.keyboard.press("d");
  await page.getByText("The density is painted").waitFor();
  const before = (await preview.after("sim", () => preview.set("sim.density", ""))).sim.faces;
  assert.deepEqual([await isDisabled("Finer"), await isDisabled("Coarser")], [false, true], "nothing is finer yet");
  const finer = (await preview.after("sim", () => bar.getByRole("button", { name: "Finer" }).click())).sim.faces;
  assert.ok(finer > 1.2 * before, `${finer} and ${before} triangles`);
  assert.equal(await density(), "rings(borders.1, 2)");
  assert.equal(await expressionOf(preview), null, "the selection ends");

  await select("rings(borders.1)", /^rings\(borders\.1\)$/);
  const less = (await preview.after("sim", () => page.keyboard.press("Shift+d"))).sim.faces;
  assert.ok(before < less && less < finer, `${before}, ${less}, ${finer}`);
  assert.equal(await density(), "rings(borders.1, 2) - rings(borders.1)");
  const file = join(dirname(garment), "finer.usda");
  await save(preview, file);
  assertSame(await preview.points("sim"), (await build(t, file)).sim, "the simulation mesh is that on screen");
  await preview.after("sim", () => page.keyboard.press("Control+z"));
  assert.equal(await density(), "rings(borders.1, 2)", "one step of undo");

  // A list is one set, and picked faces are one run of numbers however often they come.
  await preview.after("sim", () => preview.set("sim.density", "rings(borders.1), rings(borders.highest)"));
  await select("rings(borders.highest)", /^rings\(borders\.highest\)$/);
  await preview.after("sim", () => page.keyboard.press("Shift+d"));
  assert.equal(await density(), "(rings(borders.1), rings(borders.highest)) - rings(borders.highest)");
  await preview.after("sim", () => preview.set("sim.density", ""));
  const { checksum } = await preview.state(({ garment }) => ({ checksum: garment.checksum }));
  for (const face of [3, 4, 5]) {
    await select(`pickedFaces("${checksum}", "${face}")`, /^pickedFaces/);
    await preview.after("sim", () => page.keyboard.press("d"));
  }
  assert.equal(await density(), `pickedFaces("${checksum}", "3-5")`);
  await select(`pickedFaces("${checksum}", "3-5")`, /^pickedFaces/);
  await preview.after("sim", () => page.keyboard.press("Shift+d"));
  assert.equal(await density(), "", "nothing is finer any more");
  await preview.after("sim", () => preview.set("sim.density", "rings(borders.1, 2)"));

  await select("borders.1", /^borders\.1$/);
  await page.keyboard.press("d");
  await page.getByText("select faces first").waitFor();
  assert.equal(await density(), "rings(borders.1, 2)");
  assertClean(preview);
});

test("keys that follow the name of a new operator at once go where they are typed", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { keyboard } = preview.page;
  await keyboard.press("e");
  await keyboard.type("borders.1");
  await keyboard.press("Enter");
  await selected(preview, /^borders\.1$/);
  await preview.after("render", () => keyboard.press("n"));
  // Both keys come before the next picture.
  const label = await preview.evaluate(async () => {
    const press = (key) => (document.activeElement ?? document.body).dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
    const frame = () => new Promise(requestAnimationFrame);
    const name = document.activeElement;
    press("Enter");
    name.blur();
    press("e");
    for (let i = 0; i < 5; i++) await frame();
    return document.activeElement.getAttribute("aria-label");
  });
  assert.equal(label, "Selection as an expression");
  assertClean(preview);
});

test("an edit ends the steps of a selection, so that undo goes back in the order of time", async (t) => {
  const preview = await show(t, bareShirt(t), { viewport: SCREEN });
  const { keyboard, mouse } = preview.page;
  const hem = await placeOf(preview, "borders.1");
  await mouse.click(hem.x, hem.y);
  await selected(preview, /^pickedEdges/);
  await preview.after("render", () => preview.set("render.level", 0));
  await preview.after("render", () => keyboard.press("Control+z"));
  await selected(preview, /^pickedEdges/);
  await keyboard.press("e");
  await keyboard.type("uvSeams.99");
  await keyboard.press("Enter");
  await preview.page.getByText("The set has no elements").waitFor();
  await selected(preview, /^pickedEdges/);
  assertClean(preview);
});
