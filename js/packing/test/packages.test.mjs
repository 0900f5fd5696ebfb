// The packages as npm would publish them: packed, checked, and used by pages in TypeScript and React that Vite builds, and
// by a page that takes the player's single file from another host.

import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";

import { build } from "vite";

import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { root, serveFolder, tool } from "../../testing/served.mjs";
import { NAMES, isBuilt, pack, packIn, problemsOf } from "../packages.mjs";
import { coloursOf, install } from "./projects.mjs";

const here = fileURLToPath(new URL(".", import.meta.url));
const js = join(here, "../..");
const manifestOf = (name) => JSON.parse(readFileSync(join(js, name, "package.json"), "utf8"));
const names = NAMES.filter(isBuilt);

let folder;
const tarballs = {};
before(() => {
  folder = mkdtempSync(join(tmpdir(), "fvv-packages-"));
  mkdirSync(join(folder, "packed"));
  for (const name of names) tarballs[name] = pack(name, join(folder, "packed"));
});
after(() => rmSync(folder, { recursive: true, force: true }));

test("manifests agree, and each package has its licence", () => {
  const licence = readFileSync(join(root, "LICENSE"), "utf8");
  const { version } = manifestOf("decoder");
  for (const name of NAMES) {
    const manifest = manifestOf(name);
    assert.equal(manifest.version, version, name);
    for (const [other, wanted] of Object.entries(manifest.dependencies ?? {}))
      if (other.startsWith("@fvv/")) assert.equal(wanted, version, `${name} needs ${other}`);
    for (const field of ["homepage", "repository", "bugs", "engines", "keywords", "files", "description"])
      assert.ok(manifest[field], `${name}: ${field}`);
    assert.equal(manifest.repository.directory, `js/${name}`);
    if (manifest.license === "Apache-2.0") assert.equal(readFileSync(join(js, name, "LICENSE"), "utf8"), licence, name);
    else assert.match(readFileSync(join(js, name, "LICENSE"), "utf8"), /GNU LESSER GENERAL PUBLIC LICENSE/);
  }
});

test("what contains Draco, meshoptimizer or musl has their notices", () => {
  const fileOf = (name, path) =>
    execFileSync("tar", ["-xzOf", tarballs[name], `package/dist/${path}`], { encoding: "utf8", maxBuffer: 2 ** 26 });
  const mit = readFileSync(join(js, "decoder/dist/LICENSE.meshoptimizer"), "utf8").trim();
  assert.match(mit, /^MIT License[^]*Copyright \(c\)[^]*The above copyright notice and this permission notice/);
  const draco = /\/\*![^*]*Draco[^*]*Copyright[^*]*The Draco Authors[^*]*Apache License, Version 2.0/;
  const musl =
    /\/\*![^*]*musl[^*]*Copyright © 2005[^*]*Rich Felker[^*]*The above copyright notice and this permission notice/;
  for (const [name, path, contains] of [
    ["decoder", "draco.wasm.js", ["draco"]],
    ["decoder", "fast.wasm.js", ["meshoptimizer"]],
    ["decoder", "fast_simd.wasm.js", ["meshoptimizer"]],
    ["decoder", "core.wasm.js", ["musl"]],
    ["player", "fvv-player.min.js", ["draco", "meshoptimizer", "musl"]],
  ]) {
    const text = fileOf(name, path);
    assert.equal(draco.test(text), contains.includes("draco"), `${name}: ${path}: Draco`);
    assert.equal(musl.test(text), contains.includes("musl"), `${name}: ${path}: musl`);
    assert.equal(text.includes(mit), contains.includes("meshoptimizer"), `${name}: ${path}: meshoptimizer`);
  }
  for (const library of ["draco", "meshoptimizer", "musl"])
    assert.ok(fileOf("decoder", `LICENSE.${library}`).length > 1000);
});

test("the lock file names no host, and has what the manifests ask for", () => {
  const { packages } = JSON.parse(readFileSync(join(js, "package-lock.json"), "utf8"));
  for (const [path, { resolved, link, integrity }] of Object.entries(packages)) {
    if (!path.includes("node_modules/")) continue;
    assert.ok(link ? NAMES.includes(resolved) : !resolved, `${path}: ${resolved}`);
    assert.ok(link || integrity, `${path} has no digest`);
  }
  const { devDependencies } = JSON.parse(readFileSync(join(js, "package.json"), "utf8"));
  for (const [name, wanted] of Object.entries(devDependencies))
    assert.equal(packages[`node_modules/${name}`].version, wanted, `${name}: run npm install in js`);
});

test("publint and attw find nothing", async () => {
  for (const name of names) assert.deepEqual(await problemsOf(name, tarballs[name]), []);
});

test("they would find a missing type", async () => {
  const copy = join(folder, "broken");
  execFileSync("tar", ["-xzf", tarballs.player, "-C", folder]);
  cpSync(join(folder, "package"), copy, { recursive: true });
  rmSync(join(copy, "src/view.d.ts"));
  const manifest = JSON.parse(readFileSync(join(copy, "package.json"), "utf8"));
  delete manifest.scripts;
  writeFileSync(join(copy, "package.json"), JSON.stringify(manifest));
  const found = await problemsOf("broken", packIn(copy, folder));
  assert.ok(
    found.some((line) => line.includes("publint")) && found.some((line) => line.includes("attw")),
    found.join("\n"),
  );
});

test("a package that is not built is not packed", () => {
  cpSync(join(js, "packing/check_built.mjs"), join(folder, "packing/check_built.mjs"));
  const copy = join(folder, "decoder");
  mkdirSync(copy);
  for (const name of ["package.json", "LICENSE", "README.md"]) cpSync(join(js, "decoder", name), join(copy, name));
  assert.throws(
    () => packIn(copy, folder),
    /@fvv\/decoder cannot be packed: \.\/dist\/index\.d\.ts is missing; build it with js\/decoder/,
  );
});

test("placeholders are not published", () => {
  const env = { ...process.env, npm_command: "publish" };
  const { status, stderr } = spawnSync("node", ["../packing/check_built.mjs"], {
    cwd: join(js, "shading"),
    env,
    encoding: "utf8",
  });
  const isPlaceholder = manifestOf("shading").homepage.includes(".example/");
  assert.equal(status, isPlaceholder ? 1 : 0);
  if (isPlaceholder) assert.match(stderr, /placeholders/);
});

function checkTypes(project, file) {
  const options = [
    "--noEmit",
    "--strict",
    "--target",
    "es2022",
    "--lib",
    "es2023,dom,dom.iterable",
    "--jsx",
    "react-jsx",
  ];
  const resolved = ["--module", "esnext", "--moduleResolution", "bundler", "--types", "vite/client"];
  const { status, stdout } = spawnSync(join(js, "node_modules/.bin/tsc"), [...options, ...resolved, file], {
    cwd: project,
    encoding: "utf8",
  });
  assert.equal(status, 0, stdout);
}

/** Another host: every file with CORS, and nothing else. */
async function serveElsewhere(files) {
  const server = createServer((request, response) => {
    const path = files[request.url.slice(1)];
    if (!path) return response.writeHead(404).end();
    response.writeHead(200, { "Access-Control-Allow-Origin": "*", "Content-Type": "text/javascript" });
    response.end(readFileSync(path));
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  return { url: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

describe("pages", { skip: missingBrowser("chromium") }, () => {
  let served, browser;
  before(async () => {
    served = await serveFolder();
    const at = (name) => join(served.folder, name);
    tool("fvvsynth", "-o", at("capture"), "--rig", "small", "--frames", "4", "--size", "320x180");
    tool("fvvmux", at("capture"), "-o", at("clip.fvv"), "--max-error", "0.5");
    browser = await openBrowser();
  });
  after(async () => {
    await browser?.close();
    served?.close();
  });

  async function buildAndOpen(page, file) {
    const project = install(join(here, page), join(folder, page), tarballs);
    checkTypes(project, file);
    const out = join(served.folder, page);
    const jsx = { jsx: "automatic" };
    await build({
      root: project,
      configFile: false,
      logLevel: "error",
      base: "./",
      esbuild: jsx,
      worker: { format: "es" },
      build: { outDir: out, emptyOutDir: true, target: "es2022" },
    });
    cpSync(join(served.folder, "clip.fvv"), join(out, "clip.fvv"));
    return browser.newPage(`${served.url}${page}/`);
  }

  test("TypeScript, built by Vite", async () => {
    const page = await buildAndOpen("page", "main.ts");
    assert.ok((await coloursOf(page)) > 300);
    await page.waitForSelector("[data-decoded][data-frame]");
    const { decoded, worker } = await page.evaluate(() => ({ ...document.body.dataset }));
    assert.ok(Number(decoded) > 100);
    assert.equal(worker, "true");
    await page.evaluate(() => document.querySelector("fvv-player").setPose({ fov: 30 }));
    await page.waitForSelector('[data-moved="script"]');
    await page.close();
    assert.deepEqual(browser.troubles.splice(0), []);
  });

  test("React, built by Vite", async () => {
    const page = await buildAndOpen("react", "main.tsx");
    assert.ok((await coloursOf(page)) > 300);
    await page.click("button");
    await page.waitForFunction(() => /^[123] script 1 false$/.test(document.querySelector("output").textContent));
    await page.close();
    assert.deepEqual(browser.troubles.splice(0), []);
  });

  const single = join(js, "player/dist/fvv-player.min.js");
  for (const [where, host] of [
    ["of the page's host", null],
    ["of another host", "elsewhere"],
  ])
    test(`a single file ${where}`, async () => {
      const elsewhere = await serveElsewhere({ "fvv-player.min.js": single });
      const own = createServer((request, response) => {
        const name = request.url.slice(1);
        const types = { "": "text/html", "fvv-player.min.js": "text/javascript", "clip.fvv": "model/vnd.fvv" };
        const source = host ? `${elsewhere.url}fvv-player.min.js` : "fvv-player.min.js";
        if (!(name in types)) return response.writeHead(404).end();
        response.writeHead(200, { "Content-Type": types[name] });
        if (name === "clip.fvv") response.end(readFileSync(join(served.folder, "clip.fvv")));
        else if (name) response.end(readFileSync(single));
        else
          response.end(`<!doctype html><title>One file</title><link rel="icon" href="data:," />
            <script type="module" src="${source}"></script><fvv-player src="clip.fvv" controls></fvv-player>`);
      });
      await new Promise((listening) => own.listen(0, "127.0.0.1", listening));
      try {
        const page = await browser.newPage(`http://127.0.0.1:${own.address().port}/`);
        assert.ok((await coloursOf(page)) > 300);
        assert.equal(page.workers().length, 1, "the decoder is in a worker");
        assert.ok(await page.evaluate(() => document.querySelector("fvv-player").stats.framesShown > 0));
        await page.close();
      } finally {
        own.close();
        elsewhere.close();
      }
      assert.deepEqual(browser.troubles.splice(0), []);
    });
});

test("packed packages hold no tests, and no sources of builds", () => {
  for (const name of names) {
    const list = execFileSync("tar", ["-tzf", tarballs[name]], { encoding: "utf8" }).split("\n");
    assert.deepEqual(
      list.filter((path) => /package\/test\/|node_modules|\.test\./.test(path)),
      [],
      name,
    );
    assert.ok(list.includes("package/LICENSE"), name);
  }
  assert.ok(existsSync(join(js, "player/dist/fvv-player.min.js")));
  assert.ok(readdirSync(join(folder, "packed")).length >= 4);
});
