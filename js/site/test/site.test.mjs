// The demo site, served by fvvserve under its content policy: every page in Chromium, wide and narrow, light and dark.
// FVV_PICTURES=FOLDER keeps screenshots.

import assert from "node:assert/strict";
import { cpSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { PNG } from "pngjs";

import { violationsOf } from "../../testing/axe.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { buildSite } from "../build.mjs";

const pictures = process.env.FVV_PICTURES;
const [WIDE, NARROW] = [
  [1440, 900],
  [390, 844],
];
const CASES = [
  { name: "index", path: "", size: WIDE, scheme: "light" },
  { name: "index", path: "", size: NARROW, scheme: "dark" },
  { name: "embed", path: "embed.html", size: WIDE, scheme: "dark" },
  { name: "embed", path: "embed.html", size: NARROW, scheme: "light" },
  { name: "five", path: "five-lines.html", size: NARROW, scheme: "dark" },
  { name: "three", path: "three/", size: NARROW, scheme: "dark" },
];

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
    const names = at("names.json");
    writeFileSync(names, JSON.stringify({ "player 1": { object: 1 }, "player 2": { object: 2 }, ball: { object: 3 } }));
    tool("fvvmux", at("capture"), "-o", clips[0], "--max-error", "0.5", "--objects", names);
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
      if (name !== "three") assert.ok((await seen(page)) > 500, "the player shows nothing");
      if (name === "three") await page.waitForSelector("[data-drawn]");
      await keep(page, `${name}-${size[0]}-${scheme}`);
      const [wide, room] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
      assert.ok(wide <= room, `${wide} pixels in ${room}`);
      assert.deepEqual(await violationsOf(page), []);
      await page.close();
      assert.deepEqual(browser.troubles.splice(0), []);
    });

  test("a play with prepared marks is one click away", async () => {
    const page = await open("", WIDE, "light");
    await seen(page);
    await page.click("#analyse");
    const drawn = () =>
      document.querySelector("fvv-player").shadowRoot.querySelectorAll(".scene-marks path[stroke]").length >= 2;
    await page.waitForFunction(drawn, { timeout: 30000 });
    assert.deepEqual(await violationsOf(page), []);
    await keep(page, "index-marks");
    await page.click("#analyse");
    await page.waitForFunction(() => !document.querySelector("fvv-player").shadowRoot.querySelector(".tools"));
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
    // The side that the stream chose, and not the place of a camera.
    assert.equal(await page.$eval("fvv-player", (player) => player.camera), null);
    const former = await facts();
    assert.ok(former.includes("7 cameras") && former.includes("6 frames"), former.join(", "));
    assert.doesNotMatch(former.join(" "), /\.\d{4}/, "too many digits");
    assert.ok((await parts()).includes("Environment"));
    assert.match(
      await page.$eval("#compared", ({ textContent }) => textContent),
      /times less.*27\.3 MB.*This clip.*\d (MB|kB)/,
    );
    assert.doesNotMatch(await page.$eval("#compared", ({ textContent }) => textContent), /Time/, "machines differ");
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
    // A phone's page and the player's help say what a finger does.
    const help = () =>
      page.evaluate(() => {
        const { shadowRoot } = document.querySelector("fvv-player");
        const texts = [...document.querySelectorAll(".intro span"), ...shadowRoot.querySelectorAll(".panel p span")];
        return texts.filter((node) => node.checkVisibility()).map(({ textContent }) => textContent);
      });
    await page.evaluate(() => document.querySelector("fvv-player").focus());
    await page.keyboard.press("h");
    const mouse = await help();
    assert.equal(mouse.length, 2);
    assert.ok(mouse.every((text) => /scroll to zoom/.test(text)));
    const tools = await page.createCDPSession();
    await tools.send("Emulation.setTouchEmulationEnabled", { enabled: true });
    await page.waitForFunction(() => matchMedia("(pointer: coarse)").matches);
    const finger = await help();
    assert.equal(finger.length, 2);
    assert.ok(finger.every((text) => /^Swipe sideways/.test(text)));
    await keep(page, "finger");
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

  test("the sample of a script runs as it is printed", async () => {
    const page = await open("embed.html", WIDE, "light");
    const text = await page.$eval('pre[aria-label="JavaScript"]', ({ textContent }) => textContent);
    await page.evaluate(`(async () => { ${text} })()`);
    const { camera, fov, rate, time } = await page.evaluate(() => {
      const player = document.querySelector("fvv-player");
      return { camera: player.camera, fov: player.getPose().fov, rate: player.playbackRate, time: player.currentTime };
    });
    // The angle of view has changed since: it is no longer the camera's view.
    assert.deepEqual([camera, rate], [null, 0.25]);
    assert.ok(Math.abs(fov - 35) < 1e-6 && time > 0, `${fov} ${time}`);
    await page.close();
    assert.deepEqual(browser.troubles.splice(0), []);
  });

  for (const way of ["chosen", "dropped"])
    test(`a file that is ${way} plays, and is not uploaded`, async () => {
      const page = await open("", ...(way === "chosen" ? [[720, 600], "light"] : [NARROW, "dark"]));
      await seen(page);
      const sent = [];
      page.on("request", (request) => sent.push(`${request.method()} ${request.url()}`));
      cpSync(join(served.folder, "still.fvv"), join(served.folder, "my own & only.fvv"));
      if (way === "chosen") await (await page.$("#file")).uploadFile(join(served.folder, "my own & only.fvv"));
      else {
        const content = readFileSync(join(served.folder, "still.fvv")).toString("base64");
        const veiled = await page.evaluate(async (base64) => {
          const dataTransfer = new DataTransfer();
          const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
          dataTransfer.items.add(new File([bytes], "my own & only.fvv"));
          const fire = (type) =>
            document.body.dispatchEvent(new DragEvent(type, { dataTransfer, bubbles: true, cancelable: true }));
          fire("dragenter");
          fire("dragover");
          const shown = !document.getElementById("drop").hidden;
          const taken = !fire("drop");
          return { shown, taken, hidden: document.getElementById("drop").hidden };
        }, content);
        assert.deepEqual(veiled, { shown: true, taken: true, hidden: true });
      }
      await page.waitForFunction(() => /1 framein total|1 frame\d/.test(document.querySelector("#facts").textContent));
      assert.ok((await seen(page)) > 500);
      const about = await page.$eval("#about", ({ textContent }) => textContent);
      assert.match(about, /^my own & only\.fvv\. .*nothing is uploaded/);
      assert.deepEqual(await page.$$eval("[data-known]", (all) => all.map(({ hidden }) => hidden)), [true, true]);
      assert.deepEqual(
        sent.filter((request) => !request.includes(" blob:") && !/\.js$/.test(request)),
        [],
      );
      await page.click(".source summary");
      assert.match(
        await page.$eval("#source", ({ textContent }) => textContent),
        /src="my own &amp; only\.fvv" controls/,
      );
      await keep(page, `local-${way}`);
      assert.deepEqual(await violationsOf(page), []);
      const [wide, room] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
      assert.ok(wide <= room, `${wide} pixels in ${room}`);
      await page.click('#chooser label:has([value="players"])');
      await page.waitForFunction(() => document.querySelector("#facts").textContent.includes("6 frames"));
      assert.deepEqual(await page.$$eval("[data-known]", (all) => all.map(({ hidden }) => hidden)), [false, false]);
      await page.close();
      assert.deepEqual(browser.troubles.splice(0), []);
    });

  test("the file of fvvserve --open plays", async () => {
    mkdirSync(join(served.folder, "open"));
    cpSync(join(served.folder, "still.fvv"), join(served.folder, "open/clip.fvv"));
    const page = await open("?open=my%20clip.fvv", NARROW, "light");
    assert.ok((await seen(page)) > 500);
    assert.match(await page.$eval("#about", ({ textContent }) => textContent), /^my clip\.fvv\. .*fvvserve --open/);
    assert.ok((await page.$eval("#facts", ({ textContent }) => textContent)).includes("1 frame"));
    await page.close();
    assert.deepEqual(browser.troubles.splice(0), []);
  });

  test("the source of the clip on screen is a page that plays it", async () => {
    const page = await open("", NARROW, "light");
    await seen(page);
    const source = await page.$eval("#source", ({ textContent }) => textContent);
    assert.equal(source.split("\n").length, 2);
    writeFileSync(join(served.folder, "pasted.html"), `<!doctype html><html lang="en"><title>Pasted</title>${source}`);
    await page.goto(`${served.url}pasted.html`);
    assert.ok((await seen(page)) > 500);
    assert.equal(page.workers().length, 1);
    await page.close();
    assert.deepEqual(browser.troubles.splice(0), []);
  });

  test("no requests to other hosts", () => {
    assert.deepEqual(
      [...requested].filter((origin) => origin !== "null"),
      [new URL(served.url).origin],
    );
  });
});
