// WebXR: where the scene is in the viewer's room, and sessions in Chromium with an emulated headset (iwer), whose two eyes are
// drawn beside each other.

import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";
import { PNG } from "pngjs";

import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { bundle } from "../../three/bundle.mjs";
import { axesOf } from "../src/navigation/pose.js";
import { projectionOf, raysOf } from "../src/renderer/matrices.js";
import { Placement } from "../src/xr/placement.js";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));

function assertClose(found, wanted, tolerance = 1e-6) {
  found.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) < tolerance, `${found} is not ${wanted}`));
}

/** Columns of a transform of the room: turned around the vertical, then moved. */
const transform = (angle, [x, y, z]) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, x, y, z, 1];
};
/** WebXR's projection with these tangents to the left, right, below and above. */
const projection = (left, right, down, up) => {
  const [w, h] = [right - left, up - down];
  return [2 / w, 0, 0, 0, 0, 2 / h, 0, 0, (right + left) / w, (up + down) / h, -1, -1, 0, 0, -0.2, 0];
};

describe("placement", () => {
  const viewport = { x: 640, y: 0, width: 640, height: 800 };
  const lens = projection(-0.8, 1.1, -1, 0.9);
  /** A scene of z up, two metres high, seen from +x. */
  const place = (more = {}) =>
    new Placement({
      extent: { centre: [10, 20, 31], radius: 1.5 },
      axes: axesOf("z", []),
      floor: 30,
      eye: [14, 20, 32],
      scaleKnown: true,
      ...more,
    });
  /** Pixels of a point of the stream in the viewport, y down. */
  const seen = (view, point) => {
    const { rotation: r, translation: t, fx, fy, cx, cy } = view;
    const [x, y, z] = [0, 1, 2].map(
      (i) => r[3 * i] * point[0] + r[3 * i + 1] * point[1] + r[3 * i + 2] * point[2] + t[i],
    );
    return [cx + (fx * x) / z, cy + (fy * y) / z, z];
  };

  test("the scene is on the floor, ahead of the viewer, with its size", () => {
    const placement = place();
    placement.face(transform(0.7, [1, 1.7, 2]));
    const view = placement.view(transform(0.7, [1, 1.7, 2]), lens, viewport);
    // The middle of its floor: 2.5 m ahead, 1.7 m below the eyes.
    const [x, y, depth] = seen(view, [10, 20, 30]);
    assertClose([depth], [2.5]);
    assertClose([x, y], [view.cx, view.cy + (view.fy * 1.7) / 2.5]);
    // What is at +y of the stream is on the right of who looks from +x.
    assertClose(seen(view, [10, 20.5, 30]), [x + (view.fx * 0.5) / 2.5, y, 2.5]);
  });

  test("the projection is that of WebXR, within its viewport", () => {
    const placement = place();
    const matrix = transform(0, [0, 1.6, 0]);
    const view = placement.view(matrix, lens, viewport);
    // A point with the tangents 0.4 and -0.3, two metres ahead.
    const room = [0.8, 1, -2];
    const stream = [10 + room[2] + placement.distance, 20 + room[0], 30 + room[1]];
    const clip = projectionOf(view, { near: 0.1, far: 10 });
    const at = [0, 1, 3].map((i) => [0, 1, 2].reduce((sum, k) => sum + clip[4 * k + i] * stream[k], clip[12 + i]));
    const [nx, ny] = [at[0] / at[2], at[1] / at[2]];
    assertClose([nx, ny], [(2 * 0.4 - 0.3) / 1.9, (2 * -0.3 + 0.1) / 1.9], 1e-5);
    // The ray of that pixel of the framebuffer leads to the point.
    const ray = raysOf(view);
    const pixel = [640 + (640 * (nx + 1)) / 2, (800 * (ny + 1)) / 2, 1];
    const direction = [0, 1, 2].map((k) => ray[k] * pixel[0] + ray[3 + k] * pixel[1] + ray[6 + k]);
    const eye = [10 + placement.distance, 20, 31.6];
    assertClose(
      direction.map((value, k) => eye[k] + 2 * value),
      stream,
      1e-5,
    );
  });

  test("scenes of unknown or unsuitable scale get a radius of a metre", () => {
    assert.equal(place({ scaleKnown: false }).scale, 1 / 1.5);
    assert.equal(place({ extent: { centre: [0, 0, 0], radius: 400 }, floor: -100 }).scale, 1 / 400);
    assert.equal(place().scale, 1);
  });

  test("turns and scales leave its middle where it is; two hands hold two points", () => {
    const placement = place();
    placement.face(transform(0, [0, 1.6, 0]));
    const anchor = [...placement.anchor];
    placement.turnBy(1);
    placement.scaleBy(1e9);
    assert.equal(placement.scale, 20);
    placement.scaleBy(0.05);
    assert.deepEqual(placement.anchor, anchor);
    const hands = [
      [-0.2, 1, -0.5],
      [0.2, 1, -0.5],
    ];
    const moved = [
      [0, 1.1, -0.8],
      [0, 1.1, -0.2],
    ];
    /** The place in the stream of a point of the room: the eye of a viewer who is there. */
    const toStream = (point) => {
      const { rotation: r, translation: t } = placement.view(transform(0, point), lens, viewport);
      return [0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]));
    };
    const before = hands.map(toStream);
    placement.hold(hands, moved);
    moved.map(toStream).forEach((point, i) => assertClose(point, before[i]));
  });
});

describe("sessions", { skip: missingBrowser("chromium") }, () => {
  // Pixels of the window; small, because a processor without a graphics card draws them.
  const size = [640, 360];
  let folder, served, browser, page;

  before(async () => {
    mkdirSync(screens, { recursive: true });
    folder = mkdtempSync(join(tmpdir(), "fvv-xr-"));
    const capture = join(folder, "capture");
    tool("fvvsynth", "-o", capture, "--rig", "small", "--frames", "12", "--size", "240x160", "--environment");
    tool("fvvmux", capture, "-o", join(folder, "players.fvv"), "--group", "6", "--triangles", "6000");
    served = await serveFolder();
    await bundle(here("xr_page.js"), [here("xr_page.html"), here("page.css")], served.folder);
    copyFileSync(join(folder, "players.fvv"), join(served.folder, "players.fvv"));
    browser = await openBrowser("chromium");
    page = await browser.newPage(`${served.url}xr_page.html`, ...size);
    await until(() => window.player?.readyState === 4);
    await until(() => window.player.hasEnvironment && !window.player._stage?.busy);
  });
  after(async () => {
    await browser?.close();
    served?.close();
    if (folder) rmSync(folder, { recursive: true, force: true });
  });

  const ask = (expression, ...values) => page.evaluate(expression, ...values);
  const until = (condition, ...values) => page.waitForFunction(condition, { timeout: 60000, polling: 50 }, ...values);
  /** Waits for count pictures of the screen. */
  const pictures = (count) =>
    ask(async (count) => {
      const before = window.player.stats.drawnFrames;
      while (window.player.stats.drawnFrames < before + count) await new Promise((done) => setTimeout(done, 20));
    }, count);
  const screen = async (name) => {
    const bytes = await page.screenshot({ path: join(screens, `player-xr-${name}.png`) });
    return PNG.sync.read(Buffer.from(bytes));
  };
  /** Of an eye, 0 or 1: count and mean column of the pixels that the test accepts. */
  const middleOf = ({ width, height, data }, eye, accepts) => {
    let [count, sum] = [0, 0];
    for (let y = 0; y < height; y++)
      for (let x = 0; x < width / 2; x++) {
        const i = 4 * (y * width + x + (eye * width) / 2);
        if (!accepts(data[i], data[i + 1], data[i + 2])) continue;
        count++;
        sum += x;
      }
    return { count, column: sum / count };
  };
  const blue = (r, g, b) => b > 90 && b > 1.8 * r && b > 1.5 * g;
  const click = async (part) => {
    const { x, y, width, height } = await ask((part) => {
      const button = window.player.shadowRoot.querySelector(`.bar [part~="${part}"]`);
      return button.getBoundingClientRect().toJSON();
    }, part);
    await page.mouse.click(x + width / 2, y + height / 2);
  };
  const placement = () =>
    ask(() => {
      const { turn, scale, anchor } = window.player.placement;
      return { turn, scale, anchor };
    });

  test("buttons are shown if the browser offers sessions", async () => {
    assert.deepEqual(await ask(() => window.player.immersiveModes), ["vr", "ar"]);
    const shown = await ask(() =>
      ["vr", "ar"].map((part) => !window.player.shadowRoot.querySelector(`.bar [part~="${part}"]`).hidden),
    );
    assert.deepEqual(shown, [true, true]);
  });

  test("draws both eyes from one upload, with the scene in front of the viewer", async () => {
    await click("vr");
    await until(() => window.player.immersive === "vr");
    await pictures(3);
    const picture = await screen("vr");
    const [left, right] = [0, 1].map((eye) => middleOf(picture, eye, blue));
    assert.ok(left.count > 1300 && right.count > 1300, `${left.count} and ${right.count} blue pixels`);
    // The nearer player is blue: the left eye sees it farther to the right.
    const disparity = left.column - right.column;
    assert.ok(disparity > 2 && disparity < 30, `${disparity} pixels`);
    const before = await ask(() => window.player.stats);
    await pictures(5);
    const after = await ask(() => window.player.stats);
    assert.equal(after.contentFrames, before.contentFrames);
    assert.equal(after.shadowPasses, before.shadowPasses);
    assert.equal(after.bytesUploadedPerDrawnFrame, 0);
    assert.equal(after.drawCalls % 2, 0, `${after.drawCalls} draw calls for two eyes`);
  });

  test("controllers turn, scale, move and scrub the scene, and play it", async () => {
    const first = await placement();
    await ask(() => window.device.controllers.right.updateAxes("thumbstick", 1, 0));
    await pictures(4);
    const turned = await placement();
    assert.ok(Math.abs(turned.turn - first.turn - Math.PI / 6) < 1e-6, "one turn for each deflection");
    await ask(() => window.device.controllers.right.updateAxes("thumbstick", 0, -1));
    await until((scale) => window.player.placement.scale > 1.05 * scale, first.scale);
    await ask(() => window.device.controllers.right.updateAxes("thumbstick", 0, 0));
    await screen("turned");
    await ask(() => window.device.controllers.left.updateAxes("thumbstick", 1, 0));
    await until(() => window.player.currentFrame >= 3);
    await ask(() => window.device.controllers.left.updateAxes("thumbstick", -1, 0));
    await until(() => window.player.currentFrame === 0);
    await ask(() => window.device.controllers.left.updateAxes("thumbstick", 0, 0));
    await until(() => !window.player.seeking);
    // One hand moves the scene.
    const held = await placement();
    await ask(() => window.device.controllers.right.updateButtonValue("squeeze", 1));
    await pictures(3);
    await ask(() => (window.device.controllers.right.position.y += 0.25));
    await pictures(3);
    await ask(() => window.device.controllers.right.updateButtonValue("squeeze", 0));
    await pictures(2);
    assertClose((await placement()).anchor, [held.anchor[0], held.anchor[1] + 0.25, held.anchor[2]], 1e-3);
    // A slow machine may have played the clip to its end between two looks: what happened is kept.
    await ask(() => {
      window.happened = new Set();
      const { player, happened } = window;
      player.addEventListener("play", () => happened.add("play"), { once: true });
      player.addEventListener("timeupdate", () => player.currentFrame > 1 && happened.add("moved"));
    });
    await ask(() => window.device.controllers.right.updateButtonValue("trigger", 1));
    await pictures(2);
    await ask(() => window.device.controllers.right.updateButtonValue("trigger", 0));
    await until(() => window.happened.has("play") && window.happened.has("moved"));
    await ask(() => window.player.pause());
  });

  test("after the session the page has its picture again", async () => {
    await ask(() => window.player.exitImmersive());
    await until(() => window.player.immersive === null && !window.player._stage?.busy);
    assert.equal(await ask(() => window.player.hasAttribute("immersive")), false);
    const { width, height } = await ask(() => window.player.stats);
    assert.deepEqual([width, height], [608, 342]);
    await screen("left");
    assert.ok(
      await ask(() => new Set(new Uint32Array(window.player._stage.renderer.readPixels().data.buffer)).size > 500),
    );
  });

  test("over the real world there is nothing around the mesh", async () => {
    await click("ar");
    await until(() => window.player.immersive === "ar");
    await pictures(3);
    const picture = await screen("ar");
    for (const eye of [0, 1]) {
      assert.ok(middleOf(picture, eye, blue).count > 1300);
      const empty = middleOf(picture, eye, (r, g, b) => r + g + b === 0).count;
      assert.ok(empty > 0.6 * (size[0] / 2) * size[1], `${empty} pixels are empty`);
    }
    // The device ends the session.
    await ask(() => window.device.activeSession.end());
    await until(() => window.player.immersive === null);
  });

  test("no errors", () => assert.deepEqual(browser.troubles, []));
});
