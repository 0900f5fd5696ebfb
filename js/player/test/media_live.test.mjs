// A live stream, with a decoder of numbers and time by hand: how playing keeps up with it.

import assert from "node:assert/strict";
import { test } from "node:test";

import { World } from "./fake_decoder.mjs";

/** A live stream at 25 frames a second, joined a second late. */
const liveOptions = (world) => ({
  live: true,
  seekable: false,
  count: 2000,
  prepare: (decoder, times) => {
    const joined = world.now;
    decoder.madeAt = (number) => joined + 40 * number - (times === 0 ? 1000 : 0);
  },
});

test("live: catches up at 1.25 at most, then keeps its distance", async () => {
  const world = new World();
  const media = world.media(liveOptions(world));
  media.load("live", { live: true });
  await world.run(40);
  assert.equal(media.duration, Infinity);
  media.play();
  await world.run(400);
  const began = media.currentTime;
  await world.run(1000);
  const rate = media.currentTime - began;
  assert.ok(rate > 1.1 && rate <= 1.26, `rate ${rate}`);
  await world.run(8000);
  assert.ok(media.behind < 0.45, `${media.behind} s behind`);
  const calm = media.currentTime;
  await world.run(1000);
  assert.ok(Math.abs(media.currentTime - calm - 1) < 0.03, `${media.currentTime - calm}`);
});

test("live: after a short pause it hurries, after a long one it leaps", async () => {
  const world = new World();
  const media = world.media(liveOptions(world));
  media.load("live", { live: true });
  media.play();
  await world.run(6000);
  media.pause();
  await world.run(2000);
  assert.ok(media.behind > 2, `${media.behind}`);
  media.play();
  await world.run(12000);
  assert.ok(media.behind < 0.5, `${media.behind} s behind`);
  assert.equal(world.decoders.length, 1);
  media.pause();
  await world.run(6000);
  world.take();
  media.play();
  await world.run(1000);
  assert.equal(world.decoders.length, 2);
  assert.ok(media.behind < 1, `${media.behind} s behind`);
  assert.ok(world.take().includes("seeked"));
});

test("live: a stream that begins anew while it is paused stays behind, and catches up", async () => {
  const world = new World();
  world.showMs = 30;
  const RUN = 200;
  const media = world.media({ ...liveOptions(world), run: RUN });
  media.load("live", { live: true });
  media.play();
  // The two frames that are in hand are of the next run; none of them is shown.
  while (media.currentFrame < RUN - 2) await world.run(16);
  media.pause();
  await world.run(200);
  assert.ok(media.currentFrame < RUN, `${media.currentFrame} is shown`);
  const former = media.behind;
  assert.ok(former > 0.2 && former < 1, `${former} s behind`);
  await world.run(3000);
  assert.ok(Math.abs(media.behind - former - 3) < 0.05, `${media.behind} s behind, after 3 s more than ${former}`);
  media.play();
  await world.run(500);
  assert.ok(media.currentTime < 1, "the next run is on screen");
  assert.ok(media.behind > 2.5 && media.behind < 4, `${media.behind} s behind`);
  await world.run(14000);
  assert.ok(media.behind < 0.5, `${media.behind} s behind`);
  assert.equal(world.decoders.length, 1, "it ran, and did not leap");
});
