// What the tests do in a page, and what they ask it.

import { setTimeout as sleep } from "node:timers/promises";
import { decode } from "./png.mjs";

/** Time without messages after which all is built. [ms] */
const QUIET = 250;

export class Preview {
  /** Errors that the page threw or logged. */
  problems = [];
  thrown = [];
  /** Origins that were asked for anything. */
  origins = new Set();

  constructor(page, server) {
    this.page = page;
    this.server = server;
    page.on("pageerror", (error) => {
      this.problems.push(String(error));
      this.thrown.push(String(error));
    });
    page.on("console", (message) => {
      if (message.type() === "error") this.problems.push(message.text());
    });
    page.on("request", (request) => {
      const { protocol, origin } = new URL(request.url());
      if (protocol !== "data:" && protocol !== "blob:") this.origins.add(origin);
    });
    page.on("websocket", (socket) => this.origins.add(new URL(socket.url()).origin.replace(/^ws:/, "http:")));
  }

  evaluate(act, value) {
    return this.page.evaluate(act, value);
  }

  /** Waits for a condition in the page. */
  when(condition, value, timeout = 20_000) {
    return this.page.waitForFunction(condition, value, { timeout, polling: 20 });
  }

  async isDrawn(roles = ["model", "sim", "render"]) {
    const isDrawn = (roles) =>
      window.preview?.store.state.drawn > 0 && roles.every((role) => preview.view.stats(role) !== null);
    await this.when(isDrawn, roles, 40_000);
    await this.quiet();
  }

  /** Waits until the server has nothing more to say. */
  quiet() {
    const isQuiet = (quiet) =>
      Object.keys(preview.store.state.progress).length === 0 && performance.now() - observed.last > quiet;
    return this.when(isQuiet, QUIET, 40_000);
  }

  /** The part of the store's state that `pick` returns. */
  state(pick) {
    return this.page.evaluate(`(${pick})(preview.store.state)`);
  }

  document() {
    return this.state((state) => state.document);
  }

  /** Points, faces and checksum of all meshes. */
  meshes() {
    return this.page.evaluate(() =>
      Object.fromEntries(["model", "sim", "render"].map((role) => [role, preview.view.stats(role)])),
    );
  }

  /** Meshes after an action has changed `role` and all is built. */
  async after(role, act) {
    const before = await this.meshes();
    await act();
    await this.differs(role, before);
    await this.quiet();
    return this.meshes();
  }

  /** Waits until a mesh is another than it was. */
  differs(role, before, timeout) {
    const differs = ([role, before]) => {
      const now = preview.view.stats(role);
      return now && (now.checksum !== before.checksum || now.faces !== before.faces);
    };
    return this.when(differs, [role, before[role]], timeout);
  }

  /** Sets an option as a step of its own, without the controls. */
  set(key, value) {
    return this.page.evaluate(([key, value]) => preview.store.set(key, value), [key, value]);
  }

  /** Shows other settings of the view. */
  settings(changed) {
    return this.page.evaluate((changed) => preview.store.settings(changed), changed);
  }

  row(key) {
    return this.page.locator(`[data-key="${key}"]`);
  }

  slider(key) {
    return this.row(key).locator('input[type="range"]');
  }

  field(key) {
    return this.row(key).getByRole("spinbutton");
  }

  card(full) {
    return this.page.locator(`[data-card="${full}"]`);
  }

  /** Names of the cards from first to last. */
  cards() {
    return this.page.locator("[data-card]").evaluateAll((cards) => cards.map((card) => card.dataset.card));
  }

  async openCard(full) {
    await this.card(full).locator(".card-title").click();
    await this.card(full).locator(".card-body").waitFor();
  }

  /** Picks an item of the menu of a card. */
  async pickOf(full, item) {
    await this.card(full)
      .getByRole("button", { name: /^More of/ })
      .click();
    await this.page.getByRole("menuitem", { name: item }).click();
  }

  /** Drags a slider from its place by a share of its width, in steps. */
  async drag(key, share, steps = 8) {
    const slider = this.slider(key);
    await slider.scrollIntoViewIfNeeded();
    const box = await slider.boundingBox();
    const at = await slider.evaluate(({ value, min, max }) => (value - min) / (max - min));
    const y = box.y + box.height / 2;
    const x = (part) => box.x + 7 + (box.width - 14) * part;
    await this.page.mouse.move(x(at), y);
    await this.page.mouse.down();
    for (let i = 1; i <= steps; i++) {
      await this.page.mouse.move(x(at + (share * i) / steps), y);
      await sleep(20);
    }
    await this.page.mouse.up();
  }

  /** The canvas as it is drawn, as a decoded PNG. */
  async picture() {
    await this.isStill();
    const data = await this.page.evaluate(async () => {
      const bytes = new Uint8Array(await (await preview.view.screenshot()).arrayBuffer());
      return bytes.reduce((text, byte) => text + String.fromCharCode(byte), "");
    });
    return decode(Buffer.from(data, "latin1"));
  }

  /** Waits for the end of flights of the camera: a point stays where it is. */
  isStill() {
    return this.page.evaluate(async () => {
      const ways = ["model", "sim", "render"].flatMap((role) => [true, false].map((flat) => [role, flat]));
      const places = (point) => ways.map(([role, flat]) => preview.view.project(role, point, flat));
      const place = () => JSON.stringify([0, 1, 2, 3].map(places));
      const frame = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve, 30)));
      for (let same = 0, last = place(), i = 0; same < 4 && i < 200; i++) {
        await frame();
        same = place() === last ? same + 1 : 0;
        last = place();
      }
    });
  }

  /** The points of a mesh as the socket brought them, and whether those that are drawn add up to the same. */
  async points(role) {
    const { text, sum } = await this.page.evaluate((role) => {
      const points = observed.points[role];
      let sum = 0;
      for (let i = 0; i < points.length; i += 3) sum += points[i] + points[i + 1] + points[i + 2];
      const bytes = new Uint8Array(points.buffer);
      let text = "";
      for (const byte of bytes) text += String.fromCharCode(byte);
      return { text, sum };
    }, role);
    const drawn = (await this.meshes())[role];
    if (drawn.checksum !== sum) throw new Error(`the drawn ${role} is not the last one that was sent`);
    const bytes = Buffer.from(text, "latin1");
    return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  }
}
