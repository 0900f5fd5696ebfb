// Tests the package with bundlers: packs it, unpacks it into a project for each of them, builds the project without any
// configuration for the package, serves the result under a strict content policy, and decodes in Chromium. Three more
// projects follow the README: a separately bundled worker for esbuild and Rollup, and Vite's development server.
// usage: node matrix.mjs [vite|webpack|esbuild|rollup|plain|esbuild-worker|rollup-worker|vite-dev ...]. Needs npm,
// chromium, and the packages of js.

import { execFileSync, spawn, spawnSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { stripVTControlCharacters } from "node:util";

import { root } from "../../testing/served.mjs";
import { awaitPost, browsers, visit } from "./browsers.mjs";
import { makeClips, nativeFrames } from "./native.mjs";

const page = (script) =>
  `<!doctype html><meta charset="utf-8"><title>x</title><script type="module" src="${script}"></script>`;
/** more: options of the decoder, as text; to: origin that results are posted to. */
const mainModule = ({ more = "", to = "" } = {}) => `
import { createDecoder } from "@fvv/decoder";
const warnings = [];
const post = (result) => fetch("${to}/result", { method: "POST", body: JSON.stringify(result) });
let frames = 0, vertices = 0, decoder;
try {
  decoder = await createDecoder({ source: "/clip.fvv"${more} });
  decoder.addEventListener("warning", (event) => warnings.push(event.detail.message));
  for await (const frame of decoder) { frames++; vertices += frame.mesh.vertexCount; frame.close(); }
  await post({ frames, vertices, inWorker: decoder.inWorker, warnings });
} catch (error) {
  await post({ error: error.stack });
}
`;
const ownWorker = { more: ', worker: "/fvv-worker.js"', worker: true, script: 'import "@fvv/decoder/worker";' };

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
  "esbuild-worker": {
    build: ["esbuild", "main.js", "fvv-worker.js", "--bundle", "--format=esm", "--splitting", "--outdir=dist"],
    page: "main.js",
    out: "dist",
    ...ownWorker,
  },
  "rollup-worker": {
    build: ["rollup", "main.js", "fvv-worker.js", "-p", "node-resolve", "-d", "dist"],
    page: "main.js",
    out: "dist",
    ...ownWorker,
  },
  "vite-dev": {
    serve: ["vite", "--host", "127.0.0.1", "--port", "0"],
    configuration: 'export default { optimizeDeps: { exclude: ["@fvv/decoder"] } };',
    worker: true,
  },
};

const chromium = browsers.chromium.program;
const policy = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'";
const types = { html: "text/html", js: "text/javascript" };

/** Serves a folder and a clip, and takes the result that a page posts, also a page from another origin. */
async function listen(folder, clip) {
  const { result, post } = awaitPost(60);
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, "http://x");
    if (pathname === "/result") {
      const parts = [];
      request.on("data", (part) => parts.push(part));
      request.on("end", () => post(JSON.parse(Buffer.concat(parts))));
      return response.writeHead(200, { "Access-Control-Allow-Origin": "*" }).end();
    }
    try {
      const path = pathname === "/clip.fvv" ? clip : join(folder(), pathname === "/" ? "index.html" : pathname);
      const bytes = readFileSync(path);
      const type = types[path.split(".").at(-1)] ?? "application/octet-stream";
      response.writeHead(200, { "Content-Type": type, "Content-Security-Policy": policy });
      response.end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const close = () => {
    server.closeAllConnections();
    server.close();
  };
  return { url: `http://127.0.0.1:${server.address().port}`, result, close };
}

/** The result that the page at a URL posts. */
async function resultAt(url, result) {
  const leave = visit(browsers.chromium, url);
  try {
    return await result;
  } finally {
    await leave();
  }
}

const tool = (name) => join(root, "js/node_modules/.bin", name);

/** Unpacks the package into a project and builds it; returns the folder to be served. to: see mainModule. */
function prepare(name, work, archive, to) {
  const { build, page: script, out, more, script: worker, configuration } = bundlers[name];
  const project = join(work, name);
  const installed = join(project, "node_modules/@fvv/decoder");
  mkdirSync(installed, { recursive: true });
  const write = (file, text) => writeFileSync(join(project, file), text);
  const run = (program, ...parameters) =>
    execFileSync(program, parameters, { cwd: project, stdio: "pipe", encoding: "utf8" });
  run("tar", "-xzf", archive, "--strip-components=1", "-C", installed);
  write("package.json", JSON.stringify({ type: "module", private: true }));
  write("main.js", mainModule({ more, to }));
  write("index.html", page("./main.js"));
  if (worker) write("fvv-worker.js", worker);
  if (configuration) write("vite.config.js", configuration);
  if (name === "plain") {
    // Without a bundler there are no bare names; this is what an import map does.
    const entry = "./node_modules/@fvv/decoder/dist/index.js";
    write("main.js", mainModule().replace('"@fvv/decoder"', `"${entry}"`));
  }
  if (!build) return out ? join(project, out) : project;
  const [bundler, ...parameters] = build;
  run(tool(bundler), ...parameters);
  if (script) cpSync(join(project, "index.html"), join(project, out, "index.html"));
  return join(project, out);
}

/** The bundler's own development server; the clip is copied to its public folder. */
async function runServer(name, project, clip, result) {
  mkdirSync(join(project, "public"));
  cpSync(clip, join(project, "public/clip.fvv"));
  const [program, ...parameters] = bundlers[name].serve;
  const server = spawn(tool(program), parameters, {
    cwd: project,
    stdio: ["ignore", "pipe", "inherit"],
    detached: true,
  });
  try {
    const url = await new Promise((ready, reject) => {
      let said = "";
      server.stdout.on("data", (text) => {
        said += stripVTControlCharacters(String(text));
        const [found] = said.match(/http:\/\/127\.0\.0\.1:\d+\/(?=\s)/) ?? [];
        if (found) ready(found);
      });
      server.once("exit", (code) => reject(new Error(`${program} ended: ${code}`)));
    });
    return await resultAt(url, result);
  } finally {
    process.kill(-server.pid);
  }
}

async function attempt(name, work, archive, clip) {
  let folder;
  const host = await listen(() => folder, clip);
  try {
    const ownServer = bundlers[name].serve !== undefined;
    folder = prepare(name, work, archive, ownServer ? host.url : "");
    return await (ownServer ? runServer(name, folder, clip, host.result) : resultAt(`${host.url}/`, host.result));
  } catch (error) {
    return { error: `${error.message}\n${error.stdout ?? ""}` };
  } finally {
    host.close();
  }
}

if (spawnSync(chromium, ["--version"]).error) {
  console.log(`skipped: no ${chromium} installed`);
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
