// The demo site, served by fvvserve under its content policy: every page in Chromium, wide and narrow, light and dark.
// FVV_PICTURES=FOLDER keeps screenshots.

import assert from "node:assert/strict";
import { mkdirSync, readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { PNG } from "pngjs";

import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { buildSite } from "../build.mjs";

const pictures = process.env.FVV_PICTURES;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const [WIDE, NARROW] = [
  [1440, 900],
  [390, 844],
];
const CASES = [
  { name: "index", path: "", size: WIDE, scheme: "light" },
  { name: "index", path: "", size: NARROW, scheme: "dark" },
  { name: "embed", path: "embed.html", size: WIDE, scheme: "dark" },
  { name: "embed", path: "embed.html", size: NARROW, scheme: "light" },
  { name: "five", path: "five-lines.html", size: NARROW, scheme: "light" },
  { name: "three", path: "three/", size: NARROW, scheme: "dark" },
  { name: "registry", path: "spec/registry.html", size: WIDE, scheme: "dark" },
  { name: "spec", path: "spec/fvv.html", size: NARROW, scheme: "light" },
];
const withoutPlayer = ["three", "registry", "spec"];

describe("site", { skip: missingBrowser("chromium") }, () => {
  let served, browser;
  const requested = new Set();

  async function open(path, [width, height], scheme) {
    const page = await browser.newPage("about:blank", width, height);
    page.on("request", (request) => requested.add(new URL(request.url()).origin));
    await page.emulateMediaFeatures([
      { name: "prefers-color-scheme", value: scheme },
      { name: "prefers-reduced-motion", value: "reduce" },
    ]);
    await page.goto(`${served.url}${path}`);
    return page;
  }
  async function keep(page, name) {
    if (!pictures) return;
    mkdirSync(pictures, { recursive: true });
    await page.screenshot({ path: join(pictures, `${name}.png`), fullPage: true });
  }
  /** Waits until the player has drawn a frame, and returns the number of colours. */
  async function seen(page) {
    await page.waitForFunction(() => document.querySelector("fvv-player").readyState >= 2, { timeout: 30000 });
    const player = await page.$("fvv-player");
    for (let attempt = 0; ; attempt++) {
      const { data } = PNG.sync.read(Buffer.from(await player.screenshot()));
      const colours = new Set();
      for (let i = 0; i < data.length; i += 4 * 61) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
      if (colours.size > 500 || attempt === 20) return colours.size;
      await new Promise((later) => setTimeout(later, 100));
    }
  }
  async function faults(page) {
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => window.axe.run());
    return violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target).join(" ")}`);
  }

  before(async () => {
    served = await serveFolder();
    const at = (name) => join(served.folder, name);
    const clips = ["players", "still"].map((name) => at(`${name}.fvv`));
    tool(
      "fvvsynth",
      "-o",
      at("capture"),
      "--rig",
      "small",
      "--frames",
      "6",
      "--size",
      "320x180",
      "--environment",
      "--sound",
    );
    tool("fvvmux", at("capture"), "-o", clips[0], "--max-error", "0.5");
    tool("fvvmux", at("capture"), "-o", clips[1], "--frames", "3-3", "--max-error", "0.5", "--codec", "jpeg");
    await buildSite(served.folder, (path) => JSON.parse(tool("fvvinfo", "--json", path)).files[0], clips);
    browser = await openBrowser();
  });
  after(async () => {
    await browser?.close();
    served?.close();
  });

  for (const { name, path, size, scheme } of CASES)
    test(`${name}, ${size[0]} wide, ${scheme}`, async () => {
      const page = await open(path, size, scheme);
      if (!withoutPlayer.includes(name)) assert.ok((await seen(page)) > 500, "the player shows nothing");
      if (name === "three") await page.waitForSelector("[data-drawn]");
      await keep(page, `${name}-${size[0]}-${scheme}`);
      const [wide, room] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
      assert.ok(wide <= room, `${wide} pixels in ${room}`);
      // A page of five lines cannot meet all rules.
      if (name !== "five") assert.deepEqual(await faults(page), []);
      await page.close();
      assert.deepEqual(browser.troubles.splice(0), []);
    });

  test("a browser without AudioDecoder loads a decoder of Opus, and no other does", async () => {
    const isDecoder = (name) =>
      name.endsWith(".js") && readFileSync(join(served.folder, name), "utf8").includes("OPUS_INVALID_PACKET");
    const decoders = readdirSync(served.folder).filter(isDecoder);
    assert.equal(decoders.length, 1);
    for (const lacking of [false, true]) {
      const page = await browser.newPage("about:blank", ...WIDE);
      const scripts = [];
      page.on("request", (request) => scripts.push(new URL(request.url()).pathname.slice(1)));
      if (lacking) await page.evaluateOnNewDocument(() => delete globalThis.AudioDecoder);
      await page.goto(`${served.url}five-lines.html`);
      await seen(page);
      await page.waitForFunction(() => document.querySelector("fvv-player").hasSound);
      for (let i = 0; i < 50 && lacking && !scripts.includes(decoders[0]); i++)
        await new Promise((later) => setTimeout(later, 100));
      assert.equal(scripts.includes(decoders[0]), lacking);
      await page.close();
      assert.deepEqual(browser.troubles.splice(0), []);
    }
  });

  for (const path of ["", "embed.html", "five-lines.html"])
    test(`controls are on the first screen: ${path || "index"}`, async () => {
      const page = await open(path, [1280, 800], "light");
      await seen(page);
      for (const [width, height] of [
        [1280, 800],
        [390, 844],
      ]) {
        await page.setViewport({ width, height });
        const bottom = await page.evaluate(async () => {
          await new Promise(requestAnimationFrame);
          const { shadowRoot } = document.querySelector("fvv-player");
          return shadowRoot.querySelector(".bar").getBoundingClientRect().bottom;
        });
        assert.ok(bottom <= height, `${bottom} of ${width}x${height}`);
      }
      await page.close();
    });

  test("facts are those of the chosen clip", async () => {
    const page = await open("", NARROW, "dark");
    await seen(page);
    const facts = () => page.$$eval("#facts dt", (all) => all.map(({ textContent }) => textContent));
    const parts = () => page.$$eval("#bytes th", (all) => all.map(({ textContent }) => textContent));
    const [players, still] = JSON.parse(readFileSync(join(served.folder, "clips.json"), "utf8"));
    assert.equal(players.cameras, 7);
    assert.equal(players.frames, 6);
    assert.equal(
      players.tracks.reduce((sum, { bytes }) => sum + bytes, 0) <= players.bytes,
      true,
      "the parts are larger than the file",
    );
    const former = await facts();
    assert.ok(former.includes("7 cameras") && former.includes("6 frames"), former.join(", "));
    assert.doesNotMatch(former.join(" "), /\.\d{4}/, "too many digits");
    assert.ok((await parts()).includes("Environment"));
    assert.match(await page.$eval("#compared", ({ textContent }) => textContent), /27\.3 MB.*1\.41 s.*\d (s|ms)/);
    await page.click('#chooser label:has([value="still"])');
    await page.waitForFunction(() => document.querySelector("#facts").textContent.includes("JPEG"));
    assert.equal(still.frames, 1);
    assert.ok((await facts()).includes("1 frame"));
    assert.ok((await seen(page)) > 500);
    assert.match(page.url(), /\?clip=still$/);
    await page.close();
    assert.deepEqual(browser.troubles.splice(0), []);
  });

  test("the button switches dark and light, also for the player, and the choice is kept", async () => {
    const page = await open("", NARROW, "light");
    const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await ground();
    await page.click("[data-theme-toggle]");
    const dark = await ground();
    assert.notEqual(dark, light);
    assert.equal(await page.$eval("fvv-player", (player) => player.getAttribute("theme")), "dark");
    await page.reload();
    assert.equal(await ground(), dark);
    await page.click("[data-theme-toggle]");
    assert.equal(await ground(), light);
    await page.evaluate(() => localStorage.clear());
    await page.close();
  });

  test("the listing is the linked page, in five lines", async () => {
    const page = await open("embed.html", WIDE, "light");
    await page.waitForFunction(() => document.getElementById("lines").textContent !== "");
    const lines = await page.$eval("#lines", ({ textContent }) => textContent);
    assert.equal(lines.split("\n").length, 5);
    assert.equal(`${lines}\n`, readFileSync(join(served.folder, "five-lines.html"), "utf8"));
    await page.close();
  });

  test("no requests to other hosts", () => {
    assert.deepEqual(
      [...requested].filter((origin) => origin !== "null"),
      [new URL(served.url).origin],
    );
  });
});
