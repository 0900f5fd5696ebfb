// Playback with a simulated decoder and a simulated clock: events in order, frames at their time, seeks, loops,
// buffered ranges.

import assert from "node:assert/strict";
import { test } from "node:test";

import { ready, World } from "./fake_decoder.mjs";

const numbersTo = (n, from = 0) => Array.from({ length: n - from }, (_, i) => from + i);

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

test("plays to the end: each frame once, at its time, then again from the beginning", async () => {
  const { world, media } = await ready();
  world.take();
  let resolved = false;
  const began = world.now;
  media.play().then(() => (resolved = true));
  await world.advance(1000);
  assert.ok(resolved);
  assert.ok(Math.abs(media.currentTime - 1) < 0.01, `${media.currentTime} s`);
  await world.advance(1200);
  assert.deepEqual(world.take(), ["play", "playing", "suspend", "pause", "ended"]);
  assert.equal(media.ended, true);
  assert.equal(media.currentTime, 2);
  for (const { number, at } of world.shown.slice(1)) {
    const late = at - began - 40 * number;
    assert.ok(late >= -4 && late <= 20, `frame ${number} is ${late} ms late`);
  }
  assert.deepEqual(world.numbers(), numbersTo(50));
  media.play();
  await world.advance(200);
  assert.equal(world.take()[0], "seeking");
  assert.equal(world.numbers()[0], 0);
  assert.equal(media.ended, false);
});

test("autoplay with a screen that is later than a frame lasts", async () => {
  const world = new World();
  const media = world.media({ screen: () => ({ delay: 48, refresh: 16 }) });
  media.autoplay = true;
  media.load("clip");
  await world.advance(400);
  assert.deepEqual(world.numbers().slice(0, 8), numbersTo(8));
  assert.ok(world.mostOpen <= 2, `${world.mostOpen} open`);
});

test("autoplay starts playback", async () => {
  const world = new World();
  const media = world.media();
  media.autoplay = true;
  media.load("clip");
  await world.advance(200);
  assert.deepEqual(world.take().slice(3), ["loadeddata", "canplay", "canplaythrough", "play", "playing"]);
  assert.equal(media.paused, false);
});

test("pause keeps the frame and takes no others; then time continues where it was", async () => {
  const { world, media } = await ready();
  media.play();
  await world.advance(500);
  media.pause();
  const at = media.currentTime;
  world.numbers();
  await world.advance(3000);
  assert.deepEqual(world.numbers(), []);
  assert.equal(media.currentTime, at);
  assert.equal(media.tick(), false);
  media.play();
  await world.advance(100);
  assert.ok(Math.abs(media.currentTime - at - 0.1) < 0.01);
});

test("pause rejects the promise of play, as in HTML", async () => {
  const world = new World();
  world.decodeMs = 500;
  const media = world.media();
  media.load("clip");
  const promise = media.play();
  media.pause();
  await assert.rejects(promise, { name: "AbortError" });
});

test("seeks: the last of many wins, and only that one is reported", async () => {
  const { world, media } = await ready();
  world.take();
  world.numbers();
  for (const seconds of [0.2, 0.9, 1.5, 1.1]) media.currentTime = seconds;
  assert.equal(media.seeking, true);
  assert.equal(media.currentTime, 1.1);
  await world.advance(100);
  assert.equal(world.numbers().at(-1), 27);
  assert.equal(media.seeking, false);
  assert.equal(media.currentTime, 1.1);
  const events = world.take();
  assert.deepEqual(events.slice(-4), ["seeking", "seeked", "canplay", "canplaythrough"]);
  assert.equal(events.filter((type) => type === "seeked").length, 1);
});

test("a seek while the frame of another seek is being shown is not finished by that frame", async () => {
  const { world, media } = await ready();
  world.showMs = 400;
  media.currentTime = 0.4;
  await world.advance(100);
  media.currentTime = 1.2;
  // The timeout of a search uses the real clock.
  await new Promise((done) => setTimeout(done, 300));
  await world.advance(350);
  assert.equal(media.seeking, true);
  await world.advance(800);
  assert.equal(media.seeking, false);
  assert.equal(world.numbers().at(-1), 30);
  assert.equal(media.currentTime, 1.2);
});

test("a seek during playback waits, and playback continues", async () => {
  const { world, media } = await ready();
  media.play();
  await world.advance(200);
  world.take();
  world.decodeMs = 60;
  media.currentTime = 1.2;
  await world.advance(400);
  assert.deepEqual(world.take().slice(0, 5), ["seeking", "waiting", "seeked", "canplay", "playing"]);
  assert.ok(media.currentTime > 1.2);
});

test("a frame that was being decoded during a seek is not shown", async () => {
  const { world, media } = await ready();
  world.decodeMs = 50;
  media.play();
  await world.advance(40);
  world.numbers();
  media.pause();
  media.currentFrame = 40;
  await world.advance(300);
  assert.deepEqual(world.numbers(), [40]);
});

test("steps go frame by frame in both directions, and add up", async () => {
  const { world, media } = await ready();
  for (let i = 0; i < 3; i++) {
    media.step(1);
    await world.advance(40);
  }
  media.step(-1);
  await world.advance(40);
  assert.deepEqual(world.numbers(), [0, 1, 2, 3, 2]);
  assert.equal(media.currentTime, 2 / 25);
  for (let i = 0; i < 4; i++) media.step(-1);
  await world.advance(400);
  assert.equal(world.numbers().at(-1), 0);
  media.currentFrame = 49;
  await world.advance(300);
  media.step(1);
  await world.advance(300);
  assert.equal(media.currentFrame, 49);
});

test("loops without a pause", async () => {
  const { world, media } = await ready({ count: 20 });
  media.loop = true;
  media.play();
  world.take();
  await world.advance(2000);
  const { shown } = world;
  assert.deepEqual(
    shown.slice(0, 45).map(({ number }) => number),
    [...numbersTo(20), ...numbersTo(20), ...numbersTo(5)],
  );
  const gap = shown[20].at - shown[19].at;
  assert.ok(gap >= 36 && gap <= 52, `${gap} ms between the last frame and the first`);
  assert.deepEqual(
    world.take().slice(0, 5),
    ["play", "playing", "seeking", "seeked", "seeking"].slice(0, 4).concat("seeking"),
  );
  assert.equal(media.ended, false);
});

test("frames are on the screen at their time, from one round of a loop to the next", async () => {
  const screen = () => ({ delay: 48, refresh: 16 });
  const { world, media } = await ready({ count: 20, screen });
  media.loop = true;
  const began = world.now;
  media.play();
  await world.advance(3920);
  const shown = world.shown.slice(10, 95);
  assert.deepEqual(
    shown.map(({ number }) => number),
    Array.from({ length: 85 }, (_, i) => (i + 10) % 20),
  );
  shown.forEach(({ number, at }, i) => {
    const late = at + screen().delay - began - 40 * (i + 10);
    assert.ok(late >= -8 && late <= 12, `frame ${number} is ${late} ms late on the screen`);
  });
  // Before the round begins to be heard, the one before is.
  const { position, begins } = media.motion;
  assert.equal(begins, 0);
  assert.ok(Math.abs(position - (((world.now - began) / 1000) % 0.8)) < 0.01, `${position}`);
  media.currentTime = 0.4;
  await world.advance(200);
  assert.equal(media.motion.begins, -Infinity);
});

test("a range is played in a loop, until it is removed", async () => {
  const { world, media } = await ready();
  media.loopRange = { from: 0.4, to: 0.8 };
  media.currentTime = 0.4;
  await world.advance(40);
  world.numbers();
  media.play();
  await world.advance(1000);
  const numbers = world.numbers();
  assert.deepEqual(numbers.slice(0, 24), [...numbersTo(20, 11), ...numbersTo(20, 10), ...numbersTo(15, 10)]);
  // The beginning of the range is already in the queue.
  await world.advance(160);
  media.loopRange = null;
  await world.advance(1000);
  const after = world.numbers();
  assert.ok(after.includes(30), `${after}`);
  assert.throws(() => (media.loopRange = { from: 1, to: 1 }), RangeError);
});

test("rates: slow, fast and invalid ones", async () => {
  const { world, media } = await ready({ count: 400 });
  media.playbackRate = 0.1;
  media.play();
  await world.advance(1000);
  assert.ok(Math.abs(media.currentTime - 0.1) < 0.01);
  media.playbackRate = 4;
  world.numbers();
  await world.advance(1000);
  assert.ok(Math.abs(media.currentTime - 4.1) < 0.05, `${media.currentTime}`);
  assert.throws(() => (media.playbackRate = -1), { name: "NotSupportedError" });
  assert.ok(world.take().includes("ratechange"));
});

test("slow showing drops frames and keeps the time", async () => {
  const { world, media } = await ready({ count: 200 });
  world.showMs = 90;
  media.play();
  await world.advance(4000);
  assert.ok(Math.abs(media.currentTime - 4) < 0.2, `${media.currentTime}`);
  assert.ok(media.meter.framesDropped > 30, `${media.meter.framesDropped} dropped`);
  assert.ok(world.mostOpen <= 2, `${world.mostOpen} open`);
});

test("dropped frames count as played, and the last frame is shown", async () => {
  const { world, media } = await ready();
  world.showMs = 90;
  media.playbackRate = 4;
  media.play();
  await world.advance(1000);
  assert.equal(media.ended, true);
  assert.ok(media.meter.framesDropped > 20);
  assert.equal(world.numbers().at(-1), 49);
  assert.equal(media.duration, 2);
  assert.equal(media.seekable.end(0), 2);
});

test("frames that lack pictures: requested again if they stay on screen, dropped during playback", async () => {
  const world = new World();
  const media = world.media();
  let times = 0;
  world.lost = (number) => number === 0 && times++ === 0;
  media.load("clip");
  await world.advance(60);
  assert.equal(world.seeks, 1);
  assert.deepEqual(world.numbers(), [0]);
  world.lost = (number) => number === 5;
  media.play();
  await world.advance(400);
  assert.deepEqual(world.numbers().slice(0, 7), [1, 2, 3, 4, 6, 7, 8]);
  // If there are never any pictures, as for an unknown codec, the mesh is shown anyway.
  world.lost = () => true;
  media.currentFrame = 20;
  await world.advance(100);
  assert.ok(world.numbers().includes(20));
  await world.advance(400);
  assert.ok(world.numbers().length > 5);
});

test("slow decoding skips groups and keeps the time", async () => {
  const { world, media } = await ready({ count: 400 });
  world.decodeMs = 80;
  media.play();
  await world.advance(8000);
  assert.ok(Math.abs(media.currentTime - 8) < 0.8, `${media.currentTime}`);
  assert.ok(media.meter.framesDropped > 50, `${media.meter.framesDropped} dropped`);
  assert.ok(world.shown.length > 50, `${world.shown.length} shown`);
});

test("where a slow machine skips groups the stage is not empty", async () => {
  const { world, media } = await ready({ count: 1000 });
  world.decodeMs = 450;
  world.showMs = 900;
  media.play();
  await world.advance(20000);
  const numbers = world.numbers();
  assert.ok(world.seeks > 5 && numbers.length > 10);
  assert.ok(!numbers.includes(null));
});

test("a pause while groups are skipped shows the frame of its time", async () => {
  const { world, media } = await ready({ count: 1000 });
  world.decodeMs = 80;
  media.play();
  for (let skips = 0; skips < 3; skips++) {
    // A group that is due is sought while nothing of it has come.
    const before = world.seeks;
    while (world.seeks === before) await world.advance(10);
    media.pause();
    await world.advance(1000);
    const late = media.currentTime - 0.04 * media.currentFrame;
    assert.ok(!media.seeking && late > -0.01 && late < 0.05, `${media.currentTime} s with frame ${media.currentFrame}`);
    media.play();
  }
});

test("playback waits for a missing frame", async () => {
  const { world, media } = await ready();
  media.play();
  await world.advance(200);
  world.take();
  world.decodeMs = 1000;
  await world.advance(400);
  assert.deepEqual(world.take(), ["waiting"]);
  const stuck = media.currentTime;
  await world.advance(200);
  assert.equal(media.currentTime, stuck);
  world.decodeMs = 0;
  await world.advance(800);
  assert.deepEqual(world.take().slice(0, 3), ["canplay", "playing", "canplaythrough"]);
  assert.ok(media.currentTime > stuck);
});

test("errors while opening, and during playback", async () => {
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
  await other.world.advance(300);
  assert.equal(other.media.error.code, 2);
  assert.equal(other.world.take().at(-1), "error");
});

test("another source: the former one is closed", async () => {
  const { world, media } = await ready();
  media.play();
  await world.advance(100);
  world.take();
  media.load("other");
  await world.advance(100);
  assert.deepEqual(world.take().slice(0, 4), ["abort", "emptied", "loadstart", "durationchange"]);
  assert.equal(world.decoders[0].closed, true);
  assert.equal(media.paused, true);
  media.load(null);
  await world.advance(20);
  assert.equal(world.open, 0);
  assert.equal(media.networkState, 0);
});

test("begins at a given position, without showing the first frame", async () => {
  const world = new World();
  const media = world.media();
  media.load("clip", { at: { frame: 30 } });
  await world.advance(60);
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

test("a step at the end or at the beginning stays there", async () => {
  const { world, media } = await ready();
  media.play();
  await world.advance(2500);
  assert.equal(media.ended, true);
  world.take();
  assert.equal(media.step(1), false);
  await world.advance(400);
  assert.deepEqual([media.currentTime, media.currentFrame, media.ended, media.seeking], [2, 49, true, false]);
  assert.deepEqual(world.take(), []);
  media.step(-1);
  await world.advance(400);
  assert.equal(media.currentFrame, 48);
  media.loop = true;
  media.currentFrame = 49;
  await world.advance(400);
  assert.equal(media.step(1), false);
  media.currentFrame = 0;
  await world.advance(400);
  assert.equal(media.step(-1), false);
  await world.advance(400);
  assert.equal(media.currentFrame, 0);
});

test("a source without seeking: steps forward only, loops by opening it again", async () => {
  const { world, media } = await ready({ count: 10, seekable: false });
  assert.equal(media.seekable.length, 0);
  assert.equal(media.step(-1), false);
  media.step(1);
  await world.advance(40);
  assert.equal(media.currentFrame, 1);
  media.loop = true;
  media.play();
  await world.advance(1000);
  assert.equal(world.decoders.length, 3);
  assert.ok(world.numbers().length > 20);
});

test("a source that is opened again is known: its address was right", async () => {
  const { world, media } = await ready({ seekable: false });
  media.loop = true;
  media.play();
  await world.advance(2600);
  assert.deepEqual(world.known.slice(0, 2), [false, true]);
  media.load("another");
  await world.advance(40);
  assert.equal(world.known.at(-1), false);
});

test("while suspended, as on a hidden page, time stands still and no events are dispatched", async () => {
  const { world, media } = await ready();
  media.play();
  await world.advance(200);
  world.take();
  media.suspended = true;
  const at = media.currentTime;
  await world.advance(1000);
  assert.equal(media.currentTime, at);
  assert.deepEqual(world.take(), []);
  media.suspended = false;
  await world.advance(100);
  assert.ok(media.currentTime > at);
});

const pairs = (ranges) => Array.from({ length: ranges.length }, (_, i) => [ranges.start(i), ranges.end(i)]);

test("buffered ranges: the decoder's cache and decoded frames, joined if they touch", async () => {
  const { world, media } = await ready();
  const [decoder] = world.decoders;
  // The frame on screen and the next one.
  assert.deepEqual(pairs(media.buffered), [[0, 0.08]]);
  decoder.bufferedTimes = [
    { start: 10n, end: 20n },
    { start: 40n, end: 50n },
  ];
  await media.measure();
  assert.deepEqual(pairs(media.buffered), [
    [0, 0.08],
    [0.4, 0.8],
    [1.6, 2],
  ]);
  assert.ok(Math.abs(media.buffered.ahead(0.5) - 0.3) < 1e-9);
  assert.equal(media.buffered.ahead(1), 0);
  decoder.bufferedTimes = [
    { start: 2n, end: 40n },
    { start: 40n, end: 50n },
  ];
  await media.measure();
  assert.deepEqual(pairs(media.buffered), [[0, 2]]);
});

test("a source whose length is known at its end: seeks in the received part, then in all of it, and loops", async () => {
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
  await world.advance(400);
  decoder.bufferedTimes = [{ start: 0n, end: 15n }];
  await media.measure();
  assert.deepEqual(pairs(media.seekable), [[0, 0.6]]);
  media.currentTime = 0.2;
  await world.advance(60);
  assert.ok(media.currentTime < 0.3);
  media.step(-1);
  await world.advance(400);
  assert.equal(media.currentFrame, world.numbers().at(-1));
  media.loop = true;
  media.play();
  Object.assign(decoder, decoder.whole);
  decoder.dispatchEvent(new Event("groups"));
  await world.advance(40);
  assert.equal(media.duration, 2);
  assert.ok(world.take().includes("durationchange"));
  assert.deepEqual(pairs(media.seekable), [[0, 2]]);
  await world.advance(2400);
  assert.equal(world.decoders.length, 1);
  const numbers = world.numbers();
  assert.ok(numbers.includes(49) && numbers.lastIndexOf(0) > numbers.indexOf(49), `${numbers}`);
});

test("where no group has a mesh the stage is empty: between groups, before their first frame, at the end", async () => {
  // Meshes at ticks 0 to 9 and 15 to 24, none at 10 to 14 and 25 to 29.
  const groups = [
    { start: 0, end: 10, count: 10 },
    { start: 10, end: 25, first: 15, count: 10 },
    { start: 25, end: 30, count: 0 },
  ];
  const { world, media } = await ready({ count: 20, groups });
  assert.equal(media.duration, 1.2);
  const began = world.now;
  media.play();
  await world.advance(1400);
  assert.equal(media.ended, true);
  assert.equal(media.currentTime, 1.2);
  const shown = world.shown.splice(0);
  assert.deepEqual(
    shown.map(({ number }) => number),
    [...numbersTo(10), null, ...numbersTo(20, 10), null],
  );
  for (const [index, tick] of [
    [10, 10],
    [11, 15],
    [21, 25],
  ]) {
    const late = shown[index].at - began - 40 * tick;
    assert.ok(late >= -4 && late <= 20, `picture ${index} is ${late} ms late`);
  }
  for (const [seconds, expected] of [
    [0.48, [null]],
    [0.2, [5]],
    [1.08, [19, null]],
  ]) {
    media.currentTime = seconds;
    await world.advance(100);
    assert.equal(media.currentTime, seconds);
    assert.deepEqual(world.numbers().slice(-expected.length), expected);
  }
});

/** Real time, which attempts for a frame that stays on screen take. */
async function linger(world, milliseconds) {
  await new Promise((done) => setTimeout(done, milliseconds));
  await world.advance(40);
}

test("a frame that stays on screen is requested again in the best rung that the network carries", async () => {
  const world = new World();
  Object.assign(world, { rung: 2, lastingRung: null });
  const media = world.media();
  media.load("clip");
  await world.advance(40);
  media.uncover();
  media.play();
  await world.advance(400);
  media.pause();
  await world.advance(40);
  const { number } = world.shown.at(-1);
  await linger(world, 300);
  assert.equal(world.seeks, 0, "nothing is known of the network");
  Object.assign(world, { rung: 1, lastingRung: 1 });
  await linger(world, 600);
  const { at, ...shown } = world.shown.at(-1);
  assert.deepEqual(shown, { number, rung: 1, pictures: 1 });
  assert.equal(world.seeks, 1);
  assert.equal(media.seeking, false);
  // Playback goes on with the next frame, and nothing is requested twice.
  world.take();
  world.numbers();
  media.play();
  await world.advance(200);
  assert.deepEqual(world.numbers().slice(0, 3), numbersTo(number + 4, number + 1));
  assert.deepEqual(world.take(), ["play", "playing"]);
  assert.ok(world.mostOpen <= 2, `${world.mostOpen} open`);
});

test("a frame that comes again no better is not shown, and not requested once more", async () => {
  const world = new World();
  Object.assign(world, { rung: 2, lastingRung: 0 });
  const media = world.media();
  media.load("clip");
  await world.advance(40);
  await linger(world, 300);
  await linger(world, 600);
  assert.deepEqual(world.numbers(), [0]);
  assert.equal(world.seeks, 2, "once while it is covered, and once while it stays");
  media.play();
  await world.advance(100);
  assert.deepEqual(world.numbers().slice(0, 2), [1, 2]);
});

test("the first frame of a ladder is not seen before it has come in the best rung that the network carries", async () => {
  for (const at of [null, { frame: 3 }]) {
    const world = new World();
    world.rung = 2;
    // What is known of the network grows.
    const known = [null, null, 1, 0];
    Object.defineProperty(world, "lastingRung", {
      get: () => {
        const [first] = known.length > 1 ? known.splice(0, 1) : known;
        if (first !== null) world.rung = first;
        return first;
      },
    });
    const media = world.media();
    media.autoplay = true;
    media.load("clip", { at });
    await world.advance(40);
    assert.deepEqual(world.shown, [{ number: at?.frame ?? 0, rung: 2, pictures: 1, at: world.shown[0].at }]);
    assert.ok(!world.take().includes("loadeddata"), "it is covered while nothing is known of the network");
    assert.equal(media.paused, true);
    await linger(world, 60);
    await linger(world, 60);
    const rungs = world.shown.filter(({ number }) => number === (at?.frame ?? 0)).map(({ rung }) => rung);
    assert.deepEqual(rungs, [2, 1, 0]);
    await world.advance(100);
    assert.deepEqual(
      world.take().filter((type) => ["loadeddata", "canplay", "play", "playing", "seeked", "waiting"].includes(type)),
      at ? ["loadeddata", "seeked", "canplay", "play", "playing"] : ["loadeddata", "canplay", "play", "playing"],
    );
    assert.ok(world.numbers().at(-1) > (at?.frame ?? 0), "playback has begun");
    assert.ok(world.mostOpen <= 2, `${world.mostOpen} open`);
  }
});

test("the first frame is seen as it is after a second, when the viewer acts, seeks, or asks for its rung", async () => {
  for (const way of ["time", "acts", "seeks", "rung", "play"]) {
    const world = new World();
    // Nothing better comes, though it is promised.
    Object.assign(world, { rung: 2, lastingRung: null });
    const media = world.media({ prepare: (decoder) => way === "rung" && (decoder.rung = 2) });
    media.load("clip");
    if (way === "play") media.play();
    await world.advance(40);
    if (way !== "rung") assert.ok(!world.take().includes("loadeddata"), way);
    if (way === "acts") media.uncover();
    if (way === "seeks") media.currentFrame = 7;
    if (way === "time" || way === "play") {
      await linger(world, 700);
      assert.ok(!world.take().includes("loadeddata"), way);
      await linger(world, 400);
    }
    await world.advance(40);
    assert.ok(world.take().includes("loadeddata"), way);
    assert.equal(world.shown.at(-1).number, way === "seeks" ? 7 : way === "play" ? world.shown.length - 1 : 0);
    media.reset();
  }
});

test("a place that is sought at loadedmetadata is reached, while the first frame of a ladder is drawn", async () => {
  for (const seconds of [1.1, 0.04]) {
    const world = new World();
    Object.assign(world, { rung: 2, lastingRung: null, showMs: 30 });
    const media = world.media();
    media.addEventListener("loadedmetadata", () => (media.currentTime = seconds));
    media.load("clip");
    await linger(world, 200);
    await world.advance(400);
    assert.equal(media.seeking, false);
    assert.equal(world.shown.at(-1).number, Math.floor(25 * seconds + 0.001));
  }
});

test("another rung is drawn at once while paused", async () => {
  const { world, media } = await ready();
  await linger(world, 10);
  Object.assign(world, { rung: 2, lastingRung: 2 });
  world.decoders[0].rung = 2;
  media.improve();
  await world.advance(40);
  const { at, ...shown } = world.shown.at(-1);
  assert.deepEqual(shown, { number: 0, rung: 2, pictures: 1 });
});

test("pictures that a decoder lost are requested again while paused, unless no decoder knows the codec", async () => {
  for (const unsupported of [false, true]) {
    const world = new World();
    let left = 3;
    world.lost = () => left-- > 0;
    const media = world.media();
    media.load("clip");
    await world.advance(40);
    if (unsupported)
      world.decoders[0].dispatchEvent(Object.assign(new Event("warning"), { detail: { code: "unsupported" } }));
    // The first frame was requested twice before it was shown without its picture; the next one is lost, too.
    left = 1;
    await linger(world, 300);
    await linger(world, 600);
    assert.equal(world.shown.at(-1).pictures, unsupported ? 0 : 1);
    assert.equal(world.shown.at(-1).number, 0);
    const { seeks } = world;
    await linger(world, 300);
    assert.equal(world.seeks, seeks);
  }
});

test("a hidden page asks for nothing", async () => {
  const world = new World();
  Object.assign(world, { rung: 2, lastingRung: null });
  const media = world.media();
  media.load("clip");
  await world.advance(40);
  media.uncover();
  world.lastingRung = 0;
  media.suspended = true;
  await linger(world, 300);
  assert.equal(world.seeks, 0);
  media.suspended = false;
  await linger(world, 300);
  assert.equal(world.seeks, 1);
});
