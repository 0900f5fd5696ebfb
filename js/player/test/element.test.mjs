// The element in Chromium and Firefox, operated by mouse, touch and keys. Screenshots are kept in FVV_ARTEFACTS
// (build/screens).

import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, mkdtempSync, renameSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { drivePage, openPage } from "./page_driver.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));
const FRAMES = 24;
const DURATION = FRAMES / 25;

const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

/** A small clip with camera and frame numbers in its pictures. */
function makeClip(folder) {
  const capture = join(folder, "capture");
  const rig = ["--rig", "small", "--cameras", "4", "--frames", `${FRAMES}`, "--size", "240x160"];
  tool("fvvsynth", "-o", capture, ...rig, "--frame-numbers");
  tool("fvvmux", capture, "-o", join(folder, "players.fvv"), "--group", "8", "--quality", "30", "--triangles", "6000");
  tool("fvvmux", capture, "-o", join(folder, "ladder.fvv"), "--group", "8", "--quality", "30", "--ladder", "1,0.5");
}

let folder;
before(async () => {
  mkdirSync(screens, { recursive: true });
  folder = mkdtempSync(join(tmpdir(), "fvv-clip-"));
  makeClip(folder);
});
after(() => rmSync(folder, { recursive: true, force: true }));

for (const name of ["chromium", "firefox"])
  describe(name, { skip: missingBrowser(name) }, () => {
    let opened, served, browser, page;

    before(async () => {
      opened = await openPage(name, join(folder, "players.fvv"));
      ({ served, browser, page } = opened);
      copyFileSync(here("../../node_modules/axe-core/axe.min.js"), join(served.folder, "axe.js"));
    });
    after(() => opened?.close());

    const driver = drivePage(() => page, screens, name);
    const { ask, until, events, screen, boxOf, click, control, press, colourful, orbit, still, seekTo } = driver;

    // The end of the last frame, start + duration, may differ in the last bit.
    const assertWholeBuffered = async () => {
      const end = await ask(() => window.player.buffered.end(0));
      assert.ok(Math.abs(end - DURATION) < 1e-9, `buffered up to ${end} s`);
    };

    test("loads, dispatches events in order, and shows the first frame", async () => {
      await until(() => window.player.readyState === 4);
      assert.deepEqual(await events(), [
        "loadstart",
        "durationchange",
        "loadedmetadata",
        "loadeddata",
        "canplay",
        "canplaythrough",
      ]);
      assert.ok(Math.abs((await ask(() => window.player.duration)) - DURATION) < 1e-6);
      await until(() => window.player.stats.drawnFrames > 0);
      const share = await colourful();
      assert.ok(share > 0.02 && share < 0.6, `${share} of the picture is coloured`);
      await screen("first");
    });

    test("plays, pauses, and then does nothing", async () => {
      await ask(() => (window.player.playbackRate = 0.25));
      await click(control("play"));
      await until(() => window.player.currentTime > 0.15);
      await click(control("play"));
      assert.deepEqual(await events(), ["ratechange", "play", "playing", "pause"]);
      await wait(400);
      await until(() => !window.player._stage.busy);
      const now = () =>
        ask(() => [window.player.currentTime, window.player.stats.drawnFrames, window.player.stats.contentFrames]);
      const before = await now();
      await wait(400);
      assert.deepEqual(await now(), before);
      assert.ok((await ask(() => window.player.stats.openVideoFrames)) <= 4);
    });

    test("plays to the end, and again from the beginning", async () => {
      await ask(() => (window.player.playbackRate = 4));
      await click(control("play"));
      await until(() => window.player.ended);
      assert.deepEqual((await events()).slice(-2), ["pause", "ended"]);
      await ask(() => (window.player.playbackRate = 0.25));
      await click(control("play"));
      await until(() => !window.player.seeking && window.player.readyState === 4);
      assert.ok((await ask(() => window.player.currentTime)) < 0.5 * DURATION);
      assert.ok((await events()).includes("seeked"));
      await ask(() => window.player.pause());
    });

    test("steps frame by frame, by button and by key", async () => {
      await seekTo(10);
      await events();
      await click(control("step-forward"));
      await until(() => window.player.currentFrame === 11);
      await press(".");
      await until(() => window.player.currentFrame === 12);
      await click(control("step-back"));
      await until(() => window.player.currentFrame === 11);
      await press(",");
      await until(() => window.player.currentFrame === 10 && !window.player.seeking);
      assert.ok(Math.abs((await ask(() => window.player.currentTime)) - 0.4) < 1e-6);
      const seeks = (await events()).filter((type) => /^seek/.test(type));
      assert.deepEqual(seeks, Array(4).fill(["seeking", "seeked"]).flat());
    });

    test("scrubs with the mouse and with keys", async () => {
      const { x, y, width, height } = await boxOf(".scrubber input");
      await page.mouse.move(x + 0.2 * width, y + height / 2);
      await page.mouse.down();
      await page.mouse.move(x + 0.5 * width, y + height / 2, { steps: 5 });
      await page.mouse.up();
      await until(() => !window.player.seeking);
      const time = await ask(() => window.player.currentTime);
      assert.ok(Math.abs(time - DURATION / 2) < 0.05, `${time} s`);
      assert.equal(await ask(() => window.player.currentFrame), Math.floor(time * 25 + 1e-6));
      await press("Home");
      await until(() => !window.player.seeking && window.player.currentFrame === 0);
      await press("End");
      await until((last) => !window.player.seeking && window.player.currentFrame === last, FRAMES - 1);
    });

    test("loops over a range", async () => {
      await seekTo(4);
      await press("i");
      await seekTo(10);
      await press("o");
      const range = await ask(() => window.player.loopRange);
      assert.ok(Math.abs(range.from - 0.16) < 1e-6 && Math.abs(range.to - 0.4) < 1e-6, JSON.stringify(range));
      await ask(() => {
        window.player.currentTime = 0.16;
        window.player.playbackRate = 1;
        window.times = [];
        window.player.addEventListener("framechange", () => window.times.push(window.player.currentFrame));
      });
      await events();
      await press("k");
      await until(() => window.times.filter((frame, i, all) => i && frame < all[i - 1]).length >= 2);
      await press("k");
      const frames = await ask(() => window.times);
      assert.ok(
        frames.every((frame) => frame >= 4 && frame < 10),
        `${frames}`,
      );
      assert.ok(!(await events()).includes("ended"));
      await screen("loop");
      await press("u");
      assert.equal(await ask(() => window.player.loopRange), null);
    });

    test("moves by mouse, wheel and keys while paused", async () => {
      await seekTo(12);
      const { x, y, width, height } = await boxOf(".surface");
      const [theta, phi, radius] = await orbit();
      await page.mouse.move(x + width / 2, y + height / 3);
      await page.mouse.down();
      await page.mouse.move(x + width / 2 + 0.25 * height, y + height / 3, { steps: 4 });
      await page.mouse.up();
      await still();
      const turned = await orbit();
      assert.ok(Math.abs(turned[0] - theta + 45) < 2, `${theta} to ${turned[0]} degrees`);
      assert.ok(Math.abs(turned[1] - phi) < 1);
      await page.mouse.wheel({ deltaY: -300 });
      await still();
      assert.ok((await orbit())[2] < 0.8 * radius);
      await press("ArrowRight");
      await still();
      assert.ok((await orbit())[0] > turned[0] + 3);
      await press("KeyW");
      await still();
      assert.equal(await ask(() => window.player.currentFrame), 12);
      assert.ok((await colourful()) > 0.02);
      await screen("turned");
      await press("r");
      await still();
      assert.ok(Math.abs((await orbit())[0] - theta) < 0.1);
    });

    test("rotates by one finger, zooms by two", async () => {
      const { x, y, width, height } = await boxOf(".surface");
      const [cx, cy] = [x + width / 2, y + height / 3];
      const before = await orbit();
      const finger = await page.touchscreen.touchStart(cx, cy);
      for (let i = 1; i <= 4; i++) await finger.move(cx - 20 * i, cy);
      await finger.end();
      await still();
      const turned = await orbit();
      assert.ok(turned[0] > before[0] + 10, `${before[0]} to ${turned[0]} degrees`);
      const left = await page.touchscreen.touchStart(cx - 30, cy);
      const right = await page.touchscreen.touchStart(cx + 30, cy);
      for (let i = 1; i <= 4; i++) {
        await left.move(cx - 30 - 10 * i, cy);
        await right.move(cx + 30 + 10 * i, cy);
      }
      await left.end();
      await right.end();
      await still();
      const nearer = await orbit();
      assert.ok(nearer[2] < 0.6 * turned[2], `${turned[2]} to ${nearer[2]} m`);
    });

    test("the view of a camera is exact", async () => {
      await press("2");
      await until(() => window.player.camera !== null && !window.player._stage?.busy);
      const { pose, camera } = await ask(() => {
        const { id, centre, rotation } = window.player.cameras[1];
        return { pose: window.player.getPose(), camera: { id, centre, rotation } };
      });
      pose.eye.forEach((x, i) => assert.ok(Math.abs(x - camera.centre[i]) < 1e-9));
      assert.equal(await ask(() => window.player.camera), camera.id);
      await screen("camera");
      await press("0");
      await until(() => window.player.camera === null && !window.player._stage?.busy);
    });

    test("cameras can be switched off, and shown in the scene", async () => {
      // Without cameras the mesh would have the colours of its vertices.
      await ask(() => (window.player.unseen = 0x808080));
      const whole = await colourful();
      await click(control("cameras"));
      await until(() => !window.player.shadowRoot.querySelector(".panel.cameras").hidden);
      const ids = await ask(() => window.player.cameras.map(({ id }) => id));
      for (let i = 1; i <= ids.length; i++) await click(`.cameras li:nth-child(${i}) .switch input`);
      assert.deepEqual(await ask(() => window.player.colourCameras), []);
      await until(() => !window.player._stage?.busy);
      assert.ok((await colourful()) < whole / 20);
      await ask(() => {
        window.player.unseen = null;
        window.player.colourCameras = null;
        window.player.showCameras = "pictures";
        window.player.setPose({ eye: [7, 5, 9], target: [0, 1, 0] });
      });
      await still();
      await screen("cameras");
      await page.keyboard.press("Escape");
      assert.ok(await ask(() => window.player.shadowRoot.querySelector(".panel.cameras").hidden));
      await ask(() => {
        window.player.showCameras = "none";
        return window.player.resetView();
      });
    });

    test("pixel-ratio and degrees; former attributes and units give a warning", async () => {
      const found = await ask(async () => {
        const { player } = window;
        const texts = [];
        const { warn } = console;
        console.warn = (text) => texts.push(text);
        player.pixelRatio = 0.25;
        const ratios = [player.pixelRatio, player.getAttribute("pixel-ratio")];
        player.removeAttribute("pixel-ratio");
        player.setAttribute("quality", "low");
        ratios.push(player.pixelRatio);
        player.removeAttribute("quality");
        ratios.push(player.pixelRatio);
        await player.setPose({ fov: 60 });
        const fields = [player.getPose().fov];
        await player.setPose({ fov: 0.7 });
        fields.push(player.getPose().fov);
        await player.resetView();
        console.warn = warn;
        return { ratios, texts, fields };
      });
      assert.deepEqual(found.ratios, [0.25, "0.25", 0.5, "auto"]);
      assert.match(found.texts[0], /quality is now pixel-ratio/);
      assert.match(found.texts[1], /fov is in degrees/);
      assert.equal(found.texts.length, 2);
      assert.deepEqual(
        found.fields.map((fov) => Number(fov.toFixed(6))),
        [60, 0.7],
      );
      await ask(() => (window.player.pixelRatio = 0.5));
      await until(() => {
        const canvas = window.player.shadowRoot.querySelector("canvas");
        return canvas.width === Math.max(1, Math.round(canvas.clientWidth * Math.min(devicePixelRatio, 0.5)));
      });
      await ask(() => window.player.removeAttribute("pixel-ratio"));
    });

    test("view modes differ", async () => {
      const seen = new Set();
      for (const mode of ["textured", "weights", "visibility", "wireframe", "normals", "depth"]) {
        await ask((mode) => (window.player.viewMode = mode), mode);
        await still();
        await wait(100);
        seen.add(
          await ask(() => {
            let sum = 0;
            for (const [i, byte] of window.player._stage.renderer.readPixels().data.entries())
              sum = (sum * 31 + byte * (i % 7)) % 1e9;
            return sum;
          }),
        );
      }
      assert.equal(seen.size, 6);
      await ask(() => (window.player.viewMode = "textured"));
    });

    test("keys that are typed into other elements have no effect", async () => {
      await page.focus("#name");
      await page.keyboard.type("kf v.2");
      assert.equal(await ask(() => document.getElementById("name").value), "kf v.2");
      assert.deepEqual(await ask(() => [window.player.paused, window.player.viewMode, window.player.camera]), [
        true,
        "textured",
        null,
      ]);
    });

    test("a bookmark restores the time and the view", async () => {
      await seekTo(15);
      await ask(() => window.player.setPose({ eye: [3, 2, 4], target: [0, 1, 0] }));
      await still();
      const { url, pose } = await ask(async () => ({
        url: await window.player.copyBookmark(),
        pose: window.player.getPose(),
      }));
      assert.ok(url.includes("#fvv=t:0.6;eye:3,2,4"), url);
      await page.reload();
      await until(() => window.player?.readyState === 4 && !window.player._stage?.busy);
      assert.equal(await ask(() => window.player.currentFrame), 15);
      const again = await ask(() => window.player.getPose());
      again.eye.forEach((x, i) => assert.ok(Math.abs(x - pose.eye[i]) < 2e-3, `${again.eye}`));
      await ask(() => history.replaceState(null, "", "#"));
    });

    const looks = [
      ["light", {}, 900, 640],
      ["dark", { theme: "dark" }, 900, 640],
      ["phone", {}, 360, 640],
      ["phone-dark", { theme: "dark" }, 360, 640],
      ["phone-across", {}, 720, 360],
    ];
    for (const [what, attributes, width, height] of looks)
      test(`accessibility: ${what}`, async () => {
        await page.setViewport({ width, height });
        await ask((theme) => window.player.setAttribute("theme", theme), attributes.theme ?? "light");
        await ask(() => window.player.resetView());
        await still();
        await wait(250);
        assert.deepEqual(await driver.accessibility(), []);
        await screen(what);
        for (const panel of ["settings", "cameras", "help"]) {
          if (panel === "help") await press("h");
          else await click(control(panel));
          await until((panel) => !window.player.shadowRoot.querySelector(`.panel.${panel}`).hidden, panel);
          await wait(150);
          assert.deepEqual(await driver.accessibility(), [], panel);
          await screen(`${what}-${panel}`);
          await page.keyboard.press("Escape");
        }
        const small = await ask(() =>
          [...window.player.shadowRoot.querySelectorAll("button, select, .switch, .chip")]
            .map((node) => ({ name: node.ariaLabel || node.textContent, ...node.getBoundingClientRect().toJSON() }))
            .filter(({ width, height }) => width > 0 && (height < 40 || width < 40))
            .map(({ name }) => name),
        );
        assert.deepEqual(small, []);
        const beyond = await ask(() => {
          const right = window.player.getBoundingClientRect().right;
          return [...window.player.shadowRoot.querySelectorAll(".bar *")]
            .filter((node) => {
              const box = node.getBoundingClientRect();
              return box.width > 0 && box.right > right + 0.5;
            })
            .map((node) => `${node.localName}.${node.className}`);
        });
        assert.deepEqual(beyond, []);
        if (what.startsWith("phone")) {
          const covered = await ask(() => {
            const [bar, all] = [window.player.shadowRoot.querySelector(".bar"), window.player].map((node) => {
              const { width, height } = node.getBoundingClientRect();
              return width * height;
            });
            return bar / all;
          });
          assert.ok(covered > 0.02 && covered <= 0.12, `controls cover ${(100 * covered).toFixed(1)} % of the picture`);
        }
      });

    test("the settings offer a download, and controlslist leaves controls out", async () => {
      await page.setViewport({ width: 720, height: 560 });
      const offered = () =>
        ask(() => {
          const buttons = [...window.player.shadowRoot.querySelectorAll(".panel.settings button")];
          const { hidden } = buttons.find(({ textContent }) => textContent === "Download");
          return [!hidden, !window.player.shadowRoot.querySelector('.bar [part~="fullscreen"]').hidden];
        });
      await click(control("settings"));
      await until(() => !window.player.shadowRoot.querySelector(".panel.settings").hidden);
      assert.deepEqual(await offered(), [true, true]);
      const link = await ask(() => {
        let clicked;
        const { click } = HTMLAnchorElement.prototype;
        HTMLAnchorElement.prototype.click = function () {
          clicked = [new URL(this.href).pathname, this.download];
        };
        window.player.download();
        HTMLAnchorElement.prototype.click = click;
        return clicked;
      });
      assert.deepEqual(link, ["/players.fvv", "players.fvv"]);
      await ask(() => (window.player.controlsList = "nodownload noFullscreen"));
      await wait(150);
      assert.deepEqual(await offered(), [false, false]);
      await ask(() => window.player.removeAttribute("controlslist"));
      await page.keyboard.press("Escape");
    });

    test("loops of buffered frames make no requests, and the bar shows the buffered range", async () => {
      const clip = join(served.folder, "players.fvv");
      await ask(() => {
        window.player.load();
        Object.assign(window.player, { loop: true, playbackRate: 4 });
      });
      await until(() => window.player.readyState === 4);
      await ask(() => {
        window.loops = 0;
        window.player.addEventListener("seeked", () => window.loops++);
        window.player.play();
      });
      await until(() => window.loops >= 1);
      // From here on nothing can be fetched.
      renameSync(clip, `${clip}.away`);
      try {
        await until(() => window.loops >= 4);
        await until(() => window.player.buffered.length === 1 && window.player.currentTime > 0);
        assert.deepEqual(await ask(() => [window.player.error, window.player.buffered.start(0)]), [null, 0]);
        await assertWholeBuffered();
        await ask(() => (window.player.currentFrame = 3));
        await until(() => window.player.currentFrame >= 3 && !window.player.seeking);
        const bars = await ask(() =>
          [...window.player.shadowRoot.querySelectorAll("[part=buffered]")].map(({ style }) => [
            Number(style.getPropertyValue("--from")),
            Number(style.getPropertyValue("--to")),
          ]),
        );
        assert.deepEqual(bars, [[0, 1]]);
      } finally {
        renameSync(`${clip}.away`, clip);
      }
      await ask(() => {
        window.player.pause();
        Object.assign(window.player, { loop: false, playbackRate: 1 });
      });
    });

    test("reports an error of a source, and accepts another one", async () => {
      await page.setViewport({ width: 720, height: 560 });
      await events();
      await ask(() => (window.moves = [window.player.getPose().fov]));
      await ask(() => {
        window.player.src = "absent.fvv";
        window.player.snapToCamera(1).then((reached) => (window.moves[0] = reached));
      });
      await until(() => window.player.error !== null);
      assert.deepEqual(await events(), ["abort", "emptied", "loadstart", "error"]);
      assert.equal(await ask(() => window.player.error.code), 4);
      assert.match(await ask(() => window.player.error.message), /\/absent\.fvv: HTTP status 404, .*check the address/);
      assert.equal(await ask(() => window.moves[0]), false);
      await screen("error");
      // The browser reports the missing file.
      assert.equal(browser.troubles.filter((text) => !/404|absent/.test(text)).length, 0, `${browser.troubles}`);
      browser.troubles.splice(0);
      await ask(async () => {
        window.player.srcObject = await (await fetch("players.fvv")).blob();
        window.player.currentTime = 0.5;
        const snap = window.player.snapToCamera(2);
        const bad = window.player.snapToCamera(99).catch((error) => error.name);
        window.moves = await Promise.all([snap, bad]);
      });
      assert.deepEqual(await ask(() => window.moves), [true, "RangeError"]);
      assert.deepEqual(await ask(() => [window.player.camera, window.player.currentTime >= 0.5]), [2, true]);
      await until(() => window.player.readyState === 4);
      await until(() => window.player.buffered.length === 1 && window.player.buffered.end(0) > 0.9);
      await assertWholeBuffered();
    });

    test("plays the rung of a ladder that is wanted, and lists all in the settings", async () => {
      copyFileSync(join(folder, "ladder.fvv"), join(served.folder, "ladder.fvv"));
      await ask(() => {
        window.changes = [];
        window.player.addEventListener("rungchange", ({ detail }) => window.changes.push(detail.rung));
        window.player.srcObject = null;
        window.player.src = "ladder.fvv";
      });
      await until(() => window.player.readyState === 4 && window.player.playedRung !== null);
      const texts = () =>
        ask(() => {
          const selects = [...window.player.shadowRoot.querySelectorAll("select")];
          const rungs = selects.find(({ options }) => options.length === 3 && options[0].value === "auto");
          return Array.from(rungs.options, ({ text }) => text);
        });
      await click(control("settings"));
      assert.match((await texts()).join("; "), /^Automatic \((100|50) %, .*; 100 %, .*bit\/s; 50 %, .*bit\/s$/);
      await press("Escape");
      for (const rung of [0, 1]) {
        await ask((wanted) => (window.player.rung = wanted), rung);
        await seekTo(rung ? 20 : 10);
        await until((wanted) => window.player.playedRung === wanted, rung);
        // Few pixels of a coarse rung are strongly coloured, and none without pictures.
        assert.ok((await colourful()) > 0.005);
      }
      assert.equal(await ask(() => window.changes.at(-1)), 1);
      await screen("rung");
    });

    test("no errors, and no violations of the content policy", () => assert.deepEqual(browser.troubles, []));
  });
