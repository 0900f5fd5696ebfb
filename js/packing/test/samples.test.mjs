// The samples of the READMEs, as they are printed: their types are right, and in Chromium they draw something.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";

import { PNG } from "pngjs";

import { bundlePlayer } from "../../player/bundle.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { bundle } from "../../three/bundle.mjs";
import { NAMES } from "../packages.mjs";

const js = fileURLToPath(new URL("../..", import.meta.url));

/** The first listing in a language. */
function listing(readme, language) {
  const text = readFileSync(join(js, readme), "utf8");
  return new RegExp(`\`\`\`${language}\\n([^]*?)\`\`\``).exec(text)[1];
}

const PACKAGES = ["analysis", "decoder", "player", "three", "video-fallback"];

/** A listing as a module: what parts of a page use without declaring it is declared. */
function moduleOf(name, code) {
  const isLine = /^\w+: /.test(code); // of an object
  const whole = isLine ? `export const options = {\n${code.trim().replace(/;$/, "")}\n};` : code;
  if (name === "player" || name === "three") return `${whole}\nexport {};\n`;
  const declared = ["declare const source: string;", "declare function draw(...parts: unknown[]): void;"];
  if (!/^import .* from "@fvv\/decoder";$/m.test(code)) declared.push('import { createDecoder } from "@fvv/decoder";');
  if (!/const decoder\b/.test(code)) declared.push('declare const decoder: import("@fvv/decoder").Decoder;');
  return `${declared.join("\n")}\n${whole}\nexport {};\n`;
}

test("samples of the READMEs have the types of the packages", () => {
  const folder = mkdtempSync(join(tmpdir(), "fvv-types-"));
  try {
    mkdirSync(join(folder, "node_modules/@fvv"), { recursive: true });
    const link = (name, target) => symlinkSync(join(js, target), join(folder, "node_modules", name));
    for (const name of NAMES) link(`@fvv/${name}`, name);
    for (const name of ["react", "react-dom", "three", "@react-three", "@types", "opus-decoder"])
      link(name, `node_modules/${name}`);
    const files = PACKAGES.flatMap((name) => {
      const text = readFileSync(join(js, name, "README.md"), "utf8");
      return [...text.matchAll(/```(?:js|ts|tsx|jsx)\n([^]*?)```/g)].map(([, code], i) => {
        writeFileSync(join(folder, `${name}-${i}.tsx`), moduleOf(name, code));
        return `${name}-${i}.tsx`;
      });
    });
    assert.ok(files.length >= 8, `${files}`);
    const options = "--noEmit --strict --target es2022 --lib es2023,dom,dom.iterable --jsx react-jsx --module esnext";
    const found = spawnSync(
      join(js, "node_modules/.bin/tsc"),
      [...options.split(" "), "--moduleResolution", "bundler", "--types", "react", "--skipLibCheck", ...files],
      { cwd: folder, encoding: "utf8" },
    );
    assert.equal(found.status, 0, found.stdout);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

describe("samples", { skip: missingBrowser("chromium") }, () => {
  let served, browser, scripts;
  before(async () => {
    served = await serveFolder();
    scripts = mkdtempSync(join(tmpdir(), "fvv-samples-"));
    const at = (name) => join(served.folder, name);
    tool("fvvsynth", "-o", at("capture"), "--rig", "small", "--frames", "4", "--size", "320x180");
    tool("fvvmux", at("capture"), "-o", at("players.fvv"), "--max-error", "0.5");
    browser = await openBrowser();
  });
  after(async () => {
    await browser?.close();
    served?.close();
    if (scripts) rmSync(scripts, { recursive: true });
  });

  /** Waits until an element of the page has many colours. */
  async function assertDrawn(page, selector) {
    const node = await page.waitForSelector(selector);
    for (let attempt = 0; attempt < 100; attempt++) {
      const { data } = PNG.sync.read(Buffer.from(await node.screenshot()));
      const colours = new Set();
      for (let i = 0; i < data.length; i += 4 * 61) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
      if (colours.size > 300) return;
      await new Promise((later) => setTimeout(later, 100));
    }
    assert.fail(`${selector} shows nothing`);
  }

  test("js/three/README.md", async () => {
    writeFileSync(join(scripts, "sample.js"), listing("three/README.md", "js"));
    await bundle(join(scripts, "sample.js"), [], join(served.folder, "three"));
    cpSync(join(served.folder, "players.fvv"), join(served.folder, "three/players.fvv"));
    writeFileSync(
      join(served.folder, "three/index.html"),
      '<!doctype html><title>three</title><link rel="icon" href="data:," /><script type="module" src="sample.js"></script>',
    );
    const page = await browser.newPage(`${served.url}three/`);
    await assertDrawn(page, "canvas");
    await page.close();
    assert.deepEqual(browser.troubles.splice(0), []);
  });

  test("js/player/README.md", async () => {
    await bundlePlayer(join(served.folder, "fvv-player.min.js"));
    writeFileSync(join(served.folder, "index.html"), listing("player/README.md", "html"));
    const page = await browser.newPage(served.url);
    await assertDrawn(page, "fvv-player");
    await page.close();
    assert.deepEqual(
      browser.troubles.splice(0).filter((text) => !/favicon|404/.test(text)),
      [],
    );
  });
});
