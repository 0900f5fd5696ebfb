// Sources that are set again and again, positions that are set before there is anything to show, and boxes without room, in
// Chromium. The film has a ladder and comes over a slow network.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { drivePage, openPage } from "./page_driver.mjs";

const FRAMES = 24;
const PLACE = 16;
const SECONDS = PLACE / 25;
/** Milliseconds that each reply takes. */
const LATENCY = 40;
const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

describe("sources", { skip: missingBrowser("chromium") }, () => {
  let folder, opened, browser, served, page;

  before(async () => {
    folder = mkdtempSync(join(tmpdir(), "fvv-sources-"));
    const [capture, clip] = [join(folder, "capture"), join(folder, "clip.fvv")];
    tool("fvvsynth", "-o", capture, ..."--rig small --cameras 3 --size 160x120 --frames".split(" "), `${FRAMES}`);
    tool("fvvmux", capture, "-o", clip, ..."--group 8 --quality 30 --triangles 4000 --ladder 1,0.5".split(" "));
    opened = await openPage("chromium", clip);
    ({ browser, served, page } = opened);
    await until(() => window.player.readyState === 4);
  });
  after(async () => {
    await opened?.close();
    rmSync(folder, { recursive: true, force: true });
  });

  const { ask, until, events, colourful } = drivePage(() => page, null, "sources");

  test("the same value of src loads again", async () => {
    await events();
    await ask(() => (window.player.src = window.player.getAttribute("src")));
    await until(() => window.player.readyState === 4);
    assert.deepEqual((await events()).slice(0, 3), ["abort", "emptied", "loadstart"]);
    await ask(() => window.player.setAttribute("src", window.player.getAttribute("src")));
    await until(() => window.player.readyState === 4);
    assert.ok((await events()).includes("loadstart"));
    await ask(() => window.player.setAttribute("live", ""));
    await ask(() => window.player.removeAttribute("live"));
    await until(() => window.player.readyState === 4);
  });

  test("of 60 sources in one task only the last one is opened, and none stays behind", async () => {
    await events();
    await ask(() => {
      performance.clearResourceTimings();
      window.player.loop = true;
      for (let i = 0; i < 60; i++) window.player.src = `players.fvv?n=${i}`;
      return window.player.play();
    });
    await until(() => window.player.stats.framesShown > 10);
    assert.match(await ask(() => window.player.currentSrc), /n=59$/);
    assert.equal(page.workers().length, 1);
    assert.equal((await events()).filter((type) => type === "loadstart").length, 1);
  });

  test("of 25 sources 60 ms apart, each while the one before it opens, the last one plays", async () => {
    await events();
    await ask(async () => {
      for (let i = 0; i < 25; i++) {
        window.player.src = `players.fvv?r=${i}`;
        await new Promise((done) => setTimeout(done, 60));
      }
      await window.player.play();
    });
    const shown = await ask(() => window.player.stats.framesShown);
    await until((shown) => window.player.stats.framesShown > shown + 10, shown);
    assert.match(await ask(() => window.player.currentSrc), /r=24$/);
    assert.equal(await ask(() => window.player.error), null);
    assert.equal(page.workers().length, 1);
    const seen = await events();
    for (const type of ["loadstart", "emptied"]) assert.equal(seen.filter((one) => one === type).length, 25, type);
    assert.ok(!seen.includes("error"), `${seen}`);
  });

  test("30 sources one after the other leave no workers, nodes, listeners or memory behind", async () => {
    const session = await page.createCDPSession();
    const held = async () => {
      await session.send("HeapProfiler.collectGarbage");
      const { JSHeapUsedSize, Nodes, JSEventListeners } = await page.metrics();
      return { heap: JSHeapUsedSize / 1e6, nodes: Nodes, listeners: JSEventListeners };
    };
    const load = async (i) => {
      await ask((i) => (window.player.src = `players.fvv?m=${i}`), i);
      await until(() => window.player.readyState >= 3);
    };
    for (let i = 0; i < 3; i++) await load(i);
    const former = await held();
    for (let i = 3; i < 33; i++) await load(i);
    const now = await held();
    assert.equal(page.workers().length, 1);
    assert.ok(now.heap < former.heap + 2, `${former.heap} MB, then ${now.heap} MB`);
    assert.ok(now.nodes < former.nodes + 100, `${former.nodes} nodes, then ${now.nodes}`);
    assert.ok(now.listeners < former.listeners + 30, `${former.listeners} listeners, then ${now.listeners}`);
  });

  test("without room it is no error, and with room again it draws", async () => {
    await ask(() => Object.assign(window.player.style, { display: "block", width: "0px", height: "0px" }));
    await wait(500);
    assert.equal(await ask(() => window.player.error), null);
    await ask(() => Object.assign(window.player.style, { width: "", height: "" }));
    await ask(() => window.player.play());
    const drawn = await ask(() => window.player.stats.drawnFrames);
    await until((drawn) => window.player.stats.drawnFrames > drawn + 2, drawn);
    assert.ok((await colourful()) > 0.005);
    await ask(() => window.player.pause());
  });

  test("the page can be printed, and the player goes on", async () => {
    const printed = await page.pdf();
    assert.equal(Buffer.from(printed.subarray(0, 5)).toString(), "%PDF-");
    await ask(() => window.player.play());
    const shown = await ask(() => window.player.stats.framesShown);
    await until((shown) => window.player.stats.framesShown > shown + 2, shown);
    await ask(() => window.player.pause());
    assert.equal(await ask(() => window.player.error), null);
  });

  /** Runs before the page does. Without a worker the page's requests, which are slow, are those of the decoder. */
  const prepare = (seek, seconds) => {
    const find = () => document.querySelector("fvv-player");
    new MutationObserver((_, observer) => {
      if (!find()) return;
      find().setAttribute("worker", "none");
      observer.disconnect();
    }).observe(document, { childList: true, subtree: true });
    customElements.whenDefined("fvv-player").then(() => seek(find(), seconds));
  };
  const bookmark = async () => {
    await ask((seconds) => (window.player.currentTime = seconds), SECONDS);
    await until((place) => !window.player.seeking && window.player.currentFrame === place, PLACE);
    return ask(() => window.player.bookmark);
  };
  for (const [name, seek, hash] of [
    [
      "at loadedmetadata",
      (player, seconds) =>
        player.addEventListener("loadedmetadata", () => (player.currentTime = seconds), { once: true }),
    ],
    [
      "at loadeddata",
      (player, seconds) => player.addEventListener("loadeddata", () => (player.currentTime = seconds), { once: true }),
    ],
    ["before there is metadata", (player, seconds) => (player.currentTime = seconds)],
    [
      "while the first frames play",
      (player, seconds) => {
        player.play().catch(() => {});
        player.addEventListener("loadeddata", () => setTimeout(() => (player.currentTime = seconds), 60), {
          once: true,
        });
      },
    ],
    ["by a bookmark in the address", () => {}, true],
  ])
    test(`a position that is set ${name} is reached over a slow network`, async () => {
      const address = hash ? `#fvv=${await bookmark()}` : "";
      const other = await browser.newPage("about:blank", 720, 560);
      await other.setRequestInterception(true);
      other.on("request", (request) => setTimeout(() => request.continue().catch(() => {}), LATENCY));
      await other.evaluateOnNewDocument(`(${prepare})(${seek}, ${SECONDS})`);
      await other.goto(`${served.url}page.html${address}`);
      await other.waitForFunction(
        (place) => !window.player.seeking && window.player.readyState >= 2 && window.player.currentFrame >= place,
        { timeout: 20000, polling: 50 },
        PLACE,
      );
      assert.equal(await other.evaluate(() => window.player.error), null);
      await other.close();
    });

  test("no errors", () => assert.deepEqual(browser.troubles, []));
});
