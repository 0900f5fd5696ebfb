// Received bytes are not fetched again in loops and seeks, within a limit; damaged bytes are never kept.

import assert from "node:assert/strict";
import { cpSync, mkdtempSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { createDecoder } from "../dist/index.js";
import { Cache } from "../dist/sources/cache.js";
import { frameHashes, makeClips, nativeFrames, tool } from "./native.mjs";
import { serve } from "./server.mjs";

const { clips, done } = makeClips("moving", "tracks", "raw");
const folder = mkdtempSync(join(tmpdir(), "fvv-cache-"));
const files = { ...clips };
for (const clip of ["moving", "raw"]) {
  tool("fvvmux", clips[clip], "--segments", join(folder, clip));
  for (const name of readdirSync(join(folder, clip))) files[`${clip}/${name}`] = join(folder, clip, name);
}
const server = await serve(files);
after(() => {
  server.close();
  done();
  rmSync(folder, { recursive: true });
});

const expected = nativeFrames(clips.moving);
const size = statSync(clips.moving).size;
const DURATION = (await (await createDecoder({ source: readFileSync(clips.moving) })).next()).configuration
  .frameDuration;

async function open(path, options = {}) {
  const decoder = await createDecoder({ source: `${server.url}/${path}`, ...options });
  const reports = [];
  onReports(decoder, ["damage", "gap", "warning", "groups"], (type, detail) => reports.push({ type, detail }));
  return { decoder, reports };
}

async function play(decoder) {
  const all = [];
  for await (const frame of decoder) all.push(frameHashes(frame));
  return all;
}
async function from(decoder, place) {
  await decoder.seek(place);
  return play(decoder);
}

const text = (hashes) => JSON.stringify(Object.entries(hashes).sort());

/** Times of groups that follow each other, as one range of ticks. */
const span = (groups) => [{ start: groups[0].start, end: groups.at(-1).end }];

/** The clip's frames follow each other without gaps. */
const nativeTime = (number) => BigInt(number) * DURATION;

/** The requests that act makes. */
async function requestsOf(act) {
  const before = server.requests.length;
  await act();
  return server.requests.slice(before);
}

const bytes = (from, end) => Uint8Array.from({ length: end - from }, (_, i) => (from + i) % 251);

test("the cache returns what was put, stores nothing twice, and evicts the least recently read unit", () => {
  let limit = 1000;
  const cache = new Cache(() => limit);
  cache.divide([100, 300, 500]);
  for (const [at, end] of [
    [110, 150],
    [100, 130],
    [140, 310],
    [700, 720],
    [505, 506],
  ])
    cache.put(at, bytes(at, end));
  assert.equal(cache.bytes, 210 + 20 + 1);
  for (let at = 100; at < 310;) {
    const piece = cache.take(at, 310);
    assert.deepEqual(piece, bytes(at, at + piece.length));
    at += piece.length;
  }
  assert.equal(cache.take(310, 400), null);
  assert.equal(cache.take(99, 120), null);
  assert.deepEqual(
    [cache.coveredUntil(100, 1000), cache.coveredUntil(100, 200), cache.coveredUntil(50, 90)],
    [310, 200, 50],
  );
  // A gap ends at 20 contiguous bytes if at least 20 are requested; bytes up to the end always end it.
  assert.deepEqual(
    [cache.missingUntil(310, 1000, 20), cache.missingUntil(310, 1000, 21), cache.missingUntil(310, 720, 21)],
    [700, 1000, 700],
  );
  const copied = new Uint8Array(200);
  assert.equal(cache.copy(105, copied), true);
  assert.deepEqual(copied, bytes(105, 305));
  assert.equal(cache.copy(305, copied), false);
  cache.take(505, 506);
  cache.take(100, 200);
  limit = 225;
  cache.put(20, bytes(20, 24));
  // The unit of 300 was read before those of 500 and 100.
  assert.deepEqual(
    [cache.coveredUntil(300, 310), cache.coveredUntil(700, 720), cache.coveredUntil(100, 300)],
    [300, 720, 300],
  );
  assert.equal(cache.bytes, 200 + 20 + 1 + 4);
  limit = 210;
  cache.evict();
  assert.deepEqual([cache.coveredUntil(700, 720), cache.coveredUntil(20, 24), cache.bytes], [700, 24, 204]);
  cache.drop(150);
  assert.equal(cache.bytes, 4);
  limit = 0;
  cache.put(0, bytes(0, 4));
  cache.evict();
  assert.equal(cache.bytes, 0);
});

test("pieces of a byte take at most twice their size", () => {
  const cache = new Cache(() => 1e6);
  for (let at = 0; at < 100000; at++) cache.put(at, bytes(at, at + 1));
  assert.ok(cache.bytes < 200000, `${cache.bytes} bytes`);
  const out = new Uint8Array(100000);
  assert.ok(cache.copy(0, out));
  assert.deepEqual(out, bytes(0, 100000));
});

for (const [path, requests] of [
  ["range/moving", 3],
  ["whole/moving/manifest.json", 4],
])
  test(`${path}: a second loop and seeks make no requests`, async () => {
    const { decoder, reports } = await open(path);
    assert.deepEqual(await play(decoder), expected);
    const first = await decoder.stats();
    assert.equal(first.requests, requests);
    assert.deepEqual([first.cacheHits, first.bytesReused], [0, 0]);
    assert.ok(first.cachedBytes > 0.5 * size && first.cachedBytes < 2 * size, `${first.cachedBytes} of ${size} bytes`);
    assert.deepEqual(await decoder.buffered(), span(decoder.groups));
    const again = await requestsOf(async () => {
      for (let round = 0; round < 2; round++) assert.deepEqual(await from(decoder, { frame: 0 }), expected);
      for (const n of [4, 1, 3]) assert.deepEqual(await from(decoder, { frame: n }), expected.slice(n));
    });
    assert.deepEqual(again, []);
    const then = await decoder.stats();
    assert.equal(then.bytesRead, first.bytesRead);
    assert.equal(then.cachedBytes, first.cachedBytes);
    assert.ok(then.cacheHits >= 5 && then.bytesReused > size, `${then.cacheHits} hits, ${then.bytesReused} bytes`);
    assert.deepEqual(reports, []);
    decoder.close();
    assert.equal((await decoder.stats()).cachedBytes, 0);
  });

test("the buffered times during playback begin where it began; the missing bytes are one request", async () => {
  const all = nativeFrames(clips.raw);
  const { decoder } = await open("range/raw", { queue: 1 });
  const [first, second] = decoder.groups;
  const place = { frame: first.frameCount };
  await decoder.seek(place);
  (await decoder.next()).close();
  const { start, end } = (await decoder.buffered()).at(-1);
  assert.equal(start, second.start);
  assert.ok(end > start && end < second.end, `up to ${end}`);
  assert.deepEqual(await from(decoder, place), all.slice(place.frame));
  const buffered = await decoder.buffered();
  assert.deepEqual(buffered.at(-1), span([second])[0]);
  assert.ok(buffered.length === 1 || buffered[0].end < first.end);
  const asked = await requestsOf(async () => assert.deepEqual(await from(decoder, { frame: 0 }), all));
  assert.equal(asked.length, 1);
  assert.ok(Number(/-(\d+)$/.exec(asked[0])[1]) < second.offset, asked[0]);
  assert.deepEqual(await decoder.buffered(), span(decoder.groups));
  decoder.close();
});

for (const path of ["range/raw", "whole/raw/manifest.json"])
  test(`${path}: the limit holds, and evicted bytes are fetched again`, async () => {
    const all = nativeFrames(clips.raw);
    const groups = (await open("range/raw")).decoder.groups;
    const cacheBytes = Math.max(...groups.map((group) => group.size)) + 20000;
    assert.ok(cacheBytes < groups.reduce((sum, group) => sum + group.size, 0));
    const { decoder } = await open(path, { limits: { cacheBytes }, queue: 1 });
    for (let round = 0; round < 2; round++) {
      const asked = await requestsOf(async () => {
        await decoder.seek({ frame: 0 });
        for (let n = 0; n < all.length; n++) {
          const frame = await decoder.next();
          assert.deepEqual(frameHashes(frame), all[n]);
          const { cachedBytes } = await decoder.stats();
          assert.ok(cachedBytes <= cacheBytes, `${cachedBytes} of ${cacheBytes} bytes`);
        }
        assert.equal(await decoder.next(), null);
      });
      assert.ok(asked.length > 0, `round ${round}`);
      assert.deepEqual(await decoder.buffered(), span(groups.slice(-1)));
    }
    assert.deepEqual(await requestsOf(() => from(decoder, { frame: groups[0].frameCount })), []);
    decoder.close();
  });

test("the cache stays within the memory limit of the decoder", async () => {
  const plain = await open("range/moving");
  await play(plain.decoder);
  const { memoryBytes } = await plain.decoder.stats();
  const { decoder } = await open("range/moving", { limits: { memory: memoryBytes + 5000 } });
  assert.deepEqual(await play(decoder), expected);
  const stats = await decoder.stats();
  assert.ok(stats.memoryBytes + stats.cachedBytes <= memoryBytes + 5000, JSON.stringify(stats));
  await assert.rejects(open("range/moving", { limits: { cacheBytes: -1 } }), { code: "argument" });
  decoder.close();
  plain.decoder.close();
});

for (const behaviour of ["whole", "gzip"])
  test(`a single response (${behaviour}): received frames can be sought, and finally all of them`, async () => {
    const { decoder, reports } = await open(`${behaviour}/moving`, { queue: 1 });
    assert.deepEqual([decoder.seekable, decoder.frameCount, decoder.groups], [true, null, null]);
    const again = await requestsOf(async () => {
      for (let n = 0; n < 4; n++) assert.deepEqual(frameHashes(await decoder.next()), expected[n]);
      const { configuration } = decoder;
      assert.deepEqual(await decoder.buffered(), [{ start: 0n, end: 5n * configuration.frameDuration }]);
      for (const n of [1, 3, 0, 2]) {
        await decoder.seek({ frame: n });
        const frame = await decoder.next();
        assert.equal(frame.number, n);
        assert.deepEqual(frameHashes(frame), expected[n]);
        await decoder.seek({ time: frame.time });
        assert.equal((await decoder.next()).number, n);
      }
      // Forward over bytes that have not arrived yet.
      assert.deepEqual(await from(decoder, { frame: 4 }), expected.slice(4));
      const whole = new Blob([readFileSync(clips.moving)]);
      const other = await createDecoder({ source: whole });
      assert.equal(decoder.frameCount, 5);
      assert.deepEqual(decoder.groups, other.groups);
      assert.deepEqual(await decoder.buffered(), span(other.groups));
      for (const n of [0, 4, 1]) assert.deepEqual(await from(decoder, { frame: n }), expected.slice(n));
      await assert.rejects(decoder.seek({ frame: 5 }), { code: "argument", fatal: false });
    });
    assert.deepEqual(again, []);
    assert.deepEqual(
      reports.map(({ type }) => type),
      ["warning", "groups"],
    );
    assert.equal((await decoder.stats()).requests, 1);
    decoder.close();
    assert.equal((await decoder.stats()).cachedBytes, 0);
  });

test("a single response: a seek before anything has arrived", async () => {
  for (const place of [{ frame: 2 }, { time: nativeTime(2) }]) {
    const { decoder } = await open("whole/moving", { queue: 1 });
    assert.deepEqual(await from(decoder, place), expected.slice(2));
    await assert.rejects(decoder.seek({ frame: 5 }), { code: "argument" });
    decoder.close();
  }
});

test("a single response larger than the limit is not kept and cannot be sought in", async () => {
  for (const [behaviour, limit] of [
    ["whole", size - 1],
    ["gzip", size - 1],
    ["gzip", 2000],
  ]) {
    const { decoder, reports } = await open(`${behaviour}/moving`, { limits: { cacheBytes: limit } });
    assert.equal(decoder.seekable, behaviour === "gzip");
    assert.deepEqual(await play(decoder), expected);
    assert.equal(decoder.seekable, false);
    assert.ok(reports.every(({ type }) => type === "warning" || type === "groups"));
    assert.deepEqual([(await decoder.stats()).cachedBytes, await decoder.buffered()], [0, []]);
    await assert.rejects(decoder.seek({ frame: 0 }), { code: "state", fatal: false });
    decoder.close();
  }
});

test("a file that changes during playback: nothing of the former one is kept", async () => {
  files.swapped = join(folder, "swapped");
  cpSync(clips.raw, files.swapped);
  const { decoder, reports } = await open("changing/swapped", { queue: 1 });
  (await decoder.next()).close();
  cpSync(clips.moving, files.swapped);
  await decoder.seek({ frame: 4 });
  assert.deepEqual(await play(decoder), expected.slice(4));
  assert.deepEqual(
    reports.map(({ detail, type }) => detail?.code ?? type),
    ["changed", "groups"],
  );
  assert.deepEqual(await from(decoder, { frame: 0 }), expected);
  const { cachedBytes } = await decoder.stats();
  assert.ok(cachedBytes < 2 * size);
  assert.deepEqual(await requestsOf(async () => assert.deepEqual(await from(decoder, { frame: 0 }), expected)), []);
  decoder.close();
});

/** A copy of a file with one flipped bit. */
function damage(path, as, at) {
  files[as] = join(folder, as.replace("/", "-"));
  const content = readFileSync(path);
  content[at] ^= 1;
  writeFileSync(files[as], content);
}

test("damaged bytes are not kept: their group is fetched again each time, until it arrives undamaged", async () => {
  const { decoder: plain } = await open("range/moving");
  const [first, second] = plain.groups;
  plain.close();
  damage(clips.moving, "mended", second.offset + second.size / 2);
  const { decoder, reports } = await open("range/mended");
  let frames = await play(decoder);
  assert.ok(frames.length < 5 && reports.some(({ type }) => type === "damage"));
  const good = expected.map(text);
  for (const frame of frames) assert.ok(good.includes(text(frame)), "a wrong frame");
  const buffered = await decoder.buffered();
  assert.ok(buffered[0].end < second.end, "damaged bytes are buffered");
  for (let round = 0; round < 3; round++) {
    if (round === 2) cpSync(clips.moving, files.mended);
    const reported = reports.length;
    const before = await decoder.stats();
    await decoder.seek({ frame: 0 });
    frames = await play(decoder);
    const { bytesRead } = await decoder.stats();
    assert.ok(bytesRead > before.bytesRead, `round ${round}: damaged bytes were used again`);
    assert.ok(bytesRead - before.bytesRead <= size - second.offset, `${bytesRead - before.bytesRead} bytes`);
    if (round === 2) assert.deepEqual([frames, reports.length], [expected, reported]);
    else assert.ok(frames.length < 5 && reports.length > reported);
  }
  assert.deepEqual(await requestsOf(async () => assert.deepEqual(await from(decoder, { frame: 0 }), expected)), []);
  assert.deepEqual(await decoder.buffered(), span([first, second]));
  decoder.close();
});

test("a damaged or missing segment is requested again, the others are not", async () => {
  const names = Object.keys(files).filter((name) => name.startsWith("moving/"));
  for (const name of names) files[name.replace("moving", "torn")] = files[name];
  damage(files["moving/group-000001.fvv"], "torn/group-000001.fvv", 1000);
  const { decoder, reports } = await open("whole/torn/manifest.json");
  const whole = files["torn/group-000001.fvv"];
  for (const path of [whole, join(folder, "absent"), files["moving/group-000001.fvv"]]) {
    files["torn/group-000001.fvv"] = path;
    const asked = await requestsOf(async () => {
      const frames = await from(decoder, { frame: 0 });
      assert.deepEqual(frames, path === files["moving/group-000001.fvv"] ? expected : expected.slice(0, 3));
    });
    assert.ok(asked.filter((line) => line.includes("group-000001")).length === 1, `${asked}`);
  }
  assert.ok(reports.filter(({ type }) => type === "gap").length === 2);
  assert.deepEqual(await requestsOf(async () => assert.deepEqual(await from(decoder, { frame: 0 }), expected)), []);
  decoder.close();
});

test("tracks: a loop makes no requests, and another selection requests only what is new", async () => {
  const first = (await open("range/tracks")).decoder;
  const frame = await first.next();
  const [one, two] = frame.configuration.videos.map(({ track }) => track);
  first.close();
  const { decoder } = await open("range/tracks", { tracks: [one] });
  await play(decoder);
  assert.deepEqual(await decoder.buffered(), span(decoder.groups));
  assert.deepEqual(await requestsOf(() => from(decoder, { frame: 0 })), []);
  const before = await decoder.stats();
  await decoder.select({ tracks: [one, two] });
  assert.deepEqual(await decoder.buffered(), []);
  assert.ok((await requestsOf(() => from(decoder, { frame: 0 }))).length > 0);
  const after = await decoder.stats();
  assert.ok(after.bytesRead - before.bytesRead < before.bytesRead, `${before.bytesRead}, ${after.bytesRead} bytes`);
  assert.deepEqual(await requestsOf(() => from(decoder, { frame: 0 })), []);
  await decoder.select({ tracks: [one] });
  assert.deepEqual(await requestsOf(() => from(decoder, { frame: 0 })), []);
  assert.deepEqual(await decoder.buffered(), span(decoder.groups));
  decoder.close();
});

test("a signal that is aborted frees what was kept", async () => {
  for (const path of ["range/moving", "whole/moving", "whole/moving/manifest.json"]) {
    const abort = new AbortController();
    const { decoder } = await open(path, { signal: abort.signal, queue: 1 });
    (await decoder.next()).close();
    assert.ok((await decoder.stats()).cachedBytes > 0, path);
    abort.abort();
    assert.equal(await decoder.next(), null);
    await new Promise((done) => setTimeout(done, 50));
    assert.equal((await decoder.stats()).cachedBytes, 0, path);
  }
});
