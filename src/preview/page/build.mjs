// Bundles the page into the folder that the first argument names [default: dist]. Other arguments: --watch.
import * as esbuild from "esbuild";
import { copyFile, mkdir } from "node:fs/promises";

const out = process.argv.slice(2).find((argument) => !argument.startsWith("--")) ?? "dist";
await mkdir(out, { recursive: true });
await copyFile("index.html", `${out}/index.html`);
const context = await esbuild.context({
  entryPoints: { page: "src/main.tsx" },
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  jsx: "automatic",
  jsxImportSource: "preact",
  legalComments: "eof",
  outdir: out,
});
if (process.argv.includes("--watch")) {
  await context.watch();
} else {
  await context.rebuild();
  await context.dispose();
}
