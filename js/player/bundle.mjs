// The player and its decoder as one compressed script: a page imports it as a module, and it is its own worker. The Python
// package embeds it. usage: node bundle.mjs OUT.js.gz, after js/decoder/wasm/build.sh

import { writeFileSync } from "node:fs";
import { dirname, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));

/** Writes the script to a path. Other modules are not fetched, so that it also works inside a page. */
export async function bundlePlayer(out) {
  const { outputFiles } = await build({
    stdin: {
      contents: `
        if (typeof document === "undefined") await import("../decoder/dist/worker.js");
        else await import("./src/index.js");
      `,
      resolveDir: here,
    },
    bundle: true,
    format: "esm",
    minify: true,
    target: "es2022",
    write: false,
    logLevel: "warning",
  });
  const packed = gzipSync(outputFiles[0].contents, { level: 9 });
  packed[9] = 255; // no operating system: the same bytes on every machine
  writeFileSync(out, packed);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  if (process.argv.length !== 3) {
    console.error("usage: node bundle.mjs OUT.js.gz");
    process.exit(2);
  }
  await bundlePlayer(resolve(process.argv[2]));
}
