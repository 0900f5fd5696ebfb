// Bundles the example into a folder that any web server can serve: node build.mjs [FOLDER]. The decoder's worker is a
// script of its own, and shares what it has in common with the page.

import { copyFileSync, mkdirSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = resolve(process.argv[2] ?? join(here, "../dist"));
const decoder = join(here, "../../decoder/dist");
mkdirSync(out, { recursive: true });
await build({
  entryPoints: { page: join(here, "page.js"), worker: join(decoder, "worker.js") },
  bundle: true,
  format: "esm",
  splitting: true,
  minify: true,
  target: "es2022",
  outdir: out,
  alias: { "@fvv/decoder": join(decoder, "index.js"), "@fvv/three": join(here, "../src/index.js") },
  logLevel: "warning",
});
for (const name of ["index.html", "page.css"]) copyFileSync(join(here, name), join(out, name));
