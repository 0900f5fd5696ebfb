// The player and its decoder as one script (src/single_file.js). The npm package contains it; the Python package embeds it,
// compressed. usage: node bundle.mjs OUT.js | OUT.js.gz, after js/decoder/wasm/build.sh

import { mkdirSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));

/** Writes the script to a path, compressed if its name ends in .gz. It fetches no other modules. */
export async function bundlePlayer(out) {
  const { outputFiles } = await build({
    entryPoints: [join(here, "src/single_file.js")],
    bundle: true,
    format: "esm",
    minify: true,
    target: "es2022",
    write: false,
    logLevel: "warning",
  });
  const [{ contents }] = outputFiles;
  mkdirSync(dirname(out), { recursive: true });
  if (!out.endsWith(".gz")) return writeFileSync(out, contents);
  const packed = gzipSync(contents, { level: 9 });
  packed[9] = 255; // no operating system: the same bytes on every machine
  writeFileSync(out, packed);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  if (process.argv.length !== 3) {
    console.error("usage: node bundle.mjs OUT.js | OUT.js.gz");
    process.exit(2);
  }
  await bundlePlayer(resolve(process.argv[2]));
}
