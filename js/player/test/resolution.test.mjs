// How many pixels are drawn, as pictures come fast or slowly.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Resolution } from "../src/resolution.js";

/** Pictures that follow each other, so many milliseconds apart. */
function run(resolution, count, apart, from = 0) {
  for (let i = 0; i < count; i++) resolution.observe(from + i * apart, true);
  return from + count * apart;
}

test("as many as the screen has, up to two for one of the page", () => {
  const resolution = new Resolution();
  assert.deepEqual(
    [1, 1.5, 3].map((pixels) => resolution.ratio(pixels, false)),
    [1, 1.5, 2],
  );
  resolution.quality = "medium";
  assert.equal(resolution.ratio(3, true), 1);
  resolution.quality = "low";
  assert.equal(resolution.ratio(1, true), 0.5);
});

test("fewer while pictures come slowly, but not for what stands still, and as many as before when they come fast", () => {
  const resolution = new Resolution();
  let now = run(resolution, 120, 16);
  assert.equal(resolution.ratio(1, true), 1);
  now = run(resolution, 40, 70, now);
  const slow = resolution.ratio(1, true);
  assert.ok(slow < 0.8, `${slow}`);
  assert.equal(resolution.ratio(1, false), 1);
  run(resolution, 1200, 16, now);
  assert.equal(resolution.ratio(1, true), 1);
});

test("a machine that crawls is helped soon; a pause says nothing", () => {
  const crawling = new Resolution();
  run(crawling, 8, 600);
  assert.ok(crawling.ratio(1, true) < 0.8);
  const resting = new Resolution();
  for (let i = 0; i < 50; i++) resting.observe(5000 * i, false);
  assert.equal(resting.ratio(1, true), 1);
});
