// Live streams with a simulated decoder and a simulated clock: playback keeps its delay behind the edge.

import assert from "node:assert/strict";
import { test } from "node:test";

import { ready, World } from "./fake_decoder.mjs";

/** A live stream at 25 frames per second, joined a second late. */
const liveOptions = (world) => ({
  live: true,
  seekable: false,
  count: 2000,
  prepare: (decoder, times) => {
    const joined = world.now;
    decoder.madeAt = (number) => joined + 40 * number - (times === 0 ? 1000 : 0);
  },
});

test("live: catches up at a rate of at most 1.25, then keeps its delay", async () => {
  const world = new World();
  const media = world.media(liveOptions(world));
  media.load("live", { live: true });
  await world.advance(40);
  assert.equal(media.duration, Infinity);
  media.play();
  await world.advance(400);
  const began = media.currentTime;
  await world.advance(1000);
  const rate = media.currentTime - began;
  assert.ok(rate > 1.1 && rate <= 1.26, `rate ${rate}`);
  await world.advance(8000);
  assert.ok(media.behind < 0.45, `${media.behind} s behind`);
  const calm = media.currentTime;
  await world.advance(1000);
  assert.ok(Math.abs(media.currentTime - calm - 1) < 0.03, `${media.currentTime - calm}`);
});

test("live: after a short pause it catches up, after a long one it skips", async () => {
  const world = new World();
  const media = world.media(liveOptions(world));
  media.load("live", { live: true });
  media.play();
  await world.advance(6000);
  media.pause();
  await world.advance(2000);
  assert.ok(media.behind > 2, `${media.behind}`);
  media.play();
  await world.advance(12000);
  assert.ok(media.behind < 0.5, `${media.behind} s behind`);
  assert.equal(world.decoders.length, 1);
  media.pause();
  await world.advance(6000);
  world.take();
  media.play();
  await world.advance(1000);
  assert.equal(world.decoders.length, 2);
  assert.ok(media.behind < 1, `${media.behind} s behind`);
  assert.ok(world.take().includes("seeked"));
});

test("live: what was lost while the network was away is passed over, without an empty stage", async () => {
  const AWAY = { before: 100, ticks: 125 };
  const world = new World();
  const media = world.media({
    ...liveOptions(world),
    gap: AWAY,
    prepare: (decoder) => (decoder.madeAt = (number) => 40 * (number + (number < AWAY.before ? 0 : AWAY.ticks))),
  });
  media.load("live", { live: true });
  media.play();
  await world.advance(40 * (AWAY.before + AWAY.ticks) - 200);
  assert.equal(media.currentFrame, AWAY.before - 1);
  await world.advance(1000);
  assert.ok(media.currentFrame > AWAY.before + 10, `frame ${media.currentFrame}`);
  assert.ok(!world.numbers().includes(null), "the stage was empty");
  await world.advance(8000);
  assert.ok(media.behind > 0 && media.behind < 0.5, `${media.behind} s behind`);
});

test("live: a publisher whose clock is slow is followed", async () => {
  const SLOWER = 1.05;
  const world = new World();
  const media = world.media({
    ...liveOptions(world),
    prepare: (decoder) => (decoder.madeAt = (number) => 40 * SLOWER * number),
  });
  media.load("live", { live: true });
  media.play();
  await world.advance(60000);
  const numbers = world.numbers();
  const dropped = numbers.at(-1) + 1 - numbers.length;
  const waits = world.take().filter((type) => type === "waiting").length;
  assert.ok(numbers.at(-1) > 60000 / 40 / SLOWER - 20, `frame ${numbers.at(-1)}`);
  assert.ok(
    numbers.every((number, i) => i === 0 || number > numbers[i - 1]),
    "frames go back",
  );
  assert.ok(dropped <= numbers.length / 50, `${dropped} frames were dropped`);
  assert.ok(waits <= 4, `${waits} waits`);
  assert.ok(media.behind < 0.5, `${media.behind} s behind`);
  assert.deepEqual([world.decoders.length, media.error, media.paused], [1, null, false]);
});

/** Plays a live stream whose frames are made at madeAt(number), for some milliseconds; behind: seconds at each second. */
async function follow(madeAt, milliseconds, liveCatchUp = {}) {
  const world = new World();
  const newest = () => {
    let number = 0;
    while (madeAt(number + 1) <= world.now) number++;
    return number;
  };
  const media = world.media({
    ...liveOptions(world),
    count: 1e6,
    prepare: (decoder, times) => {
      const first = times === 0 ? 0 : newest();
      decoder.madeAt = (number) => madeAt(number);
      decoder.arrived = newest;
      decoder.from(first);
    },
  });
  media.liveCatchUp = liveCatchUp;
  media.load("live", { live: true });
  media.play();
  const behind = [];
  while (world.now < milliseconds) {
    await world.advance(1000);
    behind.push(newest() / 25 - media.currentTime);
  }
  return { world, media, behind, waits: world.take().filter((type) => type === "waiting").length };
}

test("live: a publisher whose clock is fast is caught up with", async () => {
  for (const faster of [1.01, 1.05, 1.15]) {
    const { world, media, behind, waits } = await follow((number) => (40 / faster) * number, 90000);
    const late = Math.max(...behind.slice(10));
    assert.ok(late < 0.5 + 8 * (faster - 1), `${faster}: ${late} s behind`);
    assert.ok(waits <= 2, `${faster}: ${waits} waits`);
    assert.deepEqual([world.decoders.length, media.error, media.paused], [1, null, false]);
  }
});

test("live: where the rate does not suffice, playback jumps", async () => {
  const limits = { maxRate: 1.05, jumpAfter: 3 };
  const { world, media, behind } = await follow((number) => (40 / 1.3) * number, 60000, limits);
  assert.ok(Math.max(...behind) < 3 + 3, `${Math.max(...behind)} s behind`);
  assert.ok(world.decoders.length >= 3, `${world.decoders.length} connections`);
  assert.equal(media.error, null);
});

test("live: frames that come in bursts are not taken for a fast clock", async () => {
  // A group of a second at once.
  const { waits, behind, world } = await follow((number) => 1000 * Math.ceil((number + 1) / 25), 60000);
  assert.ok(waits <= 3, `${waits} waits`);
  const early = behind.slice(20).map((seconds) => Math.round(100 * seconds));
  assert.ok(Math.max(...early) - Math.min(...early) < 20, `${early}`);
  assert.equal(world.decoders.length, 1);
});

test("liveCatchUp: what is not given has its default, and what cannot be is refused", async () => {
  const { media } = await ready();
  media.liveCatchUp = { delay: 1 };
  assert.deepEqual(media.liveCatchUp, { delay: 1, maxRate: 1.25, jumpAfter: 5 });
  assert.throws(() => (media.liveCatchUp = { rate: 2 }), /expected delay, maxRate, jumpAfter, found rate/);
  for (const wrong of [{ delay: -1 }, { delay: 6 }, { maxRate: 0.9 }, { jumpAfter: NaN }])
    assert.throws(() => (media.liveCatchUp = wrong), RangeError);
});

test("live: a stream that restarts during a pause stays behind, and catches up", async () => {
  const world = new World();
  world.showMs = 30;
  const RESTART = 200;
  const media = world.media({ ...liveOptions(world), restartAfter: RESTART });
  media.load("live", { live: true });
  media.play();
  // The two frames in the queue are of the restarted stream; none of them is shown.
  while (media.currentFrame < RESTART - 2) await world.advance(16);
  media.pause();
  await world.advance(200);
  assert.ok(media.currentFrame < RESTART, `${media.currentFrame} is shown`);
  const former = media.behind;
  assert.ok(former > 0.2 && former < 1, `${former} s behind`);
  await world.advance(3000);
  assert.ok(Math.abs(media.behind - former - 3) < 0.05, `${media.behind} s behind, after 3 s more than ${former}`);
  media.play();
  await world.advance(500);
  assert.ok(media.currentTime < 1, "the restarted stream is not on screen");
  assert.ok(media.behind > 2.5 && media.behind < 4, `${media.behind} s behind`);
  await world.advance(14000);
  assert.ok(media.behind < 0.5, `${media.behind} s behind`);
  assert.equal(world.decoders.length, 1, "it skipped instead of catching up");
});
