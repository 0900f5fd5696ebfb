// Which tracks of video a viewer gets who walks, jumps or stands, by a decoder that records what it is asked.

import assert from "node:assert/strict";
import { test } from "node:test";

import { coverage, ViewpointTracks } from "../src/playback/viewpoint_tracks.js";

const COUNT = 12;
const texturing = { blend: "viewer", threshold: 0.05, best: 3 };

/** Cameras on a circle of 5 m, each in a track of its own, that see the middle. */
const cameras = Array.from({ length: COUNT }, (_, id) => {
  const angle = (2 * Math.PI * id) / COUNT;
  const centre = [5 * Math.sin(angle), 1, 5 * Math.cos(angle)];
  return { id, calibrated: true, width: 100, height: 100, centre, project: () => [50, 50, 5] };
});
const videos = cameras.map(({ id }) => ({ track: 10 + id, shows: "tiles", tiles: [{ camera: id }] }));
const configuration = { videos, texturing, timeBase: { numerator: 1, denominator: 25 } };
const group = { sequence: 0, start: 0n, end: 25n };
const frameOf = (tracks, sequence = 0) => ({
  cameras,
  tracks,
  rung: null,
  configuration,
  group: { ...group, sequence },
});
const target = [0, 1, 0];
const at = (angle) => ({ eye: [4 * Math.sin(angle), 1, 4 * Math.cos(angle)], target });

function recorder() {
  const calls = [];
  const decoder = {
    seekable: true,
    rungs: [],
    look: async (view) => calls.push(view),
    select: async ({ tracks }) => calls.push({ tracks }),
  };
  return { calls, decoder, choice: new ViewpointTracks(decoder) };
}

test("the coverage of a picture by the cameras of a frame", () => {
  assert.equal(coverage(frameOf(null), at(0)), 1);
  assert.ok(coverage(frameOf([10, 11, 21]), at(0)) > 0.95);
  assert.ok(coverage(frameOf([16]), at(0)) < 0.01);
});

test("a viewer who stands is looked for once in a group, without a margin", async () => {
  const { calls, choice } = recorder();
  for (let now = 0; now < 200; now += 40) assert.equal(await choice.follow(frameOf(null), at(0), now), false);
  assert.deepEqual(calls, [{ ...at(0), margin: 0 }]);
  await choice.follow(frameOf([10, 11, 21], 1), at(0), 210);
  assert.equal(calls.length, 2);
});

test("a viewer who walks gets the cameras of where the group may end", async () => {
  const { calls, choice } = recorder();
  const speed = 1.4;
  for (let now = 0; now <= 1500; now += 40) await choice.follow(frameOf(null), at((speed / 4) * (now / 1000)), now);
  const { margin } = calls.at(-1);
  assert.ok(Math.abs(margin / 1.4 - speed) < 0.1, `${margin} m in 1.4 s`);
  assert.ok(Math.abs(choice.speed(1500) - speed) < 0.1);
});

test("a viewer who jumps gets the frame again, once, and no margin of the jump", async () => {
  const { calls, choice } = recorder();
  await choice.follow(frameOf([10, 11, 21]), at(0), 0);
  assert.equal(await choice.follow(frameOf([10, 11, 21]), at(Math.PI), 40), true);
  assert.deepEqual(calls.at(-1), { ...at(Math.PI), margin: 0 });
  assert.equal(await choice.follow(frameOf([10, 11, 21]), at(Math.PI), 80), false, "it is on its way");
  assert.equal(await choice.follow(frameOf([15, 16, 17]), at(Math.PI), 120), false);
  assert.equal(await choice.follow(frameOf([15, 16, 17]), at(0), 160), true, "another jump");
});

test("what shows all cameras gets all tracks", async () => {
  const { calls, choice } = recorder();
  await choice.follow(frameOf([10, 11, 21]), at(0), 0);
  assert.equal(await choice.follow(frameOf([10, 11, 21]), at(0), 40, false), true);
  assert.deepEqual(calls.at(-1), { tracks: null });
  assert.equal(await choice.follow(frameOf(null), at(0), 80, false), false);
});

test("one track, and a source that cannot be sought in, leave nothing to choose", async () => {
  const { calls, choice, decoder } = recorder();
  const one = { ...frameOf(null), configuration: { ...configuration, videos: videos.slice(0, 1) } };
  assert.equal(await choice.follow(one, at(0), 0), false);
  decoder.seekable = false;
  assert.equal(await choice.follow(frameOf(null), at(0), 0), false);
  decoder.seekable = true;
  // A ladder: each rung has one track.
  decoder.rungs = videos.map(({ track }, rung) => ({ rung, tracks: [track] }));
  assert.equal(await choice.follow({ ...frameOf([10]), rung: 0 }, at(Math.PI), 0), false);
  assert.deepEqual(calls, []);
});
