// The element and the page around it, in Chromium: moved within a document and into others, right-to-left pages, out of view,
// other densities of the screen, more players than WebGL contexts, contexts that are lost.

import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { Contexts } from "../src/contexts.js";
import { drivePage, openPage } from "./page_driver.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));
const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

test("contexts: those out of view give theirs back first, then those that rest, never those that draw", () => {
  const contexts = new Contexts(3);
  const given = [];
  const holders = [...Array(6)].map((_, i) => ({ visible: true, idle: true, giveBack: () => given.push(i) }));
  for (const i of [0, 1, 2]) assert.equal(contexts.use(holders[i]), true);
  contexts.use(holders[0]);
  holders[2].visible = false;
  assert.equal(contexts.use(holders[3]), true);
  assert.deepEqual(given, [2]);
  assert.equal(contexts.use(holders[4]), true);
  assert.deepEqual(given, [2, 1], "the one that drew first");
  for (const holder of holders) holder.idle = false;
  assert.equal(contexts.use(holders[5]), false);
  contexts.leave(holders[0]);
  assert.equal(contexts.use(holders[5]), true);
  assert.equal(contexts.count, 3);
});

describe("the page", { skip: missingBrowser("chromium") }, () => {
  let folder, opened, browser, page;

  before(async () => {
    mkdirSync(screens, { recursive: true });
    folder = mkdtempSync(join(tmpdir(), "fvv-page-"));
    const capture = join(folder, "capture");
    const clip = join(folder, "players.fvv");
    tool("fvvsynth", "-o", capture, "--rig", "small", "--cameras", "4", "--frames", "24", "--size", "240x160");
    tool("fvvmux", capture, "-o", clip, "--group", "8", "--quality", "30", "--triangles", "6000");
    opened = await openPage("chromium", clip);
    ({ browser, page } = opened);
    await until(() => window.player.readyState === 4);
  });
  after(async () => {
    await opened?.close();
    rmSync(folder, { recursive: true, force: true });
  });

  const { ask, until, events, screen, colourful, still, seekTo } = drivePage(() => page, screens, "page");
  const play = () => ask(() => Object.assign(window.player, { loop: true }).play());
  const pause = () => ask(() => window.player.pause());
  const facts = () =>
    ask(() => {
      const { paused, currentFrame, stats } = window.player;
      return { paused, currentFrame, eye: window.player.getPose().eye, shown: stats.framesShown };
    });
  /** Whether frames are decoded and drawn: how many in a second. */
  const advance = async (milliseconds) => {
    const count = () => ask(() => [window.player.stats.framesShown, window.player.stats.drawnFrames]);
    const former = await count();
    await wait(milliseconds);
    return (await count()).map((value, i) => value - former[i]);
  };

  test("removed and put back within a second it keeps its place, view and pause", async () => {
    await seekTo(10);
    await ask(() => window.player.setPose({ eye: [3, 2, 4], target: [0, 1, 0] }));
    await still();
    const former = await facts();
    await events();
    await ask(() => window.player.remove());
    await wait(400);
    await ask(() => document.querySelector("main").prepend(window.player));
    await wait(900); // beyond the second
    assert.deepEqual(await facts(), former);
    assert.deepEqual(await events(), []);
    assert.ok((await colourful()) > 0.005);
    await play();
    await until((shown) => window.player.stats.framesShown > shown + 2, former.shown);
    await ask(() => {
      window.player.remove();
      window.away = window.player.stats.framesShown;
    });
    await wait(500);
    const { paused, shown } = await facts();
    assert.deepEqual([paused, shown - (await ask(() => window.away)) <= 1], [false, true], "played in no document");
    await ask(() => document.querySelector("main").prepend(window.player));
    await until(() => window.player.stats.framesShown > window.away + 3);
    assert.deepEqual((await facts()).eye, former.eye);
    assert.ok(!(await events()).includes("emptied"));
    await pause();
  });

  test("removed for longer it closes its source, and loads it again", async () => {
    await ask(() => window.player.remove());
    await until(() => window.player.readyState === 0 && !window.player._stage);
    await ask(() => document.querySelector("main").prepend(window.player));
    await until(() => window.player.readyState === 4);
    await still();
    assert.ok((await colourful()) > 0.005);
  });

  test("controls fade when playback begins without input", async () => {
    const opacity = () =>
      ask(() => getComputedStyle(window.player.shadowRoot.querySelector(".controls")).opacity).then(Number);
    await ask(() => {
      window.player.loop = window.player.autoplay = true;
      window.player.load();
    });
    await until(() => !window.player.paused);
    assert.equal(await opacity(), 1);
    await until(() => getComputedStyle(window.player.shadowRoot.querySelector(".controls")).opacity === "0");
    await screen("faded");
    await pause();
    await until(() => getComputedStyle(window.player.shadowRoot.querySelector(".controls")).opacity === "1");
    await ask(() => (window.player.autoplay = false));
  });

  /** What the player looks like in its document, which is not that of the page. */
  const layout = () =>
    ask(() => {
      const { shadowRoot, ownerDocument } = window.player;
      const style = (node) => ownerDocument.defaultView.getComputedStyle(node);
      const { clientWidth, clientHeight } = shadowRoot.querySelector("canvas");
      const host = window.player.getBoundingClientRect();
      return {
        elsewhere: ownerDocument !== document,
        sheets: shadowRoot.adoptedStyleSheets.length,
        display: style(window.player).display,
        controls: style(shadowRoot.querySelector(".controls")).position,
        fills: clientWidth > 100 && clientWidth === host.width && clientHeight === host.height,
      };
    });
  const assertPlays = async () => {
    await play();
    const { framesShown: shown, drawnFrames: drawn } = await ask(() => window.player.stats);
    const goesOn = (shown, drawn) => {
      const { framesShown, drawnFrames } = window.player.stats;
      return framesShown > shown + 2 && drawnFrames > drawn + 2;
    };
    await until(goesOn, shown, drawn);
    await seekTo(6);
    await still();
  };
  const assertStyled = async () => {
    await still();
    const styled = { elsewhere: true, sheets: 4, display: "block", controls: "absolute", fills: true };
    assert.deepEqual(await layout(), styled);
    assert.ok((await colourful()) > 0.005);
  };
  const assertBack = async () => {
    await still();
    const { elsewhere, sheets } = await layout();
    assert.deepEqual([elsewhere, sheets], [false, 4]);
    assert.ok((await colourful()) > 0.005);
  };

  test("in an iframe it is styled, and goes on", async () => {
    await seekTo(5);
    const former = await facts();
    await ask(() => {
      const frame = document.createElement("iframe");
      frame.width = frame.height = "400";
      document.body.append(frame);
      frame.contentDocument.body.append(window.player);
    });
    assert.equal((await facts()).currentFrame, former.currentFrame);
    try {
      await assertStyled();
      await assertPlays();
      await screen("iframe");
    } finally {
      await ask(() => {
        document.querySelector("main").prepend(window.player);
        document.querySelector("iframe").remove();
      });
    }
    await assertBack();
  });

  test("on a right-to-left page the slider runs with time", async () => {
    await ask(() => (document.documentElement.dir = "rtl"));
    await seekTo(18);
    await still();
    const { direction, played, width } = await ask(() => {
      const { shadowRoot } = window.player;
      const box = (node) => node.getBoundingClientRect();
      const scrubber = box(shadowRoot.querySelector(".scrubber"));
      const { left, right } = box(shadowRoot.querySelector("[part~=played]"));
      const { direction } = getComputedStyle(shadowRoot.querySelector(".scrubber input"));
      return { direction, played: [left - scrubber.left, right - scrubber.left], width: scrubber.width };
    });
    await screen("rtl");
    assert.equal(direction, "ltr");
    assert.ok(played[0] < 12 && Math.abs(played[1] - (18 / 24) * width) < 24, `${played} of ${width}`);
    const inside = await ask(() => {
      const { left, right } = window.player.getBoundingClientRect();
      return [...window.player.shadowRoot.querySelectorAll(".bar *")].every((node) => {
        const box = node.getBoundingClientRect();
        return box.width === 0 || (box.left >= left && box.right <= right);
      });
    });
    assert.ok(inside);
    await ask(() => document.documentElement.removeAttribute("dir"));
  });

  test("another density of the screen draws the paused picture again", async () => {
    await seekTo(3);
    for (const deviceScaleFactor of [2, 1, 1.5]) {
      // With an emulated screen, queries are evaluated again only when the window's size changes; that of the player does not.
      await page.setViewport({ width: 720, height: 560 + deviceScaleFactor * 10, deviceScaleFactor });
      await until((factor) => {
        requestAnimationFrame(() => {}); // without a screen the browser draws only on request
        const { width, clientWidth } = window.player.shadowRoot.querySelector("canvas");
        return devicePixelRatio === factor && width === Math.round(clientWidth * factor);
      }, deviceScaleFactor);
      assert.ok((await colourful()) > 0.005);
    }
    await page.setViewport({ width: 720, height: 560 });
  });

  for (const [how, hide, show] of [
    ["out of view", () => (document.body.style.paddingTop = "5000px"), () => (document.body.style.paddingTop = "")],
    ["display: none", () => (window.player.style.display = "none"), () => (window.player.style.display = "")],
  ])
    test(`${how} it neither decodes nor draws`, async () => {
      await play();
      await ask(hide);
      await until(() => !window.player._stage.visible);
      await wait(300);
      const decoded = () => ask(() => window.player._stage.renderer.counters.contentFrames);
      const former = [await decoded(), await ask(() => window.player.currentTime)];
      assert.deepEqual(await advance(1000), [0, 0]);
      assert.deepEqual([await decoded(), await ask(() => window.player.currentTime)], former);
      assert.equal(await ask(() => window.player.paused), false);
      await ask(show);
      await ask(() => scrollTo(0, 0));
      await assertPlays();
    });

  test("20 players: all show their picture, and those in view play", async () => {
    await ask(() => {
      window.many = [...Array(19)].map(() => {
        const player = document.createElement("fvv-player");
        player.src = "players.fvv";
        player.setAttribute("worker", "worker.js");
        player.style.cssText = "width:160px;display:inline-block";
        document.body.append(player);
        return player;
      });
    });
    await until(() => window.many.every((player) => player.readyState === 4));
    const drawn = (player) => {
      const [canvas, copy] = player.shadowRoot.querySelectorAll(".surface canvas");
      return copy !== undefined || !(canvas.getContext("webgl2")?.isContextLost() ?? true);
    };
    await ask(`window.drawn = ${drawn}`);
    for (let i = 0; i < 19; i += 3) {
      await ask((i) => window.many[i].scrollIntoView({ block: "center" }), i);
      await until((i) => window.drawn(window.many[i]) && window.many[i].stats.drawnFrames > 0, i);
    }
    // The first one has given its context back, and shows a copy of its picture until there is something to draw.
    await ask(() => scrollTo(0, 0));
    assert.deepEqual(await ask(() => [window.player._stage.renderer.released, window.drawn(window.player)]), [
      true,
      true,
    ]);
    await screen("copy");
    await ask(() => window.player.setPose({ eye: [3, 2, 4], target: [0, 1, 0] }));
    await until(() => !window.player._stage.renderer.lost && !window.player._stage.busy);
    assert.ok((await colourful()) > 0.005);
    await ask(() => window.many[18].scrollIntoView({ block: "end" }));
    await screen("many");
    // One that takes its context back may wait for another's.
    await until(() => {
      const all = [window.player, ...window.many];
      const lost = all.filter(({ _stage: { renderer } }) => renderer.lost).length;
      return lost >= 8 && lost <= 12;
    });
    assert.deepEqual(await ask(() => window.many.filter(({ contextLost }) => contextLost).length), 0);
    await ask(() => {
      for (const player of window.many) player.remove();
      scrollTo(0, 0);
    });
    await until(() => window.many.every(({ _stage }) => !_stage));
    await assertPlays();
  });

  test("a context that does not come back is reported, and another one draws the same view", async () => {
    await seekTo(7);
    await ask(() => window.player.setPose({ eye: [3, 2, 4], target: [0, 1, 0] }));
    await still();
    const former = await facts();
    const coloured = await colourful();
    const text = () => ask(() => window.player.shadowRoot.querySelector(".message").textContent);
    const lose = () =>
      ask(() => {
        const context = window.player.shadowRoot.querySelector("canvas").getContext("webgl2");
        window.loser = context.getExtension("WEBGL_lose_context");
        window.loser.loseContext();
      });
    await lose();
    await wait(200);
    assert.equal(await text(), "", "it may come back");
    await until(() => window.player.contextLost);
    await until(() => !window.player.shadowRoot.querySelector(".message").hidden);
    assert.match(await text(), /the browser has taken the WebGL context away/);
    await screen("context");
    // The browser gives it back after all.
    await ask(() => window.loser.restoreContext());
    await until(() => window.player.shadowRoot.querySelector(".message").hidden && !window.player.contextLost);
    await still();
    assert.ok(Math.abs((await colourful()) - coloured) < 0.002);
    await lose();
    await until(() => !window.player.shadowRoot.querySelector(".message").hidden);
    await ask(() => window.player.shadowRoot.querySelector(".message button").click());
    await until(() => !window.player.seeking && window.player.shadowRoot.querySelector(".message").hidden);
    await still();
    const { paused, currentFrame, eye } = await facts();
    assert.deepEqual({ paused, currentFrame, eye }, { paused: true, currentFrame: 7, eye: former.eye });
    assert.ok(Math.abs((await colourful()) - coloured) < 0.002);
  });

  test("without WebGL it says so", async () => {
    const message = await ask(async () => {
      const { getContext } = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = () => null;
      const player = document.createElement("fvv-player");
      player.src = "players.fvv";
      document.body.append(player);
      await new Promise((reported) => player.addEventListener("error", reported, { once: true }));
      await new Promise((done) => setTimeout(done, 100));
      HTMLCanvasElement.prototype.getContext = getContext;
      const { textContent } = player.shadowRoot.querySelector(".message");
      player.remove();
      return textContent;
    });
    assert.match(message, /Cannot play this: WebGL 2 is not available/);
  });

  test("in a pop-up window it is styled, and goes on", async () => {
    await ask(() => {
      window.popup = open("", "", "width=500,height=400");
      window.popup.document.body.append(window.player);
    });
    try {
      await until(() => window.player.shadowRoot.querySelector("canvas").clientWidth > 100);
      await assertStyled();
      await seekTo(9);
      await still();
      assert.ok((await colourful()) > 0.005);
    } finally {
      await ask(() => {
        document.querySelector("main").prepend(window.player);
        window.popup.close();
      });
      await page.bringToFront();
    }
    await assertBack();
  });

  test("in a document picture-in-picture window it keeps place, view and pause, plays on, and comes back", async () => {
    assert.ok(await ask(() => "documentPictureInPicture" in window), "this Chromium has documentPictureInPicture");
    await pause();
    await seekTo(5);
    await ask(() => window.player.setPose({ eye: [3, 2, 4], target: [0, 1, 0] }));
    await still();
    const former = await facts();
    await events();
    await ask(async () => {
      window.popup = await window.documentPictureInPicture.requestWindow({ width: 500, height: 400 });
      window.popup.addEventListener("pagehide", () => document.querySelector("main").prepend(window.player));
      window.popup.document.body.append(window.player);
    });
    const states = async () => {
      const { paused, currentFrame, eye } = await facts();
      return { paused, currentFrame, eye };
    };
    const { shown, ...kept } = former;
    assert.ok(shown > 0);
    try {
      await until(() => window.player.shadowRoot.querySelector("canvas").clientWidth > 100);
      assert.ok(await ask(() => window.player.ownerDocument.defaultView === window.documentPictureInPicture.window));
      assert.deepEqual(await states(), kept);
      await assertStyled();
      await assertPlays();
      await play();
    } finally {
      // As with the button of the window.
      await ask(() => window.popup.close());
    }
    await until(() => window.player.ownerDocument === document);
    assert.deepEqual((await facts()).eye, kept.eye);
    const { framesShown } = await ask(() => window.player.stats);
    await until((shown) => !window.player.paused && window.player.stats.framesShown > shown + 2, framesShown);
    assert.ok(!(await events()).includes("emptied"), "the source stays open");
    await seekTo(7);
    await assertBack();
  });

  test("no errors", () => assert.deepEqual(browser.troubles, []));
});
