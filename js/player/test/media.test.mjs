// Playback with a simulated decoder and a simulated clock: events in order, frames at their time, seeks, loops, live, buffered ranges.

import assert from "node:assert/strict";
import { test } from "node:test";

import { ready, World } from "./fake_decoder.mjs";

const upTo = (n, from = 0) => Array.from({ length: n - from }, (_, i) => from + i);

test("events of loading, in the order of HTML", async () => {
  const { world, media } = await ready();
  assert.deepEqual(world.take(), [
    "loadstart",
    "durationchange",
    "loadedmetadata",
    "loadeddata",
    "canplay",
    "canplaythrough",
  ]);
  assert.equal(media.duration, 2);
  assert.equal(media.readyState, 4);
  assert.equal(media.paused, true);
  assert.deepEqual(world.numbers(), [0]);
});

test("plays to its end: each frame once, at its time, and then again from the beginning", async () => {
  const { world, media } = await ready();
  world.take();
  let kept = false;
  const began = world.now;
  media.play().then(() => (kept = true));
  await world.run(1000);
  assert.ok(kept);
  assert.ok(Math.abs(media.currentTime - 1) < 0.01, `${media.currentTime} s`);
  await world.run(1200);
  assert.deepEqual(world.take(), ["play", "playing", "suspend", "pause", "ended"]);
  assert.equal(media.ended, true);
  assert.equal(media.currentTime, 2);
  for (const { number, at } of world.shown.slice(1)) {
    const late = at - began - 40 * number;
    assert.ok(late >= -4 && late <= 20, `frame ${number} is ${late} ms late`);
  }
  assert.deepEqual(world.numbers(), upTo(50));
  media.play();
  await world.run(200);
  assert.equal(world.take()[0], "seeking");
  assert.equal(world.numbers()[0], 0);
  assert.equal(media.ended, false);
});

test("autoplay begins by itself", async () => {
  const world = new World();
  const media = world.media();
  media.autoplay = true;
  media.load("clip");
  await world.run(200);
  assert.deepEqual(world.take().slice(3), ["loadeddata", "canplay", "canplaythrough", "play", "playing"]);
  assert.equal(media.paused, false);
});

test("pause keeps the frame; nothing is taken while it lasts, and time goes on where it was", async () => {
  const { world, media } = await ready();
  media.play();
  await world.run(500);
  media.pause();
  const at = media.currentTime;
  world.numbers();
  await world.run(3000);
  assert.deepEqual(world.numbers(), []);
  assert.equal(media.currentTime, at);
  assert.equal(media.tick(), false);
  media.play();
  await world.run(100);
  assert.ok(Math.abs(media.currentTime - at - 0.1) < 0.01);
});

test("a promise of play ends with pause, as HTML says", async () => {
  const world = new World();
  world.decodeMs = 500;
  const media = world.media();
  media.load("clip");
  const promise = media.play();
  media.pause();
  await assert.rejects(promise, { name: "AbortError" });
});

test("seeks: the last of many wins, and only that one is told of", async () => {
  const { world, media } = await ready();
  world.take();
  world.numbers();
  for (const seconds of [0.2, 0.9, 1.5, 1.1]) media.currentTime = seconds;
  assert.equal(media.seeking, true);
  assert.equal(media.currentTime, 1.1);
  await world.run(100);
  assert.equal(world.numbers().at(-1), 27);
  assert.equal(media.seeking, false);
  assert.equal(media.currentTime, 1.1);
  const events = world.take();
  assert.deepEqual(events.slice(-4), ["seeking", "seeked", "canplay", "canplaythrough"]);
  assert.equal(events.filter((type) => type === "seeked").length, 1);
});

test("a seek that comes while the frame of another one is shown is not taken for done", async () => {
  const { world, media } = await ready();
  world.showMs = 400;
  media.currentTime = 0.4;
  await world.run(100);
  media.currentTime = 1.2;
  // Its patience ends by the clock of the machine.
  await new Promise((done) => setTimeout(done, 300));
  await world.run(350);
  assert.equal(media.seeking, true);
  await world.run(800);
  assert.equal(media.seeking, false);
  assert.equal(world.numbers().at(-1), 30);
  assert.equal(media.currentTime, 1.2);
});

test("a seek while it plays waits, and plays on", async () => {
  const { world, media } = await ready();
  media.play();
  await world.run(200);
  world.take();
  world.decodeMs = 60;
  media.currentTime = 1.2;
  await world.run(400);
  assert.deepEqual(world.take().slice(0, 5), ["seeking", "waiting", "seeked", "canplay", "playing"]);
  assert.ok(media.currentTime > 1.2);
});

test("a frame that was on its way when something was sought is not shown", async () => {
  const { world, media } = await ready();
  world.decodeMs = 50;
  media.play();
  await world.run(40);
  world.numbers();
  media.pause();
  media.currentFrame = 40;
  await world.run(300);
  assert.deepEqual(world.numbers(), [40]);
});

test("steps go frame by frame, both ways, and add up", async () => {
  const { world, media } = await ready();
  for (let i = 0; i < 3; i++) {
    media.step(1);
    await world.run(40);
  }
  media.step(-1);
  await world.run(40);
  assert.deepEqual(world.numbers(), [0, 1, 2, 3, 2]);
  assert.equal(media.currentTime, 2 / 25);
  for (let i = 0; i < 4; i++) media.step(-1);
  await world.run(400);
  assert.equal(world.numbers().at(-1), 0);
  media.currentFrame = 49;
  await world.run(300);
  media.step(1);
  await world.run(300);
  assert.equal(media.currentFrame, 49);
});

test("loops without a pause", async () => {
  const { world, media } = await ready({ count: 20 });
  media.loop = true;
  media.play();
  world.take();
  await world.run(2000);
  const { shown } = world;
  assert.deepEqual(
    shown.slice(0, 45).map(({ number }) => number),
    [...upTo(20), ...upTo(20), ...upTo(5)],
  );
  const gap = shown[20].at - shown[19].at;
  assert.ok(gap >= 36 && gap <= 52, `${gap} ms between the last frame and the first`);
  assert.deepEqual(
    world.take().slice(0, 5),
    ["play", "playing", "seeking", "seeked", "seeking"].slice(0, 4).concat("seeking"),
  );
  assert.equal(media.ended, false);
});

test("a range plays again and again, and is left when it is taken away", async () => {
  const { world, media } = await ready();
  media.loopRange = { from: 0.4, to: 0.8 };
  media.currentTime = 0.4;
  await world.run(40);
  world.numbers();
  media.play();
  await world.run(1000);
  const numbers = world.numbers();
  assert.deepEqual(numbers.slice(0, 24), [...upTo(20, 11), ...upTo(20, 10), ...upTo(15, 10)]);
  // It has the beginning of the range in hand already.
  await world.run(160);
  media.loopRange = null;
  await world.run(1000);
  const after = world.numbers();
  assert.ok(after.includes(30), `${after}`);
  assert.throws(() => (media.loopRange = { from: 1, to: 1 }), RangeError);
});

test("rates: slow ones, fast ones, and one that is none", async () => {
  const { world, media } = await ready({ count: 400 });
  media.playbackRate = 0.1;
  media.play();
  await world.run(1000);
  assert.ok(Math.abs(media.currentTime - 0.1) < 0.01);
  media.playbackRate = 4;
  world.numbers();
  await world.run(1000);
  assert.ok(Math.abs(media.currentTime - 4.1) < 0.05, `${media.currentTime}`);
  assert.throws(() => (media.playbackRate = -1), { name: "NotSupportedError" });
  assert.ok(world.take().includes("ratechange"));
});

test("showing that takes too long drops frames and keeps the time", async () => {
  const { world, media } = await ready({ count: 200 });
  world.showMs = 90;
  media.play();
  await world.run(4000);
  assert.ok(Math.abs(media.currentTime - 4) < 0.2, `${media.currentTime}`);
  assert.ok(media.meter.framesDropped > 30, `${media.meter.framesDropped} dropped`);
  assert.ok(world.mostOpen <= 2, `${world.mostOpen} open`);
});

test("frames that are dropped are a part of the stream, and the last one is shown", async () => {
  const { world, media } = await ready();
  world.showMs = 90;
  media.playbackRate = 4;
  media.play();
  await world.run(1000);
  assert.equal(media.ended, true);
  assert.ok(media.meter.framesDropped > 20);
  assert.equal(world.numbers().at(-1), 49);
  assert.equal(media.duration, 2);
  assert.equal(media.seekable.end(0), 2);
});

test("frames that have lost their pictures: asked for again where one stays, passed over where it plays", async () => {
  const world = new World();
  const media = world.media();
  let times = 0;
  world.lost = (number) => number === 0 && times++ === 0;
  media.load("clip");
  await world.run(60);
  assert.equal(world.seeks, 1);
  assert.deepEqual(world.numbers(), [0]);
  world.lost = (number) => number === 5;
  media.play();
  await world.run(400);
  assert.deepEqual(world.numbers().slice(0, 7), [1, 2, 3, 4, 6, 7, 8]);
  // Where there never are any, as of a codec that is not known here, the mesh is shown all the same.
  world.lost = () => true;
  media.currentFrame = 20;
  await world.run(100);
  assert.ok(world.numbers().includes(20));
  await world.run(400);
  assert.ok(world.numbers().length > 5);
});

test("decoding that takes too long leaps over groups and keeps the time", async () => {
  const { world, media } = await ready({ count: 400 });
  world.decodeMs = 80;
  media.play();
  await world.run(8000);
  assert.ok(Math.abs(media.currentTime - 8) < 0.8, `${media.currentTime}`);
  assert.ok(media.meter.framesDropped > 50, `${media.meter.framesDropped} dropped`);
  assert.ok(world.shown.length > 50, `${world.shown.length} shown`);
});

test("a frame that does not come is waited for", async () => {
  const { world, media } = await ready();
  media.play();
  await world.run(200);
  world.take();
  world.decodeMs = 1000;
  await world.run(400);
  assert.deepEqual(world.take(), ["waiting"]);
  const stuck = media.currentTime;
  await world.run(200);
  assert.equal(media.currentTime, stuck);
  world.decodeMs = 0;
  await world.run(800);
  assert.deepEqual(world.take().slice(0, 3), ["canplay", "playing", "canplaythrough"]);
  assert.ok(media.currentTime > stuck);
});

test("what goes wrong while opening, and while playing", async () => {
  const { world, media } = await ready({
    prepare: (decoder) => (decoder.broken = Object.assign(new Error("no fvv stream"), { code: "invalid" })),
  });
  assert.deepEqual(world.take(), ["loadstart", "error"]);
  assert.equal(media.error.code, 4);
  assert.equal(media.networkState, 3);
  await assert.rejects(media.play(), { name: "NotSupportedError" });

  const other = await ready();
  other.world.decoders[0].broken = Object.assign(new Error("the connection broke"), { code: "io" });
  other.media.play();
  await other.world.run(300);
  assert.equal(other.media.error.code, 2);
  assert.equal(other.world.take().at(-1), "error");
});

test("another source: the former one is let go", async () => {
  const { world, media } = await ready();
  media.play();
  await world.run(100);
  world.take();
  media.load("other");
  await world.run(100);
  assert.deepEqual(world.take().slice(0, 4), ["abort", "emptied", "loadstart", "durationchange"]);
  assert.equal(world.decoders[0].closed, true);
  assert.equal(media.paused, true);
  media.load(null);
  await world.run(20);
  assert.equal(world.open, 0);
  assert.equal(media.networkState, 0);
});

test("begins where it was told to, without showing the first frame", async () => {
  const world = new World();
  const media = world.media();
  media.load("clip", { at: { frame: 30 } });
  await world.run(60);
  assert.deepEqual(world.numbers(), [30]);
  assert.deepEqual(world.take(), [
    "loadstart",
    "durationchange",
    "loadedmetadata",
    "seeking",
    "loadeddata",
    "seeked",
    "canplay",
    "canplaythrough",
  ]);
});

test("a source without seeking: steps forward only, loops by opening it again", async () => {
  const { world, media } = await ready({ count: 10, seekable: false });
  assert.equal(media.seekable.length, 0);
  assert.equal(media.step(-1), false);
  media.step(1);
  await world.run(40);
  assert.equal(media.currentFrame, 1);
  media.loop = true;
  media.play();
  await world.run(1000);
  assert.equal(world.decoders.length, 3);
  assert.ok(world.numbers().length > 20);
});

test("suspended, as when the page is hidden, time stands still and nothing is told", async () => {
  const { world, media } = await ready();
  media.play();
  await world.run(200);
  world.take();
  media.suspended = true;
  const at = media.currentTime;
  await world.run(1000);
  assert.equal(media.currentTime, at);
  assert.deepEqual(world.take(), []);
  media.suspended = false;
  await world.run(100);
  assert.ok(media.currentTime > at);
});

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

const pairs = (ranges) => Array.from({ length: ranges.length }, (_, i) => [ranges.start(i), ranges.end(i)]);

test("what is buffered: what the decoder holds and what is decoded, one range where they touch", async () => {
  const { world, media } = await ready();
  const [decoder] = world.decoders;
  // The frame on screen and the next one.
  assert.deepEqual(pairs(media.buffered), [[0, 0.08]]);
  decoder.heldTimes = [{ start: 10n, end: 20n }, { start: 40n, end: 50n }]; // prettier-ignore
  await media.measure();
  assert.deepEqual(pairs(media.buffered), [[0, 0.08], [0.4, 0.8], [1.6, 2]]); // prettier-ignore
  assert.ok(Math.abs(media.buffered.ahead(0.5) - 0.3) < 1e-9);
  assert.equal(media.buffered.ahead(1), 0);
  decoder.heldTimes = [{ start: 2n, end: 40n }, { start: 40n, end: 50n }]; // prettier-ignore
  await media.measure();
  assert.deepEqual(pairs(media.buffered), [[0, 2]]);
});

test("a source whose length is known in the end: one seeks in what has come, then in all of it, and loops", async () => {
  const { world, media } = await ready({
    prepare: (decoder) => {
      decoder.whole = { groups: decoder.groups, frameCount: decoder.frameCount };
      Object.assign(decoder, { groups: null, frameCount: null });
    },
  });
  const [decoder] = world.decoders;
  assert.equal(media.duration, Infinity);
  assert.ok(world.take().includes("durationchange"));
  media.play();
  await world.run(400);
  decoder.heldTimes = [{ start: 0n, end: 15n }];
  await media.measure();
  assert.deepEqual(pairs(media.seekable), [[0, 0.6]]);
  media.currentTime = 0.2;
  await world.run(60);
  assert.ok(media.currentTime < 0.3);
  media.step(-1);
  await world.run(400);
  assert.equal(media.currentFrame, world.numbers().at(-1));
  media.loop = true;
  media.play();
  Object.assign(decoder, decoder.whole);
  decoder.dispatchEvent(new Event("groups"));
  await world.run(40);
  assert.equal(media.duration, 2);
  assert.ok(world.take().includes("durationchange"));
  assert.deepEqual(pairs(media.seekable), [[0, 2]]);
  await world.run(2400);
  assert.equal(world.decoders.length, 1);
  const numbers = world.numbers();
  assert.ok(numbers.includes(49) && numbers.lastIndexOf(0) > numbers.indexOf(49), `${numbers}`);
});
