// The samples of the READMEs, as they are printed, in Chromium: they draw something.

import assert from "node:assert/strict";
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";

import { PNG } from "pngjs";

import { bundlePlayer } from "../../player/bundle.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { bundle } from "../../three/bundle.mjs";

const js = fileURLToPath(new URL("../..", import.meta.url));

/** The first listing in a language. */
function listing(readme, language) {
  const text = readFileSync(join(js, readme), "utf8");
  return new RegExp(`\`\`\`${language}\\n([^]*?)\`\`\``).exec(text)[1];
}

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
