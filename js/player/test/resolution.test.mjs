// The resolution of pictures, depending on the speed of drawing, and how long it takes until they are on the screen.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Resolution } from "../src/resolution.js";
import { ScreenDelay } from "../src/screen_delay.js";
import { shownScale } from "../src/view.js";

/** Consecutive pictures at an interval in milliseconds. */
function observe(resolution, count, apart, from = 0) {
  for (let i = 0; i < count; i++) resolution.observe(from + i * apart, true);
  return from + count * apart;
}

test("as many pixels as the screen has, up to two per pixel of the page", () => {
  const resolution = new Resolution();
  assert.deepEqual(
    [1, 1.5, 3].map((pixels) => resolution.ratio(pixels, false)),
    [1, 1.5, 2],
  );
  resolution.pixelRatio = 1;
  assert.equal(resolution.ratio(3, true), 1);
  resolution.pixelRatio = 0.5;
  assert.equal(resolution.ratio(1, true), 0.5);
});

test("fewer pixels of the surface while drawing is slow, then of all; not for still pictures, and not when it is fast again", () => {
  const resolution = new Resolution();
  let now = observe(resolution, 120, 16);
  assert.equal(resolution.ratio(1, true), 1);
  const ratios = (moving) => [resolution.ratio(1, moving), resolution.surfaceScale(moving)];
  now = observe(resolution, 12, 70, now);
  const slow = resolution.surfaceScale(true);
  assert.ok(slow < 0.8, `${slow}`);
  assert.equal(resolution.ratio(1, true), 1, "walls stay sharp");
  assert.deepEqual(ratios(false), [1, 1]);
  now = observe(resolution, 60, 70, now);
  assert.ok(resolution.ratio(1, true) < 0.8);
  assert.deepEqual(ratios(false), [1, 1]);
  observe(resolution, 1200, 16, now);
  assert.deepEqual(ratios(true), [1, 1]);
});

test("a very slow machine is detected soon; pauses have no effect", () => {
  const crawling = new Resolution();
  observe(crawling, 8, 600);
  assert.ok(crawling.surfaceScale(true) < 0.8);
  const resting = new Resolution();
  for (let i = 0; i < 50; i++) resting.observe(5000 * i, false);
  assert.equal(resting.ratio(1, true), 1);
});

test("how large cameras' pictures are shown", () => {
  const pose = { eye: [0, 0, 4], target: [0, 0, 0], fov: Math.PI / 2 };
  const camera = (z, fy, calibrated = true) => ({ centre: [0, 0, z], fy, calibrated });
  // 400 pixels over 90 degrees are a focal length of 200: 50 pixels a metre at 4 m; the camera has 100 at 8 m.
  assert.ok(Math.abs(shownScale(pose, 400, [camera(8, 800)]) - 0.5) < 1e-12);
  assert.ok(Math.abs(shownScale(pose, 400, [camera(8, 800), camera(4, 800), camera(2, 100)]) - 0.5) < 1e-12);
  assert.equal(shownScale(pose, 400, [camera(8, 800, false)]), null);
});

test("the time from a frame to the screen is measured, and pauses do not count", () => {
  const screen = new ScreenDelay();
  assert.deepEqual(screen.value, { delay: 2000 / 60, refresh: 1000 / 60 });
  let now = 0;
  const play = (count, refresh) => {
    for (let i = 0; i < count; i++, now += refresh) {
      screen.draws(now, true);
      // Each third animation frame takes a frame, which the next one draws.
      if (i % 3 === 0) screen.uploaded(now + 1);
    }
  };
  play(60, 8);
  assert.deepEqual(screen.value, { delay: 15, refresh: 8 });
  // One that was late, and a pause.
  now += 30;
  play(6, 8);
  screen.draws(now, false);
  now += 10000;
  play(3, 8);
  assert.deepEqual(screen.value, { delay: 15, refresh: 8 });
  play(60, 20);
  assert.deepEqual(screen.value, { delay: 39, refresh: 20 });
});
