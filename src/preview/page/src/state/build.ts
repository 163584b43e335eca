// The command that builds what is saved.

import type { Store } from "./store";

/** The output that is proposed for an input: beside it, under the name that a folder of outputs has. */
export function outputOf(input: string): string {
  return `${input.replace(/\.[^./\\]*$/, "")}_tailored.usdc`;
}

export function buildCommand(input: string, output: string): string {
  return `usdtailor build ${quoted(input)} -o ${quoted(output)}`;
}

/** Opens the dialog of the build, or first that of saving. */
export function openBuild(store: Store): void {
  const isSaved = store.state.document.savedAs !== null;
  store.update({ dialog: isSaved ? "build" : "save", save: null, buildsNext: !isSaved });
}

function quoted(path: string): string {
  return /^[\w@%+=:,./-]+$/.test(path) ? path : `'${path.replaceAll("'", `'\\''`)}'`;
}
