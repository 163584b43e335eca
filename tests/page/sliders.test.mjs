// Options are changed by hand, and the meshes follow.

import assert from "node:assert/strict";
import { test } from "node:test";
import { assertClean, show } from "./support/browser.mjs";
import { sewnShirt } from "./support/garments.mjs";
import { differing } from "./support/png.mjs";

const OFFSET = "seam.side.normalOffset";

async function shirt(t) {
  const preview = await show(t, sewnShirt(t));
  await preview.openCard("seam.side");
  return preview;
}

const offsetOf = ({ merged }) => merged.seam.side.normalOffset;

test("a dragged slider moves the points of the render mesh alone, as one step of undo", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  const dragged = await preview.after("render", () => preview.drag(OFFSET, -0.2));
  assert.notEqual(dragged.render.checksum, before.render.checksum);
  assert.equal(dragged.render.faces, before.render.faces);
  assert.deepEqual([dragged.sim, dragged.model], [before.sim, before.model]);
  const { canUndo, edits, unsaved } = await preview.document();
  assert.ok(canUndo && unsaved && edits.seam.side.normalOffset < -0.3);
  const sent = await preview.evaluate(() => observed.sent.filter(({ type }) => type === "edit"));
  assert.ok(sent.length > 2, "the mesh follows the hand");
  assert.equal(new Set(sent.map(({ gesture }) => gesture)).size, 1);

  const undone = await preview.after("render", () => preview.page.keyboard.press("Control+z"));
  assert.deepEqual(undone, before);
  assert.equal((await preview.document()).canUndo, false, "one drag is one step");
  const redone = await preview.after("render", () => preview.page.keyboard.press("Control+Shift+Z"));
  assert.deepEqual(redone, dragged);
  assertClean(preview);
});

test("arrow keys on a slider step, ten at a time with shift", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  const slider = preview.slider(OFFSET);
  const step = Number(await slider.getAttribute("data-step"));
  await slider.focus();
  const near = (a, b) => Math.abs(a - b) < step / 1000;
  const stepped = await preview.after("render", () => preview.page.keyboard.press("ArrowRight"));
  const one = offsetOf(await preview.document());
  assert.ok(one > -0.3 && one <= -0.3 + step * 1.001, `${one}`);
  await preview.after("render", () => preview.page.keyboard.press("Shift+ArrowRight"));
  const eleven = offsetOf(await preview.document());
  assert.ok(near(eleven - one, 10 * step), `${eleven} after ${one}`);
  assert.equal(stepped.render.faces, before.render.faces);
  assert.deepEqual(stepped.sim, before.sim);
});

test("two drags are two steps", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  const first = await preview.after("render", () => preview.drag(OFFSET, -0.1, 3));
  await preview.after("render", () => preview.drag(OFFSET, -0.1, 3));
  assert.deepEqual(await preview.after("render", () => preview.page.keyboard.press("Control+z")), first);
  assert.deepEqual(await preview.after("render", () => preview.page.keyboard.press("Control+z")), before);
  assert.equal((await preview.document()).canUndo, false);
});

test("an option of the simulation mesh leaves the render mesh as it is", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const before = await preview.meshes();
  const after = await preview.after("sim", () => preview.drag("sim.maxEdgeLength", 0.2, 3));
  assert.ok(after.sim.faces < before.sim.faces, "longer edges are fewer");
  assert.deepEqual([after.render, after.model], [before.render, before.model]);
  assertClean(preview);
});

test("an edited option goes back to the garment's value", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  const reset = preview.row(OFFSET).getByLabel("Reset Normal offset");
  assert.ok(await reset.isDisabled());
  await preview.after("render", async () => {
    await preview.field(OFFSET).fill("-0.55");
    await preview.page.keyboard.press("Enter");
  });
  assert.equal(offsetOf(await preview.document()), -0.55);
  assert.deepEqual(await preview.after("render", () => reset.click()), before);
  assert.deepEqual((await preview.document()).edits, {});
  assert.ok(await reset.isDisabled());
});

test("lengths take sums and units, and a value that is typed back is no edit", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  const type = async (text) => {
    await preview.field(OFFSET).fill(text);
    await preview.page.keyboard.press("Enter");
  };
  // The garment is in centimetres.
  for (const [text, expected] of [
    ["-1/4", -0.25],
    ["-(1 + 0,5) * .2 - 0.1", -0.4],
    ["-2 mm", -0.2],
    ["-0.1in", -0.254],
  ]) {
    await preview.after("render", () => type(text));
    assert.ok(Math.abs(offsetOf(await preview.document()) - expected) < 1e-6, text);
  }
  const last = offsetOf(await preview.document());
  for (const text of ["3 apples", "1//2", "(1", "2 3", "1/0", "9".repeat(200)]) {
    await preview.field(OFFSET).fill(text);
    assert.equal(await preview.field(OFFSET).getAttribute("aria-invalid"), "true", text);
    await preview.page.keyboard.press("Enter");
    assert.equal(offsetOf(await preview.document()), last, text);
  }
  assert.deepEqual(await preview.after("render", () => type("-3mm")), before);
  assert.deepEqual((await preview.document()).edits, {}, "-0.3 is what the garment has");
  assertClean(preview);
});

test("a number that is no length takes no unit", async (t) => {
  const preview = await show(t, sewnShirt(t));
  const field = preview.field("sim.grading");
  await field.fill("2 mm");
  assert.equal(await field.getAttribute("aria-invalid"), "true");
  await field.fill("6/4");
  await preview.page.keyboard.press("Enter");
  await preview.when(() => preview.store.state.document.edits.sim?.grading === 1.5, "the quotient");
});

test("the state as it was opened is shown while Shift and C are held", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  await preview.after("render", () => preview.drag(OFFSET, -0.2, 3));
  const after = await preview.after("render", () => preview.drag(OFFSET, -0.1, 3));
  const { keyboard } = preview.page;
  await keyboard.down("Shift");
  assert.deepEqual(await preview.after("render", () => keyboard.down("C")), before);
  assert.ok(await preview.page.getByText("As it was saved or opened").isVisible());
  assert.deepEqual(await preview.after("render", () => keyboard.up("C")), after);
  await keyboard.up("Shift");
});

test("the state before is shown while C is held, and the edit returns", async (t) => {
  const preview = await shirt(t);
  const before = await preview.meshes();
  const after = await preview.after("render", () => preview.drag(OFFSET, -0.2, 3));
  const held = await preview.after("render", () => preview.page.keyboard.down("c"));
  assert.deepEqual(held, before);
  assert.ok(await preview.page.getByText("Before the last change").isVisible());
  const { comparing, edits } = await preview.document();
  assert.ok(comparing && edits.seam.side.normalOffset < -0.3, "the edits stay");
  const released = await preview.after("render", () => preview.page.keyboard.up("c"));
  assert.deepEqual(released, after);
  assert.equal((await preview.document()).canRedo, false);
  await preview.page.getByText("Before the last change").waitFor({ state: "detached" });
});

test("a split view keeps what was shown on the left, and edits go on on the right", async (t) => {
  const preview = await shirt(t);
  const { keyboard } = preview.page;
  await preview.settings({ roles: ["render"], shadows: false });
  await preview.page.mouse.move(1, 1);
  const [left, right] = [[0, 0.48], [0.52, 1]];
  // The ground and the hollows follow the bounds of the mesh of now by a shade.
  const same = (a, b, part) => differing(a, b, part, 12) < 0.001;
  const before = await preview.picture();
  await keyboard.press("x");
  // Its wires are others on both sides.
  await preview.after("render", () => preview.set("render.level", 2));
  const split = await preview.picture();
  assert.ok(same(split, before, left) && !same(split, before, right), "the left is as it was");

  const line = preview.page.getByRole("slider", { name: "Split" });
  await line.focus();
  await keyboard.press("ArrowLeft");
  assert.equal(await line.getAttribute("aria-valuenow"), "48");
  await line.blur();
  await keyboard.press("x");
  assert.equal(await line.count(), 0);
  const after = await preview.picture();
  assert.ok(same(split, after, right) && !same(split, after, left), "the right is as it is now");

  await preview.after("render", () => keyboard.down("c"));
  await keyboard.press("x");
  await preview.after("render", () => keyboard.up("c"));
  const held = await preview.picture();
  assert.ok(same(held, before, left) && same(held, after, right), "what C shows is kept");
  await keyboard.press("Escape");
  assert.ok(same(await preview.picture(), after, left));
  assertClean(preview);
});
