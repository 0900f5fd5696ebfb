// Whether bundlers take the package as it is: packs it, unpacks it into a project for each of them, builds that without
// any configuration of the package, serves the result under a strict content policy, and decodes in Chromium.
// usage: node matrix.mjs [vite|webpack|esbuild|rollup|plain ...]. Needs npm, chromium, and the packages of js.

import { execFileSync, spawn, spawnSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { makeClips, nativeFrames, root } from "./native.mjs";

const page = (script) =>
  `<!doctype html><meta charset="utf-8"><title>x</title><script type="module" src="${script}"></script>`;
const main = `
import { createDecoder } from "@fvv/decoder";
const warnings = [];
let frames = 0, vertices = 0, decoder;
try {
  decoder = await createDecoder({ source: "/clip.fvv" });
  decoder.addEventListener("warning", (event) => warnings.push(event.detail.message));
  for await (const frame of decoder) { frames++; vertices += frame.mesh.vertexCount; frame.close(); }
  await fetch("/result", { method: "POST", body: JSON.stringify({ frames, vertices, inWorker: decoder.inWorker, warnings }) });
} catch (error) {
  await fetch("/result", { method: "POST", body: JSON.stringify({ error: error.stack }) });
}
`;

const bundlers = {
  vite: { build: ["vite", "build"], out: "dist", worker: true },
  webpack: {
    build: ["webpack", "--entry", "./main.js", "--mode", "production", "-o", "dist"],
    page: "main.js",
    out: "dist",
    worker: true,
  },
  esbuild: {
    build: ["esbuild", "main.js", "--bundle", "--format=esm", "--splitting", "--outdir=dist"],
    page: "main.js",
    out: "dist",
    worker: false,
  },
  rollup: {
    build: ["rollup", "main.js", "-p", "node-resolve", "-d", "dist"],
    page: "main.js",
    out: "dist",
    worker: false,
  },
  plain: { out: ".", worker: true },
};

const chromium = process.env.FVV_CHROMIUM ?? "chromium";
const policy = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'";
const types = { html: "text/html", js: "text/javascript" };

async function runPage(folder, clip) {
  let told;
  const result = new Promise((resolve, reject) => {
    told = resolve;
    setTimeout(() => reject(new Error("the page does not answer")), 60000).unref();
  });
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, "http://x");
    if (pathname === "/result") {
      const parts = [];
      request.on("data", (part) => parts.push(part));
      request.on("end", () => told(JSON.parse(Buffer.concat(parts))));
      return response.end();
    }
    try {
      const path = pathname === "/clip.fvv" ? clip : join(folder, pathname === "/" ? "index.html" : pathname);
      const bytes = readFileSync(path);
      const type = types[path.split(".").at(-1)] ?? "application/octet-stream";
      response.writeHead(200, { "Content-Type": type, "Content-Security-Policy": policy });
      response.end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const profile = mkdtempSync(join(tmpdir(), "fvv-matrix-"));
  const url = `http://127.0.0.1:${server.address().port}/`;
  const browser = spawn(
    chromium,
    ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-sync",
     "--disable-component-update", "--no-first-run", `--user-data-dir=${profile}`, url],
    { stdio: "ignore", detached: true },
  ); // prettier-ignore
  try {
    return await result;
  } finally {
    process.kill(-browser.pid);
    await new Promise((gone) => browser.once("exit", gone));
    server.closeAllConnections();
    server.close();
    rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
  }
}

function prepare(name, work, archive) {
  const { build, page: script, out } = bundlers[name];
  const project = join(work, name);
  const installed = join(project, "node_modules/@fvv/decoder");
  mkdirSync(installed, { recursive: true });
  const run = (program, ...parameters) =>
    execFileSync(program, parameters, { cwd: project, stdio: "pipe", encoding: "utf8" });
  run("tar", "-xzf", archive, "--strip-components=1", "-C", installed);
  writeFileSync(join(project, "package.json"), JSON.stringify({ type: "module", private: true }));
  writeFileSync(join(project, "main.js"), main);
  writeFileSync(join(project, "index.html"), page("./main.js"));
  if (!build) {
    // No bundler, and so no bare names: what an import map would say.
    const entry = "./node_modules/@fvv/decoder/dist/index.js";
    writeFileSync(join(project, "main.js"), main.replace('"@fvv/decoder"', `"${entry}"`));
    return project;
  }
  const [bundler, ...parameters] = build;
  run(join(root, "js/node_modules/.bin", bundler), ...parameters);
  if (script) cpSync(join(project, "index.html"), join(project, out, "index.html"));
  return join(project, out);
}

async function attempt(name, work, archive, clip) {
  try {
    return await runPage(prepare(name, work, archive), clip);
  } catch (error) {
    return { error: `${error.message}\n${error.stdout ?? ""}` };
  }
}

if (spawnSync(chromium, ["--version"]).error) {
  console.log(`skipped: no ${chromium} here`);
  process.exit(0);
}
const names = process.argv.length > 2 ? process.argv.slice(2) : Object.keys(bundlers);
const { clips, done } = makeClips("draco");
const work = mkdtempSync(join(tmpdir(), "fvv-matrix-"));
let failed = 0;
try {
  execFileSync("npm", ["pack", "--pack-destination", work], { cwd: join(root, "js/decoder"), stdio: "pipe" });
  const archive = join(
    work,
    readdirSync(work).find((name) => name.endsWith(".tgz")),
  );
  const expected = nativeFrames(clips.draco).length;
  for (const name of names) {
    const result = await attempt(name, work, archive, clips.draco);
    const good = result.frames === expected && result.inWorker === bundlers[name].worker;
    if (!good) failed++;
    console.log(`${name}: ${good ? "good" : "FAILED"} ${JSON.stringify(result)}`);
  }
} finally {
  done();
  rmSync(work, { recursive: true, force: true });
}
process.exit(failed ? 1 : 0);
