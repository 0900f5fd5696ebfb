// The tools over the picture, in Chromium: loaded when they are wanted, and used by mouse, by touch and by keys alone. Screenshots are
// kept in FVV_ARTEFACTS (build/screens).

import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { toolsBytes } from "../sizes.mjs";
import { drivePage, openPage } from "./page_driver.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));
const FRAMES = 24;

test("what the attribute loads is 40 kB with brotli at most", async () => {
  const { brotli, scripts } = await toolsBytes();
  assert.ok(scripts.length > 0 && brotli > 2000, "there are tools");
  assert.ok(brotli <= 40000, `${brotli} bytes`);
});

describe("tools", { skip: missingBrowser("chromium") }, () => {
  let folder, opened, browser, page;

  before(async () => {
    mkdirSync(screens, { recursive: true });
    folder = mkdtempSync(join(tmpdir(), "fvv-tools-"));
    const capture = join(folder, "capture");
    const clip = join(folder, "players.fvv");
    tool("fvvsynth", "-o", capture, "--rig", "small", "--cameras", "4", "--frames", `${FRAMES}`, "--size", "240x160");
    tool("fvvmux", capture, "-o", clip, "--group", "8", "--quality", "30", "--objects", "auto");
    opened = await openPage("chromium", clip);
    ({ browser, page } = opened);
    copyFileSync(here("../../node_modules/axe-core/axe.min.js"), join(opened.served.folder, "axe.js"));
    await until(() => window.player.readyState === 4);
    await until(() => window.player.stats.drawnFrames > 0);
  });
  after(async () => {
    assert.deepEqual(browser?.troubles ?? [], []);
    await opened?.close();
    rmSync(folder, { recursive: true, force: true });
  });

  const { ask, until, screen, click, press, still, seekTo, accessibility } = drivePage(() => page, screens, "tools");
  const scripts = () =>
    ask(() => performance.getEntriesByType("resource").filter(({ name }) => name.endsWith(".js")).length);
  const part = (name) => `.tools [part~="${name}"]`;
  /** Begins a tool, also where it is in use. */
  const choose = async (name) => {
    const isPressed = (selector) => window.player.shadowRoot.querySelector(selector).ariaPressed === "true";
    if (await ask(isPressed, part(name))) await page.keyboard.press("Escape");
    await until((selector) => window.player.shadowRoot.querySelector(selector).ariaPressed === "false", part(name));
    await click(part(name));
    await until(isPressed, part(name));
  };
  const measurements = () => ask(() => window.player.measurements);
  const hint = () => ask(() => window.player.shadowRoot.querySelector(".hint").textContent);
  const overlayText = () =>
    ask(() => Array.from(window.player.shadowRoot.querySelectorAll(".scene-marks text"), (node) => node.textContent));
  const removeAll = () =>
    ask(() => {
      for (const button of window.player.shadowRoot.querySelectorAll(".measurements button.icon")) button.click();
    });
  /** Where objects are seen: [{object, x, y, position}], one place each, in pixels of the window. */
  const seen = () =>
    ask(async () => {
      const { player } = window;
      const { left, top } = player.getBoundingClientRect();
      const found = new Map();
      for (let y = 0.06; y < 0.8; y += 0.02)
        for (let x = 0.05; x < 0.6; x += 0.02) {
          const [px, py] = [x * player.clientWidth, y * player.clientHeight];
          const hit = await player.pick(px, py);
          if (hit?.object == null || hit.facing < 0.5) continue;
          const { object, position } = hit;
          found.set(object, [...(found.get(object) ?? []), { object, position, x: left + px, y: top + py }]);
        }
      return Array.from(found.values(), (places) => places[places.length >> 1]);
    });
  const near = (value, expected, within) =>
    assert.ok(Math.abs(value - expected) <= within, `${value}, not ${expected}`);
  const apart = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));

  test("nothing is loaded without the attribute, and one click measures nothing", async () => {
    const former = await scripts();
    assert.equal(await ask(() => window.player.shadowRoot.querySelector(".tools")), null);
    await ask(() => (window.player.tools = "nothing of this"));
    await still();
    assert.equal(await scripts(), former);
    await ask(() => (window.player.tools = "measure"));
    await until(() => window.player.shadowRoot.querySelector(".tools") !== null);
    assert.ok((await scripts()) > former);
    assert.deepEqual(await measurements(), []);
  });

  test("by mouse: the distance of two places, with a label, its uncertainty and a text for screen readers", async () => {
    await seekTo(4);
    await still();
    const [a, b] = await seen();
    assert.ok(b, "two objects are seen");
    await choose("distance");
    await ask(() => window.player.shadowRoot.querySelector(".tool-options input").click()); // places, not centres
    assert.match(await hint(), /first of two places/);
    await page.mouse.click(a.x, a.y);
    assert.match(await hint(), /second place/);
    await page.mouse.move(b.x - 4, b.y);
    await page.mouse.click(b.x, b.y);
    const [{ kind, names, value }] = await measurements();
    assert.deepEqual([kind, names], ["distance", ["place", "place"]]);
    near(value.value, apart(a.position, b.position), 0.02);
    assert.ok(value.uncertainty > 0 && value.uncertainty < 0.2, `${value.uncertainty} m`);
    assert.match(await hint(), /^Distance \d+\.\d+ metres, plus or minus \d/);
    assert.match((await overlayText())[0], /^\d+\.\d+ ± \d+\.\d+ m$/);
    assert.equal(await ask(() => window.player.paused), true, "a click with a tool does not play");
    await screen("distance");
    // The group has the same faces in all frames: places move with the surface. Another group may have others.
    await seekTo(6);
    const [{ value: later, samples }] = await measurements();
    assert.ok(later && later.value > 0 && samples.length === 2);
    await removeAll();
    assert.deepEqual(await measurements(), []);
  });

  test("by touch: two objects over the whole stream, and the graph seeks", async () => {
    await ask(() => window.player.shadowRoot.querySelector(".tool-options input").click());
    await choose("distance");
    await seekTo(10);
    await still();
    const [a, b] = await seen();
    for (const [i, { x, y }] of [a, b].entries()) {
      const former = await hint();
      await page.touchscreen.tap(x, y);
      if (i === 0) assert.match(former, /first of two/);
      await until((former) => window.player.shadowRoot.querySelector(".hint").textContent !== former, former);
    }
    const [{ names, value, samples }] = await measurements();
    assert.ok(names.every((name) => name.startsWith("object ")) && names[0] !== names[1], `${names}`);
    assert.equal(samples.length, FRAMES);
    const now = await ask(() => window.player.currentTime);
    const same = samples.reduce((best, one) =>
      Math.abs(one.seconds - now) < Math.abs(best.seconds - now) ? one : best,
    );
    // What is on screen is of the decoded mesh, and the path of the one before.
    near(value.value, same.value.value, value.uncertainty + same.value.uncertainty);
    await screen("objects");
    const { x, y, width, height } = await ask(() => {
      const { x, y, width, height } = window.player.shadowRoot.querySelector(".graph").getBoundingClientRect();
      return { x, y, width, height };
    });
    await page.mouse.click(x + width * 0.25, y + height / 2);
    await until(() => !window.player.seeking);
    near(await ask(() => window.player.currentFrame), 0.25 * (FRAMES - 1), 1.1);
    await removeAll();
  });

  test("by keys alone: the speed of an object and a height by the cross-hair", async () => {
    await seekTo(12);
    await still();
    const [a] = await seen();
    const box = await ask(() => {
      const { left, top, width, height } = window.player.shadowRoot.querySelector(".surface").getBoundingClientRect();
      return { x: left + width / 2, y: top + height / 2 };
    });
    for (const name of ["speed", "height"]) {
      await ask((name) => window.player.shadowRoot.querySelector(`.tools [part~="${name}"]`).focus(), name);
      await page.keyboard.press("Enter");
      // The cross-hair stays where it was.
      for (const [key, way] of name === "height"
        ? []
        : [
            [a.x < box.x ? "ArrowLeft" : "ArrowRight", Math.abs(a.x - box.x)],
            [a.y < box.y ? "ArrowUp" : "ArrowDown", Math.abs(a.y - box.y)],
          ]) {
        for (let i = 0; i < Math.floor(way / 12); i++) await page.keyboard.press(key);
        await page.keyboard.down("Shift");
        for (let i = 0; i < Math.round(way % 12); i++) await page.keyboard.press(key);
        await page.keyboard.up("Shift");
      }
      if (name === "speed") await screen("keys");
      await page.keyboard.press("Enter");
      assert.match(await hint(), name === "speed" ? /^Speed .* metres per second/ : /^Height .* metres/);
    }
    const [speed, height] = await measurements();
    assert.ok(speed.value.value >= 0 && speed.value.value < 12 && speed.value.uncertainty > 0);
    assert.ok(height.value.value > 0 && height.value.value < 3, `${height.value.value} m`);
    await page.keyboard.press("Escape");
    assert.equal(
      await ask(() => window.player.shadowRoot.querySelector(".tools [aria-pressed=true]")),
      null,
      "Escape ends the tool",
    );
    const orbit = () => ask(() => window.player.cameraOrbit && window.player.getCameraAttributes().cameraOrbit);
    const former = await orbit();
    await press("ArrowLeft");
    await still();
    assert.notEqual(await orbit(), former, "arrows move the viewer again");
  });

  test("has no violations of axe-core, and saves values as CSV", async () => {
    await choose("speed");
    assert.deepEqual(await accessibility(), []);
    const text = await ask(async () => {
      const made = new Promise((done) => {
        const { createObjectURL } = URL;
        URL.createObjectURL = (blob) => {
          URL.createObjectURL = createObjectURL;
          done(blob.text());
          return "data:,";
        };
      });
      window.player.shadowRoot.querySelector(".measurements button.text").click();
      return made;
    });
    const [head, ...rows] = text.trim().split("\r\n");
    assert.equal(head, "seconds,speed,speed uncertainty");
    assert.equal(rows.length, FRAMES);
    await screen("list");
  });

  test("without the attribute all is gone, and clicks play again", async () => {
    await ask(() => window.player.removeAttribute("tools"));
    assert.equal(await ask(() => window.player.shadowRoot.querySelector(".tools, .scene-marks, .cross-hair")), null);
    assert.deepEqual(await measurements(), []);
    await page.mouse.click(200, 200);
    await until(() => !window.player.paused);
    await ask(() => window.player.pause());
  });
});
