// Garments that tests write or build.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { copyOf, run, temporaryFolder } from "./server.mjs";

const AUTHORED = `
        rel tailor:seam:shoulder:edges = </Tshirt/model/shoulder_seams>
        uniform float tailor:seam:shoulder:normalOffset = -0.3
        rel tailor:seam:side:edges = </Tshirt/model/side_seams>
        uniform float tailor:seam:side:normalOffset = -0.3
        rel tailor:fold:neck:faces = </Tshirt/model/neckband>
        uniform float tailor:fold:neck:thickness = 0.4`;

/** A T-shirt with two seams and a fold of its own. */
export function sewnShirt(test) {
  const path = copyOf(test, "tshirt.usda");
  // With one level, a build takes less time.
  substitute(path, "uniform int tailor:render:level = 2", (line) => line.replace("2", "1") + AUTHORED);
  return path;
}

/** A T-shirt as most programs export one: without sets. */
export function bareShirt(test) {
  const path = copyOf(test, "tshirt.usda");
  substitute(path, /^ {8}def GeomSubset [^]*?^ {8}\}\n/gm, "");
  substitute(path, /^ *rel tailor:[^]*?\]\n/gm, "");
  substitute(path, "uniform int tailor:render:level = 2", "uniform int tailor:render:level = 1");
  return path;
}

/** Changes the text of a file, which has to hold `what`. */
export function substitute(path, what, by) {
  const text = readFileSync(path, "utf8");
  assert.notEqual(text.replace(what, by), text, `${path} holds ${what}`);
  writeFileSync(path, text.replace(what, by));
}

/** A file whose prim `/Sheet` holds `content`. */
export function sheetFile(test, content, metadata = "") {
  const path = join(temporaryFolder(test), "sheet.usda");
  writeFileSync(
    path,
    `#usda 1.0
(
    defaultPrim = "Sheet"
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Xform "Sheet" ${metadata}
{
${content}
}
`,
  );
  return path;
}

/** A flat cloth of `size` by `size` quads with an edge set; the variant `long` is another in its points. */
export function variantSheet(test, size = 6) {
  const range = [...Array(size + 1).keys()];
  const grid = (stretch) => range.flatMap((i) => range.map((j) => `(${j}, ${i * stretch}, ${Math.sin(i)})`)).join(", ");
  const at = (i, j) => i * (size + 1) + j;
  const cells = range.slice(1).flatMap((i) => range.slice(1).map((j) => [i - 1, j - 1]));
  const corners = cells.map(([i, j]) => [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)].join(", "));
  const middle = range.slice(1).map((j) => `${at(size / 2, j - 1)}, ${at(size / 2, j)}`);
  const points = (stretch) => `point3f[] points = [${grid(stretch)}]`;
  return sheetFile(
    test,
    `    def Mesh "model"
    {
        int[] faceVertexCounts = [${cells.map(() => 4).join(", ")}]
        int[] faceVertexIndices = [${corners.join(", ")}]
        def GeomSubset "fold"
        {
            uniform token elementType = "edge"
            int[] indices = [${middle.join(", ")}]
        }
    }
    variantSet "cut" = {
        "short" { over "model" { ${points(1)} } }
        "long" { over "model" { ${points(2)} } }
    }`,
    `(
    variants = { string cut = "short" }
    prepend variantSets = "cut"
)`,
  );
}

/** The points of both products as `usdtailor build` writes them, and their text. */
export async function build(test, input, ...args) {
  const path = join(temporaryFolder(test), "built.usda");
  const { code, stdout } = await run("build", input, "-o", path, "--flatten", ...args);
  assert.equal(code, 0, stdout);
  const text = readFileSync(path, "utf8");
  // The garment holds the recipe or not; what comes after it are the products and what they share.
  const products = text.slice(text.indexOf('def Mesh "sim"'));
  return { products, sim: pointsOf(text, "sim"), render: pointsOf(text, "render") };
}

function pointsOf(text, prim) {
  const start = text.indexOf(`def Mesh "${prim}"`);
  assert.ok(start >= 0, `the file has the mesh ${prim}`);
  const line = /point3f\[\] points = \[(.*)\]/.exec(text.slice(start))[1];
  return Float32Array.from(line.matchAll(/[-+.\de]+/g), ([number]) => Number(number));
}

/** The same numbers to the last bit. */
export function assertSame(actual, expected, words) {
  const bytes = (numbers) => Buffer.from(numbers.buffer, numbers.byteOffset, numbers.byteLength);
  assert.equal(actual.length, expected.length, words);
  assert.ok(bytes(actual).equals(bytes(expected)), words);
}
