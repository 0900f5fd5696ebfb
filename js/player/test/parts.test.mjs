// What the player shows of streams that lack meshes, pictures or a video decoder, and how it behaves as an element of a page:
// focus, touch, previews, another source. In Chromium, with one page for most checks.

import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { drivePage, openPage } from "./page_driver.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));
const FRAMES = 8;

describe("streams without some parts", { skip: missingBrowser("chromium") }, () => {
  let folder, opened, served, browser, page;

  before(async () => {
    mkdirSync(screens, { recursive: true });
    folder = mkdtempSync(join(tmpdir(), "fvv-parts-"));
    const at = (name) => join(folder, name);
    const rig = ["--rig", "small", "--cameras", "5", "--frames", `${FRAMES}`, "--size", "240x160"];
    tool("fvvsynth", "-o", at("capture"), ...rig);
    const mux = (name, ...more) => tool("fvvmux", at("capture"), "-o", name, "--group", "4", ...more);
    mux(at("players.fvv"));
    opened = await openPage("chromium", at("players.fvv"));
    ({ served, browser, page } = opened);
    copyFileSync(here("../../node_modules/axe-core/axe.min.js"), join(served.folder, "axe.js"));
    mux(join(served.folder, "meshes.fvv"), "--no-pictures", "--triangles", "6000");
    mux(join(served.folder, "pictures.fvv"), "--no-meshes");
    mux(join(served.folder, "spread.fvv"), "--video-tracks", "camera");
    mux(join(served.folder, "ladder.fvv"), "--ladder", "1,0.5");
    await until(() => window.player.readyState === 4);
  });
  after(async () => {
    await opened?.close();
    rmSync(folder, { recursive: true, force: true });
  });

  const driver = drivePage(() => page, screens, "parts");
  const { ask, until, screen, boxOf, press, still, seekTo } = driver;
  const load = async (name) => {
    await ask((name) => (window.player.src = `${name}.fvv`), name);
    await until(() => window.player.readyState === 4 && !window.player._stage?.busy);
    await still();
  };
  /** The brightness of the middle of the picture: mean, and standard deviation. */
  const brightness = (on = page) =>
    on.evaluate(() => {
      const { data, width, height } = window.player._stage.renderer.readPixels();
      const values = [];
      for (let y = Math.floor(0.35 * height); y < 0.65 * height; y++)
        for (let x = Math.floor(0.3 * width); x < 0.7 * width; x++) {
          const i = 4 * (y * width + x);
          // The statue is grey, the background bluish.
          if (Math.abs(data[i] - data[i + 2]) < 3) values.push(data[i]);
        }
      const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
      const variance = values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / values.length;
      return { count: values.length, mean, deviation: Math.sqrt(variance) };
    });

  test("the background becomes bluer upwards, and is the page's below", async () => {
    await ask(() => Object.assign(window.player, { grid: false, src: "players.fvv" }));
    await ask(() => window.player.setPose({ eye: [0, 30, 0], target: [3, 30, 0] }));
    await still();
    const { above, below } = await ask(() => {
      const { data, width } = window.player._stage.renderer.readPixels();
      return { above: Array.from(data.subarray(4 * width, 4 * width + 3)), below: Array.from(data.subarray(-4, -1)) };
    });
    [238, 240, 243].forEach((value, i) => assert.ok(Math.abs(below[i] - value) <= 1, `${below} below`));
    assert.ok(above[2] - above[0] > below[2] - below[0] + 4, `${above} above`);
    await ask(() => (window.player.grid = true));
  });

  test("another rung is drawn at once while paused", async () => {
    const covered = () => window.player.shadowRoot.querySelector(".surface").classList.contains("covered");
    // The first frame comes in the lower rung. What is covered is no current data: both at one moment, as it does not last.
    const seen = ask(
      () =>
        new Promise((resolve) => {
          const { classList } = window.player.shadowRoot.querySelector(".surface");
          const observer = new MutationObserver(() => {
            if (!classList.contains("covered")) return;
            observer.disconnect();
            resolve(window.player.readyState);
          });
          observer.observe(window.player.shadowRoot, { attributes: true, attributeFilter: ["class"], subtree: true });
          window.player.src = "ladder.fvv";
          setTimeout(() => resolve("the first frame was never covered"), 20_000);
        }),
    );
    assert.equal(await seen, 1);
    await until(() => window.player.readyState === 4);
    assert.equal(await ask(covered), false);
    const isHidden = (part) => ask((part) => window.player.shadowRoot.querySelector(part).hidden, part);
    assert.deepEqual([await isHidden("[part~=big-play]"), await isHidden(".spinner")], [false, true]);
    await seekTo(5);
    // What the network carries is measured, so that "auto" depends on the machine: media.test.mjs tests it.
    for (const rung of [1, 0, 1]) {
      await ask((rung) => (window.player.rung = rung), rung);
      await until((rung) => window.player.playedRung === rung && !window.player._stage.busy, rung);
      assert.deepEqual(await ask(() => [window.player.currentFrame, window.player.paused]), [5, true]);
    }
    await ask(() => (window.player.rung = "auto"));
    await load("players");
  });

  test("of several tracks only those are fetched that the viewer needs, also after a jump while paused", async () => {
    await load("spread");
    await seekTo(5);
    const tiles = () => ask(() => window.player._stage.renderer.tiles.map(({ camera }) => camera.id).join());
    await until(() => window.player._stage.renderer.tiles.length < 5);
    const former = await tiles();
    await ask(() => {
      const { eye, target, ...pose } = window.player.getPose();
      const opposite = [2 * target[0] - eye[0], eye[1], 2 * target[2] - eye[2]];
      window.player.setPose({ ...pose, target, eye: opposite });
    });
    const others = (former) => {
      const shown = window.player._stage.renderer.tiles.map(({ camera }) => camera.id);
      return shown.length < 5 && shown.join() !== former;
    };
    await until(others, former);
    assert.deepEqual(await ask(() => [window.player.currentFrame, window.player.paused]), [5, true]);
    await ask(() => (window.player.showCameras = "sheet"));
    await until(() => window.player._stage.renderer.tiles.length === 5);
    await ask(() => (window.player.showCameras = null));
    await load("players");
  });

  test("pick loads its module once, and finds what is under the mouse", async () => {
    await load("players");
    await ask(() => window.player.resetView());
    await still();
    const found = await ask(async () => {
      const { player } = window;
      const early = await document.createElement("fvv-player").pick(10, 10);
      const scripts = () => performance.getEntriesByType("resource").filter(({ name }) => name.endsWith(".js")).length;
      const before = scripts();
      const corner = await player.pick(0, 0);
      const loaded = scripts() - before;
      const hits = [];
      for (let y = 0.05; y < 1; y += 0.05)
        for (let x = 0.05; x < 1; x += 0.05) {
          const hit = await player.pick(x * player.clientWidth, y * player.clientHeight);
          if (hit) hits.push({ ...hit, time: String(hit.time) });
        }
      const [{ position }] = hits;
      const { eye } = player.getPose();
      const again = await player.pick({ origin: eye, direction: position.map((x, k) => x - eye[k]) });
      const wrong = await player.pick("left").catch(({ message }) => message);
      const more = scripts() - before;
      return { early, loaded, more, corner, wrong, hits, eye, again: again.position, frame: player.currentFrame };
    });
    assert.deepEqual([found.early, found.corner], [null, null]);
    // The module, and what it shares with the tools.
    assert.ok(found.loaded >= 1 && found.loaded <= 2, `${found.loaded} scripts`);
    assert.equal(found.more, found.loaded);
    assert.match(found.wrong, /pick: expected x and y, or a ray/);
    assert.ok(found.hits.length >= 8 && found.hits.length < 200, `${found.hits.length} hits`);
    for (const { frame, position, distance, normal } of found.hits) {
      assert.equal(frame, found.frame);
      const towards = position.map((x, k) => x - found.eye[k]);
      assert.ok(Math.abs(Math.hypot(...towards) - distance) < 1e-6);
      assert.ok(normal.reduce((sum, x, k) => sum + x * towards[k], 0) < 0, "the surface that is seen faces the viewer");
    }
    assert.ok(found.hits.filter(({ camera }) => camera !== null).length > found.hits.length / 2);
    assert.ok(found.again.every((x, k) => Math.abs(x - found.hits[0].position[k]) < 1e-6));
  });

  test("focus() gives the keys to the player", async () => {
    await seekTo(2);
    await ask(() => document.getElementById("name").focus());
    await ask(() => window.player.focus());
    assert.equal(await ask(() => document.activeElement === window.player), true);
    await page.keyboard.press(".");
    await until(() => window.player.currentFrame === 3 && !window.player.seeking);
  });

  test("the big button is gone once the viewer has stepped, moved or chosen a view", async () => {
    const shown = () => ask(() => !window.player.shadowRoot.querySelector("[part~=big-play]").hidden);
    const reload = async () => {
      await ask(() => window.player.load());
      await until(() => window.player.readyState === 4);
      assert.equal(await shown(), true);
    };
    await reload();
    await press("ArrowLeft");
    await still();
    assert.equal(await shown(), false);
    await reload();
    await press(".");
    await until(() => window.player.currentFrame === 1 && !window.player.seeking);
    assert.equal(await shown(), false);
    await reload();
    await ask(() => window.player.play());
    await ask(() => window.player.pause());
    assert.equal(await shown(), false);
  });

  test("the slider shows groups, and the time, frame and picture under the mouse", async () => {
    await load("players");
    for (let frame = 0; frame < FRAMES; frame += 2) {
      await seekTo(frame);
      await still();
      await new Promise((done) => setTimeout(done, 450));
    }
    const { x, y, width, height } = await boxOf(".scrubber input");
    await page.mouse.move(x + 8 + ((width - 16) * 2.5) / FRAMES, y + height / 2);
    await until(() => !window.player.shadowRoot.querySelector(".tip").hidden);
    const found = await ask(() => {
      const { shadowRoot } = window.player;
      const canvas = shadowRoot.querySelector(".preview canvas");
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return {
        marks: [...shadowRoot.querySelectorAll(".marks i")].map((mark) => mark.style.getPropertyValue("--at")),
        text: shadowRoot.querySelector(".tip output").textContent,
        colours: new Set(new Uint32Array(data.buffer)).size,
      };
    });
    assert.deepEqual(found.marks, ["0.5"]);
    assert.match(found.text, /^0:00\.\d\d, frame 2$/);
    assert.ok(found.colours > 100, `${found.colours} colours`);
    await screen("preview");
    await page.mouse.move(x, y - 100);
  });

  test("another source resets the view, the loop and the choice of cameras", async () => {
    await press("3");
    await until(() => window.player.camera !== null && !window.player._stage?.busy);
    await ask(() => Object.assign(window.player, { colourCameras: [1], selectedCamera: 2 }));
    await load("meshes");
    const state = await ask(() => {
      const { camera, colourCameras, selectedCamera, loopRange } = window.player;
      return { camera, colourCameras, selectedCamera, loopRange };
    });
    assert.deepEqual(state, { camera: null, colourCameras: null, selectedCamera: null, loopRange: null });
    const { eye } = await ask(() => window.player.getPose());
    await ask(() => window.player.resetView());
    await still();
    const home = await ask(() => window.player.getPose());
    eye.forEach((value, i) => assert.ok(Math.abs(value - home.eye[i]) < 1e-6, `${eye}`));
  });

  test("a mesh without pictures is shaded with light", async () => {
    await load("meshes");
    const { count, mean, deviation } = await brightness();
    assert.ok(count > 2000 && deviation > 12, `${count} pixels of ${mean} +- ${deviation}`);
    await screen("meshes");
  });

  test("pictures without a mesh are shown on a contact sheet, and each in the whole view", async () => {
    await load("pictures");
    assert.equal(await ask(() => window.player.showCameras), "sheet");
    const cells = await ask(() => window.player.contactSheet);
    assert.deepEqual(
      cells.map(({ camera }) => camera),
      [0, 1, 2, 3, 4],
    );
    for (const [i, { x, y, width, height }] of cells.entries()) {
      assert.ok(x > 0 && y > 0 && x + width < 1 && y + height < 1, JSON.stringify(cells[i]));
      for (const other of cells.slice(0, i))
        assert.ok(x >= other.x + other.width || y >= other.y + other.height, "cells overlap");
    }
    // Each cell has a picture, with the colours of the players.
    const colours = await ask((cells) => {
      const { data, width, height } = window.player._stage.renderer.readPixels();
      return cells.map((cell) => {
        const seen = new Set();
        for (let y = Math.ceil(cell.y * height); y < (cell.y + cell.height) * height; y++)
          for (let x = Math.ceil(cell.x * width); x < (cell.x + cell.width) * width; x++) {
            const i = 4 * (y * width + x);
            seen.add((data[i] >> 3) * 1024 + (data[i + 1] >> 3) * 32 + (data[i + 2] >> 3));
          }
        return seen.size;
      });
    }, cells);
    assert.ok(
      colours.every((count) => count > 30),
      `${colours} colours`,
    );
    await screen("sheet");
    assert.deepEqual(await driver.accessibility(), []);
    assert.deepEqual(await ask(() => window.player.shadowRoot.querySelectorAll(".sheet button").length), 5);
    const { x, y, width, height } = await boxOf(".sheet button:nth-child(3)");
    await page.mouse.click(x + width / 2, y + height / 2);
    await still();
    assert.deepEqual(await ask(() => [window.player.camera, window.player.showCameras]), [2, "pictures"]);
    // The tile is where the camera has it: its height in the view is that of the camera's picture.
    await screen("snapped");
    assert.ok((await driver.colourful()) > 0.02);
    await ask(() => window.player.setPose({ eye: [9, 6, 9], target: [0, 1, 0] }));
    await still();
    await screen("planes");
    assert.ok((await driver.colourful()) > 0.002);
    await press("m");
    assert.equal(await ask(() => window.player.showCameras), "sheet");
    await load("players");
    assert.equal(await ask(() => window.player.showCameras), "sheet", "the explicit choice stays");
    await ask(() => (window.player.showCameras = null));
    assert.equal(await ask(() => window.player.showCameras), "none");
  });

  test("a finger scrolls the page, and rotates sideways", async () => {
    const phone = await browser.newPage("about:blank", 390, 600);
    await phone.setViewport({ width: 390, height: 600, hasTouch: true, isMobile: true });
    await phone.goto(`${served.url}page.html`);
    await phone.waitForFunction(() => window.player?.readyState === 4 && !window.player._stage?.busy);
    await phone.evaluate(() => {
      document.querySelector("main").append(Object.assign(document.createElement("div"), { className: "tall" }));
    });
    const swipe = async (dx, dy) => {
      const finger = await phone.touchscreen.touchStart(195, 200);
      for (let i = 1; i <= 6; i++) await finger.move(195 + (i * dx) / 6, 200 + (i * dy) / 6);
      await finger.end();
    };
    const orbit = () => phone.evaluate(() => parseFloat(window.player.getCameraAttributes().cameraOrbit));
    const before = await orbit();
    await swipe(0, -90);
    assert.ok((await phone.evaluate(() => scrollY)) > 40, "the page did not scroll");
    await phone.evaluate(() => scrollTo(0, 0));
    await phone.waitForFunction(() => !window.player._stage?.busy);
    assert.ok(Math.abs((await orbit()) - before) < 3, "the scene turned");
    await swipe(-90, 0);
    await phone.waitForFunction(() => !window.player._stage?.busy);
    assert.ok(Math.abs((await orbit()) - before) > 10, "the scene did not turn");
    // The compositor, which scrolls, knows the attribute with the frame after the next.
    await phone.evaluate(async () => {
      window.player.setAttribute("touch-action", "none");
      for (let i = 0; i < 2; i++) await new Promise(requestAnimationFrame);
    });
    await swipe(0, -90);
    assert.equal(await phone.evaluate(() => scrollY), 0);
    await phone.close();
  });

  test("a decoder of video that fails at its first picture gives a notice, and no spinner", async () => {
    const other = await browser.newPage("about:blank", 720, 560);
    await other.evaluateOnNewDocument(() => {
      const Real = window.VideoDecoder;
      window.VideoDecoder = class extends Real {
        #error;
        constructor(init) {
          super(init);
          this.#error = init.error;
        }
        decode() {
          queueMicrotask(() => {
            if (this.state === "closed") return;
            this.close();
            this.#error(new DOMException("Decoding error.", "EncodingError"));
          });
        }
      };
    });
    await other.goto(`${served.url}page.html`);
    await other.evaluate(() => {
      window.player.worker = "none";
      window.player.load();
    });
    await other.waitForFunction(() => window.player.readyState === 4 && window.player.unsupportedCodecs.length > 0);
    await new Promise((resolve) => setTimeout(resolve, 1000));
    const shown = await other.evaluate(() => {
      const [spinner, notice] = [".spinner", ".missing"].map((name) => window.player.shadowRoot.querySelector(name));
      return { spins: !spinner.hidden, text: notice.hidden ? "" : notice.textContent, error: window.player.error };
    });
    assert.deepEqual([shown.spins, shown.error], [false, null]);
    assert.match(shown.text, /No pictures: this browser does not decode H\.264/);
    await other.close();
  });

  test("without a decoder for the video the mesh is shown in colours of its vertices, with a notice of what would help", async () => {
    const other = await browser.newPage("about:blank", 720, 560);
    await other.evaluateOnNewDocument(() => delete window.VideoDecoder);
    await other.goto(`${served.url}page.html`);
    await other.evaluate(() => {
      window.player.worker = "none"; // Workers have a VideoDecoder of their own.
      window.player.load();
    });
    await other.waitForFunction(() => window.player.readyState === 4 && window.player.unsupportedCodecs.length > 0);
    await other.waitForFunction(() => !window.player._stage?.busy);
    await other.addScriptTag({ url: "axe.js" });
    const violations = await other.evaluate(async () => (await window.axe.run(document)).violations);
    assert.deepEqual(
      violations.map(({ id }) => id),
      [],
    );
    const { text, codecs } = await other.evaluate(() => {
      const notice = window.player.shadowRoot.querySelector(".missing");
      return { text: notice.hidden ? "" : notice.textContent, codecs: window.player.unsupportedCodecs };
    });
    assert.deepEqual(codecs, ["avc1"]);
    assert.match(text, /does not decode H\.264.*Firefox.*@fvv\/video-fallback/);
    // The mesh has the colours of its vertices: skin, a red and a blue shirt; the background is bluish.
    const coloured = await other.evaluate(() => {
      const { data } = window.player._stage.renderer.readPixels();
      let count = 0;
      for (let i = 0; i < data.length; i += 4) count += data[i] - data[i + 2] > 40 ? 1 : 0;
      return count;
    });
    assert.ok(coloured > 1000, `${coloured} pixels with colours`);
    await other.screenshot({ path: join(screens, "player-parts-no-decoder.png") });
    await other.evaluate(() => window.player.shadowRoot.querySelector(".missing button").click());
    assert.equal(await other.evaluate(() => window.player.shadowRoot.querySelector(".missing").hidden), true);
    await other.close();
  });

  test("no errors", () => assert.deepEqual(browser.troubles, []));
});
