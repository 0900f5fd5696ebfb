// <Fvv> of @fvv/three/react in Chromium, with WebGLRenderer and with WebGPURenderer.

import assert from "node:assert/strict";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { PNG } from "pngjs";

import { bundle } from "../bundle.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";

/** What fiber and its store do that they or this version of three warn of. */
const OF_FIBER = /THREE\.Clock|PCFSoftShadowMap|context lost|createWithEqualityFn/i;

describe("three in React", { skip: missingBrowser("chromium") }, () => {
  let served, browser;
  before(async () => {
    served = await serveFolder();
    const at = (name) => join(served.folder, name);
    tool("fvvsynth", "-o", at("small"), ..."--rig small --cameras 3 --frames 8 --size 160x120".split(" "));
    tool("fvvmux", at("small"), "-o", at("clip.fvv"), "--group", "4", "--view-loss", "none");
    const here = (name) => fileURLToPath(new URL(name, import.meta.url));
    const pages = ["react_page.html", "room_page.html"].map(here);
    await bundle([here("react_page.jsx"), here("room_page.js")], pages, at("test"));
    browser = await openBrowser();
  });
  after(async () => {
    await browser?.close();
    served?.close();
  });

  const assertNoTroubles = () =>
    assert.deepEqual(
      browser.troubles.splice(0).filter((text) => !OF_FIBER.test(text)),
      [],
    );
  const open = async () => {
    const page = await browser.newPage(`${served.url}test/react_page.html`, 480, 360);
    await page.waitForSelector("[data-ready]");
    return page;
  };
  const src = "/clip.fvv";

  for (const kind of ["webgl", "force-webgl"])
    test(`it suspends, plays, follows its properties and is disposed of: ${kind}`, async () => {
      const page = await open();
      const show = (clips) => page.evaluate((all, what) => window.show(all, what), clips, kind);
      await show([{ src, loop: true, autoPlay: true, position: [0.3, 0, 0] }]);
      await page.waitForFunction(() => window.log.frames.length > 3);
      const [waited, shown, x, paused] = await page.evaluate(() => {
        const [clip] = window.log.clips;
        return [window.log.waited, window.shown(), clip.position.x, clip.paused];
      });
      assert.ok(waited >= 1, "the fallback was not shown");
      assert.deepEqual({ shown, x, paused }, { shown: 1, x: 0.3, paused: false });
      await show([{ src, loop: true, paused: true, volume: 0.5, position: [0, 0, 0] }]);
      await page.waitForFunction(() => window.log.clips[0].paused && window.log.clips[0].volume === 0.5);
      // A second one of the same source is an instance.
      const before = await page.evaluate(() => window.log.requests);
      await show([
        { src, loop: true, paused: true },
        { src, loop: true, paused: true, position: [1, 0, 0] },
      ]);
      await page.waitForFunction(() => window.shown() === 2);
      assert.equal(await page.evaluate(() => window.log.clips[0] === window.log.clips[1]), true);
      assert.equal(await page.evaluate(() => window.log.requests), before, "it was fetched again");
      await show([]);
      await page.waitForFunction(() => window.shown() === 0);
      await page.close();
      assertNoTroubles();
    });

  test("a clip that no component shows is disposed of", async () => {
    const page = await open();
    await page.evaluate((url) => window.show([{ src: url, loop: true, autoPlay: true }]), src);
    await page.waitForFunction(() => window.log.frames.length > 1);
    await page.evaluate(() => {
      [window.kept] = window.log.clips;
      window.show([]);
    });
    await page.waitForFunction(() => window.kept.frame === null);
    // Mounted again it is another one.
    await page.evaluate((url) => window.show([{ src: url }]), src);
    await page.waitForFunction(() => window.shown() === 1 && window.log.clips[0] !== window.kept);
    await page.evaluate(() => window.unmount());
    await page.close();
    assertNoTroubles();
  });

  test("an error is thrown for the next boundary", async () => {
    const page = await open();
    await page.evaluate(() => window.show([{ src: "/missing.fvv" }]));
    await page.waitForFunction(() => window.log.failed !== null);
    assert.match(await page.evaluate(() => window.log.failed), /missing\.fvv: HTTP status 404/);
    await page.close();
    browser.troubles.length = 0;
  });

  test("in a headset, with @react-three/xr", async () => {
    const page = await browser.newPage(`${served.url}test/room_page.html?file=/clip.fvv`, 640, 360);
    await page.waitForSelector("[data-ready]");
    await page.waitForSelector("canvas");
    /** How many of the page's pixels in a half of it are coloured: neither ground nor lines. */
    const colourful = async (from, to) => {
      const { width, height, data } = PNG.sync.read(Buffer.from(await page.screenshot()));
      let count = 0;
      for (let y = 0; y < height; y++)
        for (let x = Math.floor(from * width); x < to * width; x++) {
          const rgb = data.subarray(4 * (y * width + x), 4 * (y * width + x) + 3);
          count += Math.max(...rgb) - Math.min(...rgb) > 50;
        }
      return count;
    };
    const until = async (condition) => {
      for (let i = 0; i < 100 && !(await condition()); i++) await new Promise((later) => setTimeout(later, 100));
    };
    await until(async () => (await colourful(0, 1)) > 300);
    assert.ok((await colourful(0, 1)) > 300, "nothing is shown before the headset");
    const [, headset] = await page.$$("nav button");
    await headset.click();
    await page.waitForFunction(() => window.device.activeSession);
    const eyes = async () => [await colourful(0, 0.5), await colourful(0.5, 1)];
    await until(async () => Math.min(...(await eyes())) > 100);
    const seen = await eyes();
    assert.ok(Math.min(...seen) > 100, `pixels that the eyes see: ${seen}`);
    await page.screenshot({ path: process.env.FVV_ROOM_PICTURE ?? join(served.folder, "room.png") });
    await page.close();
    // @react-three/xr asks another host for profiles of controllers, which the content policy forbids.
    const left = browser.troubles.filter((text) => !/webxr-input-profiles|Failed to fetch/.test(text));
    browser.troubles.splice(0, Infinity, ...left);
    assertNoTroubles();
  });
});
