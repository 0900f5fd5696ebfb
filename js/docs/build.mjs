// Builds the documentation into a folder: node build.mjs FOLDER TOOLS [--base /docs/]
// TOOLS: the folder of the native tools, build/default/tools, which describe their options. PYTHON: a Python 3.9 or later
// (default python3); doxygen has to be in PATH.

import { mkdirSync, renameSync, rmSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

import { makeReferences } from "./references/references.mjs";
import { root } from "./sources.mjs";
import { copyPages } from "./copy_pages.mjs";

const here = dirname(fileURLToPath(import.meta.url));

/** base: address of the folder on its host. tools: see above. */
export async function buildDocs(out, tools, base = "/docs/") {
  const work = join(root, "build/docs-pages");
  const pages = join(work, "pages");
  rmSync(pages, { recursive: true, force: true });
  mkdirSync(pages, { recursive: true });
  const references = await makeReferences(pages, tools, work);
  copyPages(pages, new Set(references.flatMap(({ files }) => files)));
  process.env.FVV_DOCS = JSON.stringify({ pages, references, base });
  const { build } = await import("vitepress");
  const made = join(work, "made");
  rmSync(made, { recursive: true, force: true });
  await build(here, { outDir: made });
  rmSync(out, { recursive: true, force: true });
  mkdirSync(dirname(out), { recursive: true });
  renameSync(made, out);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { values, positionals } = parseArgs({ allowPositionals: true, options: { base: { type: "string" } } });
  if (positionals.length !== 2) {
    console.error("usage: node build.mjs FOLDER TOOLS [--base /docs/]");
    process.exit(2);
  }
  await buildDocs(resolve(positionals[0]), resolve(positionals[1]), values.base);
}
