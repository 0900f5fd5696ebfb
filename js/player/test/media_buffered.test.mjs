// What is buffered and what can be sought in, with a decoder of numbers and time by hand.

import assert from "node:assert/strict";
import { test } from "node:test";

import { ready } from "./fake_decoder.mjs";

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
