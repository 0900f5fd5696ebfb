// Decoders of video that the browser takes back while nothing is decoded, as it may at any time, and such that are late, in
// Chromium: each frame gets its pictures all the same, compared with those of a decoder that was left alone.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { drivePage, openPage } from "./page_driver.mjs";

const FRAMES = 16;
/** Longer than a decoder that works may keep a picture. */
const LATE_MS = 2600;

/** Replaces VideoDecoder in a page: window.reclaim() takes all of them back, window.lateMs delays their pictures. */
function replaceDecoder() {
  const Real = window.VideoDecoder;
  const open = new Set();
  window.lateMs = 0;
  window.VideoDecoder = class extends Real {
    #error;
    constructor({ output, error }) {
      super({
        output: (frame) => (window.lateMs ? setTimeout(() => output(frame), window.lateMs) : output(frame)),
        error,
      });
      this.#error = error;
      open.add(this);
    }
    take() {
      if (this.state !== "configured") return 0;
      this.close();
      this.#error(new DOMException("Codec reclaimed due to inactivity.", "QuotaExceededError"));
      return 1;
    }
  };
  window.reclaim = () => Array.from(open, (decoder) => decoder.take()).reduce((sum, n) => sum + n, 0);
}

describe("decoders of video", { skip: missingBrowser("chromium") }, () => {
  let folder, opened, page;
  const known = []; // the picture of each frame, as a digest

  before(async () => {
    folder = mkdtempSync(join(tmpdir(), "fvv-codecs-"));
    const [capture, clip] = [join(folder, "capture"), join(folder, "clip.fvv")];
    tool("fvvsynth", "-o", capture, ..."--rig small --cameras 3 --size 160x120 --frames".split(" "), `${FRAMES}`);
    tool("fvvmux", capture, "-o", clip, ..."--group 8 --quality 30 --triangles 4000".split(" "));
    opened = await openPage("chromium", clip);
    page = await opened.browser.newPage("about:blank", 720, 560);
    await page.evaluateOnNewDocument(replaceDecoder);
    await page.goto(`${opened.served.url}page.html`);
    await until(() => window.player?.readyState === 4);
    await ask(() => {
      Object.assign(window.player, { pixelRatio: 1, worker: "none", cameraOrbit: "20deg 80deg 4m" });
      window.player.load();
    });
    await until(() => window.player.readyState === 4);
    for (let frame = 0; frame < FRAMES; frame++) {
      await seekTo(frame);
      known.push(await picture());
    }
    assert.equal(new Set(known).size, FRAMES);
  });
  after(async () => {
    await opened?.close();
    rmSync(folder, { recursive: true, force: true });
  });

  const { ask, until, still, seekTo } = drivePage(() => page, null, "codecs");
  const picture = async () => {
    await still();
    return ask(async () => {
      const { data } = window.player._stage.renderer.readPixels();
      const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", data));
      return Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join("");
    });
  };
  /** The frame on screen gets its picture within some seconds. */
  const assertPicture = async (frame, what) => {
    for (let i = 0; i < 100 && (await picture()) !== known[frame]; i++)
      await new Promise((done) => setTimeout(done, 100));
    assert.equal(await picture(), known[frame], `${what}: frame ${frame}`);
  };

  test("taken back during a pause: playback goes on, with pictures", async () => {
    await seekTo(2);
    assert.ok((await ask(() => window.reclaim())) > 0);
    const shown = await ask(() => {
      window.player.loop = true;
      window.player.play();
      return window.player.stats.framesShown;
    });
    await until((shown) => window.player.stats.framesShown > shown + 16, shown);
    await ask(() => window.player.pause());
    await until(() => !window.player.seeking);
    await assertPicture(await ask(() => window.player.currentFrame), "after playback");
    assert.equal(await ask(() => window.player.error), null);
  });

  test("taken back before steps: each frame has its picture", async () => {
    for (const first of [3, 9]) {
      await seekTo(first);
      assert.ok((await ask(() => window.reclaim())) > 0);
      for (let frame = first + 1; frame < first + 5; frame++) {
        await ask(() => window.player.step(1));
        await until((frame) => !window.player.seeking && window.player.currentFrame === frame, frame);
        await assertPicture(frame, `steps from ${first}`);
      }
    }
  });

  test("pictures that come late come", async () => {
    await ask((milliseconds) => (window.lateMs = milliseconds), LATE_MS);
    await ask(() => (window.player.currentFrame = 12));
    await until(() => !window.player.seeking && window.player.currentFrame === 12);
    await ask(() => (window.lateMs = 0));
    await assertPicture(12, "late");
  });
});
