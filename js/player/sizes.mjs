// Bytes of the scripts that pages load: node sizes.mjs prints those of the attribute `tools`, after js/decoder/wasm/build.sh.

import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync } from "node:zlib";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));

/** All scripts that an output needs at once. */
function neededBy(name, outputs, found = new Set()) {
  if (found.has(name)) return found;
  found.add(name);
  for (const { path, kind } of outputs[name].imports)
    if (kind === "import-statement" && path in outputs) neededBy(path, outputs, found);
  return found;
}

/** What a page loads for the attribute `tools` and not without: {scripts, brotli}, bytes. */
export async function toolsBytes() {
  const { outputFiles, metafile } = await build({
    entryPoints: [join(here, "src/index.js")],
    bundle: true,
    splitting: true,
    format: "esm",
    minify: true,
    target: "es2022",
    write: false,
    metafile: true,
    outdir: join(here, "sizes"),
    absWorkingDir: here,
    logLevel: "warning",
  });
  const { outputs } = metafile;
  const nameOf = (source) => Object.keys(outputs).find((name) => outputs[name].entryPoint === source);
  const always = neededBy(nameOf("src/index.js"), outputs);
  const scripts = [...neededBy(nameOf("src/tools/index.js"), outputs)].filter((name) => !always.has(name));
  const bytes = scripts.map((name) => outputFiles.find(({ path }) => path === join(here, name)).contents);
  return { scripts, brotli: bytes.reduce((sum, contents) => sum + brotliCompressSync(contents).length, 0) };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) console.log(JSON.stringify(await toolsBytes()));
