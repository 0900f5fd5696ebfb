// Vite's development server with a project of @fvv/player, configured as its README says: the page plays, and its decoder is in a worker.

import assert from "node:assert/strict";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";

import { createServer } from "vite";

import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { pack } from "../packages.mjs";
import { coloursOf, install } from "./projects.mjs";

const readme = readFileSync(fileURLToPath(new URL("../../player/README.md", import.meta.url)), "utf8");
const [, configuration] = /```js\n(\/\/ vite\.config\.js\n[^]*?)```/.exec(readme);
const PAGE = `<!doctype html><title>x</title><link rel="icon" href="data:," />
<script type="module" src="./main.js"></script><fvv-player src="clip.fvv" controls autoplay loop></fvv-player>`;

describe("Vite's development server", { skip: missingBrowser("chromium") }, () => {
  let folder, browser;
  const tarballs = {};
  before(async () => {
    folder = mkdtempSync(join(tmpdir(), "fvv-vite-"));
    for (const name of ["packed", "files/public"]) mkdirSync(join(folder, name), { recursive: true });
    for (const name of ["analysis", "decoder", "shading", "player"])
      tarballs[name] = pack(name, join(folder, "packed"));
    const write = (name, text) => writeFileSync(join(folder, "files", name), text);
    write("index.html", PAGE);
    write("main.js", 'import "@fvv/player";\n');
    const capture = join(folder, "capture");
    tool("fvvsynth", "-o", capture, "--rig", "small", "--frames", "4", "--size", "320x180");
    tool("fvvmux", capture, "-o", join(folder, "clip.fvv"), "--max-error", "0.5");
    cpSync(join(folder, "clip.fvv"), join(folder, "files/public/clip.fvv"));
    browser = await openBrowser();
  });
  after(async () => {
    await browser?.close();
    if (folder) rmSync(folder, { recursive: true, force: true });
  });

  /** What a page of the project shows. */
  async function shown(name, files) {
    const project = install(join(folder, "files"), join(folder, name), tarballs);
    for (const [file, text] of Object.entries(files)) writeFileSync(join(project, file), text);
    const server = await createServer({ root: project, logLevel: "error", server: { host: "127.0.0.1", port: 0 } });
    try {
      await server.listen();
      const { port } = server.httpServer.address();
      const page = await browser.newPage(`http://127.0.0.1:${port}/`);
      const colours = await coloursOf(page);
      await page.waitForFunction(() => document.querySelector("fvv-player").stats.framesShown > 5);
      const workers = page.workers().map((worker) => new URL(worker.url()).pathname);
      await page.close();
      return { colours, workers, troubles: browser.troubles.splice(0) };
    } finally {
      await server.close();
    }
  }

  test("as the README says", async () => {
    const { colours, workers, troubles } = await shown("configured", { "vite.config.js": configuration });
    assert.ok(colours > 300);
    assert.equal(workers.length, 1, `${workers}`);
    assert.match(workers[0], /worker\.js$/);
    assert.deepEqual(troubles, []);
  });

  test("without it the page plays too, but in its own thread", async () => {
    const { colours, workers, troubles } = await shown("bare", {});
    assert.ok(colours > 300);
    assert.equal(workers.length, 0, `${workers}: the README need not ask for a line any more`);
    assert.ok(
      troubles.every((text) => text.includes("worker")),
      troubles.join("\n"),
    );
  });
});
