// Clips in scenes of three, with each of its renderers in Chromium.

import assert from "node:assert/strict";
import { mkdirSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { PNG } from "pngjs";

import { bundle } from "../bundle.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { KINDS } from "./poses.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));

describe("clips", { skip: missingBrowser("chromium") }, () => {
  let served, browser, page;
  const at = (name) => join(served.folder, name);

  before(async () => {
    served = await serveFolder();
    const fixed = ["--view-loss", "none"];
    tool("fvvsynth", "-o", at("small"), "--rig", "small", "--frames", "10", "--size", "320x240");
    tool("fvvmux", at("small"), "-o", at("clip.fvv"), "--group", "5", ...fixed);
    tool(
      "fvvsynth",
      "-o",
      at("studio"),
      ..."--rig small --cameras 3 --frames 1 --size 160x120 --environment".split(" "),
    );
    tool("fvvmux", at("studio"), "-o", at("studio.fvv"), ...fixed);
    const loud = ["--rig", "small", "--cameras", "2", "--frames", "25", "--size", "160x120", "--sound"];
    tool("fvvsynth", "-o", at("loud"), ...loud);
    tool("fvvmux", at("loud"), "-o", at("loud.fvv"), ...fixed);
    await bundle(here("clip_page.js"), [here("clip_page.html")], at("test"));
    browser = await openBrowser("chromium", { webgpu: true });
    page = await browser.newPage(`${served.url}test/clip_page.html`);
    await page.waitForSelector("[data-ready]");
    // Browsers play no sound before it.
    await page.mouse.click(5, 5);
  });
  after(async () => {
    await browser?.close();
    served?.close();
  });

  /** Calls a function of clip_page.js, and ends its clips. */
  const call = (name, ...parameters) =>
    page.evaluate((what, given) => window[what](...given).finally(window.end), name, parameters);

  for (const kind of KINDS)
    describe(kind, async () => {
      let skipped = false;
      before(async () => {
        const backend = await page.evaluate((wanted) => window.backendOf(wanted), kind);
        skipped = (kind === "webgpu") !== (backend === "webgpu") && "this browser offers no WebGPU";
      });
      /** A test of this kind of renderer; playback and sound are the same with all. */
      const check = (title, body, { always = true } = {}) =>
        (always || kind === "webgl") &&
        test(title, async (context) => {
          if (skipped) return context.skip(skipped);
          await body();
          assert.deepEqual(browser.troubles, []);
        });

      check("it plays, ends and seeks as media elements do", async () => {
        const found = await call("playClip", kind, "/clip.fvv");
        assert.deepEqual(found.log, ["play", "playing", "pause", "ended", "seeking", "seeked"]);
        const { frames } = found;
        assert.ok(
          frames.every((number, i) => i === 0 || number === 0 || number > frames[i - 1]),
          `${frames}`,
        );
        assert.equal(frames.at(-1), 0);
        assert.deepEqual(
          { wasPaused: found.wasPaused, paused: found.paused, back: found.back, frameCount: found.frameCount },
          { wasPaused: false, paused: true, back: 0, frameCount: 10 },
        );
        assert.ok(Math.abs(found.duration - 0.4) < 1e-6 && found.currentTime === found.duration);
      });
      check(
        "a loop, and another source",
        async () => {
          const { rounds, ...rest } = await call("loopClip", kind, "/clip.fvv", "/studio.fvv");
          assert.ok(rounds >= 1, `${rounds} rounds`);
          assert.deepEqual(rest, { paused: true, frame: 0, loop: true, seeks: ["AbortError", "AbortError"] });
        },
        { always: false },
      );
      check("rays of three's Raycaster meet the clip and an instance of it where they are drawn", async () => {
        const found = await call("castRays", kind, "/clip.fvv");
        assert.ok(found.count > 1000 && found.right > 0.995, JSON.stringify(found));
        assert.ok(found.off < 1e-3, `${found.off} pixels`);
        assert.deepEqual(found.objects, ["clip", "instance"]);
      });
      check("shadows are cast and received", async () => {
        const { onFloor, lit, bright, shaded } = await call("castShadows", kind, "/clip.fvv");
        assert.ok(onFloor > 800, `${onFloor} pixels of shadow on the floor`);
        assert.ok(Math.abs(lit.mean - bright.mean) < 1, `a lamp without shadow: ${bright.mean} and ${lit.mean}`);
        // Half of the light, in display values.
        assert.ok(shaded.mean > 0.6 * lit.mean && shaded.mean < 0.8 * lit.mean, `${lit.mean} and ${shaded.mean}`);
      });
      check("fog", async () => {
        const { clear, near, far } = await call("drawFog", kind, "/clip.fvv");
        assert.ok(near.mean > clear.mean + 2 && near.mean < 0.7 * 255, `${clear.mean}, in fog ${near.mean}`);
        assert.ok(far.mean > 254, `far away ${far.mean}`);
      });
      check("two clips and a box hide each other", async () => {
        const { alone, both, before: inFront, behind } = await call("drawTwo", kind, "/clip.fvv", "/clip.fvv");
        assert.ok(both > 0.9 * alone, `${alone} and ${both} pixels`);
        assert.ok(inFront > 5000 && behind > 1000 && behind < 0.5 * inFront, `${inFront} before, ${behind} behind`);
      });
      // three's splats need WebGPURenderer.
      if (kind !== "webgl")
        check("three's splats and a clip hide each other", async () => {
          const { before: inFront, behind } = await call("drawSplats", kind, "/clip.fvv");
          assert.ok(inFront.clip < 100, `${inFront.clip} pixels of the clip through splats before it`);
          assert.ok(behind.clip > 4000, `${behind.clip} pixels of the clip before splats`);
          assert.ok(behind.wall > 20000 && inFront.wall > 60000, JSON.stringify({ inFront, behind }));
        });
      check("the static environment", async () => {
        const { meshes, withIt, without } = await call("drawEnvironment", kind, "/studio.fvv");
        assert.ok(meshes >= 2 && withIt > 2 * without, JSON.stringify({ meshes, withIt, without }));
      });
      check(
        "sound comes from a PositionalAudio at the clip",
        async () => {
          const found = await call("hear", kind, "/loud.fvv");
          assert.equal(found.state, "running");
          assert.ok(found.count >= 1 && found.loud > 0.01, JSON.stringify(found));
          assert.ok(found.silent < 0.05 * found.loud, `loud ${found.loud}, without volume ${found.silent}`);
          assert.ok(found.off < 0.5, `${found.off} m off`);
        },
        { always: false },
      );
      check("nothing is left of a clip that was disposed of", async () => {
        const found = await call("disposeClip", kind, "/clip.fvv");
        assert.ok(found.meanwhile.textures > found.before.textures);
        assert.deepEqual(found.after, found.before);
        assert.deepEqual({ audio: found.audio, ready: found.ready }, { audio: 0, ready: "AbortError" });
      });
      check(
        "a source that is not there",
        async () => {
          const found = await call("failClip", kind);
          assert.deepEqual({ isSame: found.isSame, code: found.code }, { isSame: true, code: 4 });
          assert.match(found.message, /missing\.fvv: HTTP status 404/);
          browser.troubles.splice(0, browser.troubles.length, ...browser.troubles.filter((text) => !/404/.test(text)));
        },
        { always: false },
      );
    });

  // build/screens/three.png; docs/pictures/three.jpg is made of it.
  test("the picture of docs/guide/three.md", async () => {
    const { width, height, data } = await call("drawPicture", "force-webgl", "/clip.fvv");
    const pixels = Buffer.from(data, "base64");
    mkdirSync(screens, { recursive: true });
    writeFileSync(
      join(screens, "three.png"),
      PNG.sync.write(Object.assign(new PNG({ width, height }), { data: pixels })),
    );
    const colours = new Set();
    for (let i = 0; i < pixels.length; i += 4 * 31) colours.add(pixels.readUInt32LE(i));
    assert.ok(colours.size > 1000, `${colours.size} colours`);
    assert.deepEqual(browser.troubles, []);
  });
});
