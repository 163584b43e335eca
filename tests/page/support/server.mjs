// Starts `usdtailor preview`, and runs the other commands of the program.

import { execFile, spawn } from "node:child_process";
import { once } from "node:events";
import { cpSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { promisify } from "node:util";

/** Set by `cargo xtask test browser`. */
const PROGRAM = needed("USDTAILOR");
export const ROOT = needed("USDTAILOR_ROOT");

function needed(name) {
  const value = process.env[name];
  if (!value) throw new Error(`${name} is not set; run the tests by \`cargo xtask test browser\``);
  return value;
}

export function example(name) {
  return join(ROOT, "examples", name);
}

/** A suit of several layers, the largest garment of the project. */
export const SUIT = join(ROOT, "tests/garments/layered_suit.usdc");

/** A folder that is removed after the test. */
export function temporaryFolder(test) {
  const folder = mkdtempSync(join(tmpdir(), "usdtailor-page-"));
  // A server that has not stopped yet may write a last file into it.
  test.after(() => rmSync(folder, { recursive: true, force: true, maxRetries: 20, retryDelay: 50 }));
  return folder;
}

/** A copy of an example that the test may change. */
export function copyOf(test, name) {
  const path = join(temporaryFolder(test), basename(name));
  cpSync(example(name), path);
  return path;
}

/** Runs the program to its end; `code` 0 is a success. */
export async function run(...args) {
  try {
    const { stdout } = await promisify(execFile)(PROGRAM, args, { maxBuffer: 1 << 28 });
    return { code: 0, stdout };
  } catch ({ code, stdout, stderr }) {
    return { code, stdout: `${stdout}${stderr}` };
  }
}

export class Server {
  /** Serves until the test ends. `owner` is the test, or anything with `after`. */
  static async start(owner, garment, ...args) {
    return Server.#started(owner, new Server(garment, args, temporaryFolder(owner)));
  }

  static async #started(owner, server) {
    owner.after(() => server.stop());
    await server.#ready();
    return server;
  }

  /** `state` is the folder for what outlives the program. */
  constructor(garment, args, state) {
    Object.assign(this, { garment, args, state });
    this.process = spawn(PROGRAM, ["preview", garment, "--no-open", ...args], {
      stdio: ["ignore", "pipe", "pipe"],
      env: { ...process.env, XDG_STATE_HOME: state },
    });
    this.errors = "";
    this.process.stderr.on("data", (data) => (this.errors += data));
  }

  async #ready() {
    let text = "";
    for await (const data of this.process.stdout.iterator({ destroyOnReturn: false })) {
      text += data;
      const address = /(http:\S+)\n/.exec(text)?.[1];
      if (!address) continue;
      this.address = address;
      this.process.stdout.resume();
      return;
    }
    throw new Error(`the preview did not start: ${this.errors}`);
  }

  get port() {
    return Number(new URL(this.address).port);
  }

  get secret() {
    return new URL(this.address).pathname.split("/")[1];
  }

  /** Another server of the same user for the same garment. */
  async again(owner) {
    return Server.#started(owner, new Server(this.garment, this.args, this.state));
  }

  get isRunning() {
    return this.process.exitCode === null && this.process.signalCode === null;
  }

  async stop() {
    if (!this.isRunning) return;
    const ended = once(this.process, "exit");
    this.process.kill("SIGKILL");
    await ended;
  }
}
