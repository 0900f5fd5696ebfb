// Bundles a page with the decoder, its worker and three into a folder that any web server can serve.
// usage: node bundle.mjs FOLDER (the example)

import { copyFileSync, mkdirSync } from "node:fs";
import { basename, dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const decoder = join(here, "../decoder/dist");

/** scripts: one or several scripts of pages; files: copied as they are. The worker is a separate script that shares chunks. */
export async function bundle(scripts, files, out) {
  const pages = [scripts].flat().map((script) => [basename(script).replace(/\.jsx?$/, ""), script]);
  mkdirSync(out, { recursive: true });
  await build({
    entryPoints: { ...Object.fromEntries(pages), worker: join(decoder, "worker.js") },
    bundle: true,
    format: "esm",
    splitting: true,
    minify: true,
    target: "es2022",
    jsx: "automatic",
    // For scripts in other folders, such as bench.
    nodePaths: [join(here, "../node_modules")],
    outdir: out,
    logLevel: "warning",
  });
  for (const file of files) copyFileSync(file, join(out, basename(file)));
}

export async function bundleExample(out) {
  const example = (name) => join(here, "example", name);
  await bundle(example("page.js"), [example("index.html"), example("page.css")], out);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  if (process.argv.length !== 3) {
    console.error("usage: node bundle.mjs FOLDER");
    process.exit(2);
  }
  await bundleExample(resolve(process.argv[2]));
}
