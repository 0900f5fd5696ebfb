// The packages as npm publishes them, and what publint and attw find in them. usage: node packages.mjs, prints as JSON the
// number of findings and the size of the player's single file.

import { execFileSync, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync } from "node:zlib";

import { checkPackage, createPackageFromTarballData } from "@arethetypeswrong/core";
import { publint } from "publint";
import { formatMessage } from "publint/utils";

const js = fileURLToPath(new URL("..", import.meta.url));
export const NAMES = JSON.parse(readFileSync(join(js, "package.json"), "utf8")).workspaces;
/** The packages are modules only: require() of old versions of Node, and resolution without "exports", do not apply. */
const RESOLUTIONS = ["node16-esm", "bundler"];

/** Whether the package's modules were compiled; only js/video-fallback is optional. */
export const isBuilt = (name) => name !== "video-fallback" || existsSync(join(js, name, "dist/index.js"));

/** Packs the package in a folder; throws Error with what npm prints. Returns the path of the tarball. */
export function packIn(folder, out) {
  const { status, stdout, stderr } = spawnSync("npm", ["pack", "--json", "--pack-destination", out], {
    cwd: folder,
    encoding: "utf8",
  });
  if (status !== 0) throw new Error(stderr);
  // Scripts of the package print before the JSON.
  const [{ filename }] = JSON.parse(stdout.slice(stdout.indexOf("[\n")));
  return join(out, filename.replace("@", "").replace("/", "-"));
}
export const pack = (name, out) => packIn(join(js, name), out);

/** What publint and attw find in a tarball, a line each. */
export async function problemsOf(name, tarball) {
  const data = new Uint8Array(readFileSync(tarball));
  const { messages, pkg } = await publint({ pack: { tarball: data.buffer }, strict: true });
  const { problems } = await checkPackage(createPackageFromTarballData(data), {
    excludeEntrypoints: [/\.wasm$/], // has no types
  });
  return [
    ...messages.map((message) => `${name}: publint: ${formatMessage(message, pkg)}`),
    ...(problems ?? [])
      .filter(({ resolutionKind }) => !resolutionKind || RESOLUTIONS.includes(resolutionKind))
      .map((problem) => `${name}: attw: ${JSON.stringify(problem)}`),
  ];
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const out = mkdtempSync(join(tmpdir(), "fvv-pack-"));
  try {
    const problems = [];
    for (const name of NAMES.filter(isBuilt)) problems.push(...(await problemsOf(name, pack(name, out))));
    for (const line of problems) console.error(line);
    const files = ["-xzOf", pack("player", out), "package/dist/fvv-player.min.js"];
    const single = execFileSync("tar", files, { maxBuffer: 2 ** 26 });
    console.log(JSON.stringify({ problems: problems.length, oneFileBytes: brotliCompressSync(single).length }));
  } finally {
    rmSync(out, { recursive: true });
  }
}
