// Selection of video tracks: which bytes are fetched, from which frame on, and that frames are otherwise unchanged.

import assert from "node:assert/strict";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { camerasFor, createDecoder, FvvError } from "../dist/index.js";
import { ByteRanges } from "../dist/sources/byte_ranges.js";
import { damaged, joinStreams } from "./edit_streams.mjs";
import { environmentHashes, frameHashes, makeClips, nativeEnvironment, nativeFrames, tool } from "./native.mjs";
import { serve } from "./server.mjs";

const { clips, done } = makeClips("tracks", "neighbours");
const server = await serve(clips);
after(() => {
  server.close();
  done();
});
const url = (name = "tracks") => `${server.url}/range/${name}`;
const size = statSync(clips.tracks).size;

/** The expected hashes of a frame if these tracks of video are selected. */
const without = (hashes, tracks) =>
  Object.fromEntries(
    Object.entries(hashes).filter(([what]) => {
      const [kind, id] = what.split(" ");
      return !["key", "sample", "tiles"].includes(kind) || tracks.includes(Number(id));
    }),
  );

async function play(decoder) {
  const frames = [];
  for await (const frame of decoder) frames.push({ tracks: frame.tracks, hashes: frameHashes(frame) });
  return frames;
}

const text = (hashes) => JSON.stringify(Object.entries(hashes).sort());

function listen(decoder) {
  const reports = [];
  const kinds = ["damage", "gap", "warning", "configuration", "environment"];
  onReports(decoder, kinds, (type, detail) => reports.push({ type, detail }));
  return reports;
}

/** Requests since then, and the number of bytes that they requested: [requests, bytes]. */
function asked(since) {
  const ranges = server.requests.slice(since).map((line) => /bytes=(\d*)-(\d*)/.exec(line).slice(1));
  return [ranges.length, ranges.reduce((sum, [from, to]) => sum + (from === "" ? Number(to) : to - from + 1), 0)];
}

const expected = nativeFrames(clips.tracks);
const all = Object.keys(expected[0])
  .filter((what) => what.startsWith("key "))
  .map((what) => Number(what.split(" ")[1]));

test("the clip has a track for each camera", () => assert.equal(all.length, 5));

for (const tracks of [[all[0]], [all[1], all[3]], []])
  test(`${tracks.length} of 5 tracks from the first frame on: the others are not fetched`, async () => {
    const before = server.requests.length;
    const decoder = await createDecoder({ source: url(), tracks });
    const reports = listen(decoder);
    const frames = await play(decoder);
    assert.deepEqual(
      frames.map(({ hashes }) => hashes),
      expected.map((hashes) => without(hashes, tracks)),
    );
    for (const frame of frames) assert.deepEqual(frame.tracks, tracks);
    assert.deepEqual(
      reports.map(({ type }) => type),
      ["configuration", "environment"],
    );
    assert.deepEqual(environmentHashes(decoder.environments[0]), nativeEnvironment(clips.tracks));
    const [requests, bytes] = asked(before);
    const stats = await decoder.stats();
    assert.equal(stats.requests, requests);
    assert.equal(stats.bytesRead, bytes);
    // Meshes, visibility and the environment are always fetched, and small gaps are bridged.
    const samples = nativeSampleBytes(tracks);
    console.log(`${tracks.length} of 5 tracks: ${bytes} of ${size} bytes, ${requests} requests, 5 frames, 3 groups`);
    assert.ok(bytes < size - (samples.all - samples.selected) / 4, `${bytes} of ${size} bytes`);
    // Beginning, index, a table per group, and per frame at most a part with its mesh and one per track.
    assert.ok(requests <= 4 + 3 + (1 + tracks.length) * 5, `${requests} requests`);
    decoder.close();
  });

/** Bytes of samples in the file, of all tracks and of some. */
function nativeSampleBytes(tracks) {
  const bytes = readFileSync(clips.tracks);
  const sums = { all: 0, selected: 0 };
  for (let at = 24; at < bytes.length;) {
    const length = bytes.readUInt32LE(at + 16);
    if (bytes.toString("latin1", at, at + 4) === "VPKT") {
      sums.all += length;
      if (tracks.includes(bytes.readUInt16LE(at + 6))) sums.selected += length;
    }
    at += 32 + 8 * Math.ceil(length / 8);
  }
  return sums;
}

test("a selection takes effect with the next group, however it changes", async () => {
  const decoder = await createDecoder({ source: url(), queue: 1 });
  const reports = listen(decoder);
  const selections = [null, [all[2]], [all[0], all[2]], null];
  let changed = 0;
  for (let round = 1; round < selections.length; round++) {
    await decoder.seek({ frame: 0 });
    const seen = [];
    for (let n = 0; n < 5; n++) {
      const frame = await decoder.next();
      if (n === 0) await decoder.select({ tracks: selections[round] });
      assert.deepEqual(frameHashes(frame), without(expected[n], frame.tracks ?? all), `frame ${n}`);
      seen.push(JSON.stringify(frame.tracks));
    }
    // Within a group nothing changes, and the group after the current one has the new selection at the latest.
    assert.equal(seen[0], seen[1]);
    assert.equal(seen[2], seen[3]);
    assert.equal(seen[4], JSON.stringify(selections[round]));
    assert.equal(seen[0], JSON.stringify(selections[round - 1]));
    changed += seen[0] !== seen[4];
  }
  assert.equal(changed, 3);
  assert.deepEqual(
    reports.filter(({ type }) => type !== "configuration" && type !== "environment"),
    [],
  );
  decoder.close();
});

test("seeking with a selection", async () => {
  const tracks = [all[4]];
  const decoder = await createDecoder({ source: url(), tracks });
  for (const n of [4, 1, 3, 0, 2]) {
    await decoder.seek({ frame: n });
    const frame = await decoder.next();
    assert.equal(frame.number, n);
    assert.deepEqual(frameHashes(frame), without(expected[n], tracks));
    await decoder.seek({ time: frame.time });
    const rest = await play(decoder);
    assert.deepEqual(
      rest.map(({ hashes }) => hashes),
      expected.slice(n).map((hashes) => without(hashes, tracks)),
    );
  }
  assert.equal(decoder.environments.length, 1);
  decoder.close();
});

test("sources without parts: unselected tracks are left out of frames", async () => {
  const tracks = [all[1]];
  const bytes = new Uint8Array(readFileSync(clips.tracks));
  const stream = async function* () {
    yield bytes;
  };
  for (const source of [bytes, new Blob([bytes]), stream(), `${server.url}/whole/tracks`]) {
    const decoder = await createDecoder({ source, tracks });
    const reports = listen(decoder);
    const frames = await play(decoder);
    assert.deepEqual(
      frames.map(({ hashes }) => hashes),
      expected.map((hashes) => without(hashes, tracks)),
    );
    assert.deepEqual(
      reports.filter(({ type }) => type === "damage" || type === "gap"),
      [],
    );
    decoder.close();
  }
});

test("a viewpoint selects the tracks that it needs", async () => {
  const target = [0, 1, 0];
  const plain = await createDecoder({ source: url("neighbours") });
  const first = await plain.next();
  const [camera] = first.cameras;
  const look = { eye: camera.centre, target };
  // Seen from the position of a camera, that camera has the largest share; more distant cameras have smaller ones.
  const needed = camerasFor(first.cameras, look);
  assert.equal(needed[0].camera, camera.id);
  assert.ok(needed.length < first.cameras.length);
  const every = camerasFor(first.cameras, { ...look, share: 1 });
  assert.ok(Math.abs(every.reduce((sum, { share }) => sum + share, 0) - 1) < 1e-9);
  assert.deepEqual(every.slice(0, needed.length), needed);
  // A camera on the opposite side sees nothing that is visible from the front.
  const opposite = camerasFor(first.cameras, { eye: camera.centre.map((x, i) => 2 * target[i] - x), target, share: 1 });
  assert.ok(!opposite.some((one) => one.camera === camera.id));
  assert.deepEqual(camerasFor(first.cameras, { eye: camera.centre, target: [0, 500, 0] }), []);
  assert.throws(() => camerasFor(first.cameras, { eye: target, target }), TypeError);
  assert.throws(() => camerasFor(first.cameras, { eye: [1, 2], target }), TypeError);
  const { videos } = first.configuration;
  const tracks = videos.filter((v) => v.tiles.some((tile) => needed.some((one) => one.camera === tile.camera)));
  const wanted = tracks.map(({ track }) => track);
  assert.ok(wanted.length < videos.length);
  assert.deepEqual(await plain.look(look), { cameras: needed, tracks: wanted });
  let last;
  for await (const frame of plain) last = frame;
  assert.deepEqual(last.tracks, wanted);
  plain.close();

  // From the first frame on, with and without an index.
  for (const [source, tracksOfFirst] of [
    [url("neighbours"), wanted],
    [`${server.url}/whole/neighbours`, null],
  ]) {
    const decoder = await createDecoder({ source, look, queue: 1 });
    const frames = [];
    for await (const frame of decoder) frames.push(frame);
    assert.deepEqual(frames[0].tracks, tracksOfFirst);
    assert.deepEqual(frames.at(-1).tracks, wanted);
    decoder.close();
  }
  await assert.rejects(plain.select({ tracks: "2" }), { code: "argument" });
});

test("damage in fetched chunks is a gap, in other chunks it has no effect", async () => {
  const bytes = readFileSync(clips.tracks);
  const tracks = [all[0]];
  const places = {};
  for (let at = 24; at < bytes.length; at += 32 + 8 * Math.ceil(bytes.readUInt32LE(at + 16) / 8)) {
    const type = bytes.toString("latin1", at, at + 4);
    // Of the second group, the first chunk of each kind.
    const time = Number(bytes.readBigInt64LE(at + 8));
    const name = type === "VPKT" ? `${type} ${bytes.readUInt16LE(at + 6)}` : type;
    if (time >= 2 && time <= 4 && type !== "SCEN") places[name] ??= at;
  }
  const kinds = {
    missing: places[`VPKT ${all[1]}`],
    sample: places[`VPKT ${all[0]}`],
    mesh: places.MESH,
    table: places.GEND,
    group: places.GRUP,
  };
  for (const [name, at] of Object.entries(kinds)) {
    const flipped = Buffer.from(bytes);
    flipped[at + 40] ^= 1;
    const path = `${clips.tracks}.${name}`;
    writeFileSync(path, flipped);
    const host = await serve({ damaged: path });
    const decoder = await createDecoder({ source: `${host.url}/range/damaged`, tracks });
    const reports = listen(decoder);
    const frames = await play(decoder);
    const types = reports.map(({ type }) => type).filter((type) => type === "damage" || type === "gap");
    const good = expected.map((hashes) => text(without(hashes, tracks)));
    for (const { hashes } of frames) assert.ok(good.includes(text(hashes)), `${name}: a wrong frame`);
    if (name === "missing") assert.deepEqual([frames.length, types], [5, []]);
    else assert.ok(types.includes("damage"), `${name}: ${types}`);
    // GEND follows the frames of its group, which were complete before.
    if (name === "sample" || name === "mesh" || name === "group")
      assert.deepEqual([frames.length, types.at(-1)], [3, "gap"], name);
    decoder.close();
    host.close();
  }
});

test("a change of configuration: tracks are selected again", async () => {
  const path = `${clips.tracks}.changing`;
  writeFileSync(path, joinStreams(readFileSync(clips.neighbours), readFileSync(clips.tracks), 1));
  tool("fvvinfo", "--check", path);
  const whole = nativeFrames(path);
  const host = await serve({ changing: path });
  const eye = [3, 1, 0.5];
  for (const start of [0, 1, 2, 4]) {
    const before = host.requests.length;
    const decoder = await createDecoder({
      source: `${host.url}/range/changing`,
      look: { eye, target: [0, 1, 0] },
      queue: 1,
    });
    const reports = listen(decoder);
    if (start) await decoder.seek({ frame: start });
    const frames = await play(decoder);
    assert.deepEqual(
      frames.map(({ hashes }) => hashes),
      whole.slice(start).map((hashes, i) => without(hashes, frames[i].tracks ?? all)),
    );
    assert.deepEqual(
      reports.filter(({ type }) => type === "damage" || type === "gap"),
      [],
    );
    const counts = reports.filter(({ type }) => type === "configuration").map(({ detail }) => detail.videos.length);
    assert.deepEqual(counts, start < 2 ? [3, 5] : [5]);
    const { videos } = decoder.configuration;
    const shown = videos.filter(({ track }) => frames.at(-1).tracks.includes(track));
    assert.ok(shown.length > 0 && shown.length < videos.length, `frame ${start}: ${shown.length} tracks`);
    // The environment belongs to the first configuration.
    const environments = reports.filter(({ type }) => type === "environment").map(({ detail }) => detail.length);
    assert.deepEqual(environments, start < 2 ? [1, 0] : []);
    assert.ok(host.requests.length > before);
    decoder.close();
  }
  host.close();
});

test("damage anywhere: no wrong frame, and only FvvErrors are thrown", async () => {
  const path = `${clips.neighbours}.damaged`;
  const host = await serve({ damaged: path });
  const [track] = Object.keys(nativeFrames(clips.neighbours)[0])
    .filter((what) => what.startsWith("key "))
    .map((what) => Number(what.split(" ")[1]));
  const good = new Set(nativeFrames(clips.neighbours).map((hashes) => text(without(hashes, [track]))));
  let frames = 0;
  let corrupt = 0;
  for (const bytes of damaged(new Uint8Array(readFileSync(clips.neighbours)), 45)) {
    writeFileSync(path, bytes);
    try {
      const decoder = await createDecoder({
        source: `${host.url}/range/damaged`,
        tracks: [track],
      });
      const reports = listen(decoder);
      for await (const frame of decoder) {
        assert.ok(good.has(text(frameHashes(frame))), "a wrong frame");
        frames++;
      }
      corrupt += reports.some(({ type }) => type === "damage");
      decoder.close();
    } catch (error) {
      if (!(error instanceof FvvError)) throw error;
    }
  }
  host.close();
  assert.ok(frames > 50 && corrupt > 10, `${frames} frames, ${corrupt} streams with reported damage`);
});

test("bytes that arrive while a frame waits to be taken are used", async () => {
  const source = {
    async *range(from, end) {
      for (let at = from; at < end; at += 50) {
        yield new Uint8Array(50);
        await new Promise((done) => setTimeout(done, 1));
      }
    },
  };
  const ranges = new ByteRanges(source);
  let seen = 0;
  for await (const _ of ranges.fetch([{ from: 0, end: 100 }])) {
    seen = [...ranges].at(-1).bytes.length;
    await new Promise((done) => setTimeout(done, 20));
  }
  assert.equal(seen, 100);
});
