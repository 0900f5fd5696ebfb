// Every frame is bit-identical to what libfvv decodes, from every kind of source.

import assert from "node:assert/strict";
import * as fs from "node:fs";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { createDecoder } from "../dist/index.js";
import { compileCore } from "../dist/modules.js";
import { Session } from "../dist/session.js";
import {
  environmentHashes,
  conformanceFiles,
  frameHashes,
  makeClips,
  nativeEnvironment,
  nativeFrames,
  onlyEnvironment,
} from "./native.mjs";

const { clips, done } = makeClips();
after(done);
const files = [...conformanceFiles(), ...Object.values(clips)];

async function decode(source, options = {}) {
  const decoder = await createDecoder({ source, ...options });
  const problems = [];
  onReports(decoder, ["damage", "gap", "error"], (_, detail) => problems.push(detail));
  const frames = [];
  for await (const frame of decoder) {
    frames.push(frameHashes(frame));
    frame.close();
  }
  decoder.close();
  assert.deepEqual(problems, []);
  return frames;
}

/** A stream of pieces of odd sizes. */
async function* pieces(bytes, size) {
  for (let at = 0; at < bytes.length; at += size) yield bytes.slice(at, at + size);
}

for (const file of files)
  test(`${file.split("/").slice(-2).join("/")}: the same from bytes, a Blob and a stream`, async () => {
    const expected = nativeFrames(file);
    const bytes = new Uint8Array(fs.readFileSync(file));
    assert.deepEqual(await decode(bytes), expected);
    assert.deepEqual(await decode(new Blob([bytes])), expected);
    assert.deepEqual(await decode(pieces(bytes, 977)), expected);
    // Not in Node 18.
    if (fs.openAsBlob) assert.deepEqual(await decode(await fs.openAsBlob(file)), expected);
  });

test("visibility weights are of seven values, and null for other cameras", async () => {
  const file = conformanceFiles().find((name) => name.endsWith("vector_visibility_weights/input.fvv"));
  const decoder = await createDecoder({ source: new Uint8Array(fs.readFileSync(file)) });
  const met = new Set();
  for await (const frame of decoder) {
    const [visibility] = frame.visibility;
    for (const camera of visibility.cameras) {
      const weights = visibility.weightsOf(camera);
      assert.equal(weights.length, visibility.vertexCount);
      for (const weight of weights) met.add(weight);
    }
    assert.equal(visibility.weightsOf(12345), null);
    frame.close();
  }
  decoder.close();
  assert.deepEqual(
    [...met].sort((a, b) => a - b),
    [0, 85, 113, 127, 142, 170, 255],
  );
});

test("clips contain what they are to test", () => {
  const names = (file) =>
    new Set(nativeFrames(file).flatMap((frame) => Object.keys(frame).map((key) => key.split(" ")[0])));
  assert.ok(names(clips.delta).has("uvs"));
  assert.ok(names(clips.raw).has("key"));
  assert.ok(names(clips.moving).has("camera"));
  assert.ok(nativeFrames(clips.fast).length === 5);
  const moving = nativeFrames(clips.moving);
  assert.notEqual(moving[0]["texturing 0"], nativeFrames(clips.raw)[0]["texturing 0"]);
  const changed = Object.keys(moving[0]).filter((key) => key.startsWith("camera") && moving[0][key] !== moving[4][key]);
  assert.ok(changed.length > 0, "no camera moves");
  const tiles = moving.map((frame) => Object.entries(frame).find(([key]) => key.startsWith("tiles"))[1]);
  assert.notEqual(tiles[0], tiles[4], "both groups have the same tiles");
  const crops = nativeFrames(conformanceFiles().find((file) => file.endsWith("vector_tiles_crops/input.fvv")));
  const layouts = crops.flatMap((frame) => Object.entries(frame).filter(([key]) => key.startsWith("tiles")));
  assert.ok(new Set(layouts.map(([, hash]) => hash)).size > 1, "all groups have one layout");
});

test("a WritableStream takes bytes as fast as frames are taken", async () => {
  const bytes = new Uint8Array(fs.readFileSync(clips.raw));
  const decoder = await createDecoder({ queue: 1 });
  const writer = decoder.writable.getWriter();
  let written = 0;
  const writing = (async () => {
    for await (const piece of pieces(bytes, 4096)) {
      await writer.ready;
      await writer.write(piece);
      written += piece.length;
    }
    await writer.close();
  })();
  const first = await decoder.next();
  await new Promise((resolve) => setTimeout(resolve, 50));
  assert.ok(written < bytes.length, `${written} bytes were taken for one frame`);
  const frames = [frameHashes(first)];
  for await (const frame of decoder) frames.push(frameHashes(frame));
  await writing;
  assert.deepEqual(frames, nativeFrames(clips.raw));
  decoder.close();
});

/** The first byte after the first frame: where the next chunk of a frame has another time. */
function endOfFirstFrame(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  let time = null;
  for (let at = 24; ; at += 32 + 8 * Math.ceil(view.getUint32(at + 16, true) / 8)) {
    const inFrame = ["MESH", "VISI", "CALB", "VPKT"].includes(String.fromCharCode(...bytes.subarray(at, at + 4)));
    if (inFrame && time !== null && view.getBigInt64(at + 8, true) !== time) return at;
    if (inFrame) time = view.getBigInt64(at + 8, true);
  }
}

test("a complete frame does not wait for the next one", { timeout: 120000 }, async () => {
  for (const name of ["delta", "draco", "moving"]) {
    const bytes = new Uint8Array(fs.readFileSync(clips[name]));
    const decoder = await createDecoder();
    const writing = decoder.writable.getWriter().write(bytes.subarray(0, endOfFirstFrame(bytes)));
    assert.deepEqual(frameHashes(await decoder.next()), nativeFrames(clips[name])[0]);
    await writing;
    decoder.close();
  }
});

test("seeking yields the same frames", async () => {
  for (const name of ["delta", "draco", "moving"]) {
    const expected = nativeFrames(clips[name]);
    const decoder = await createDecoder({
      source: new Uint8Array(fs.readFileSync(clips[name])),
    });
    assert.equal(decoder.frameCount, 5);
    for (const n of [4, 1, 3, 0, 2]) {
      await decoder.seek({ frame: n });
      const frame = await decoder.next();
      assert.equal(frame.number, n);
      assert.deepEqual(frameHashes(frame), expected[n]);
      await decoder.seek({ seconds: frame.seconds + 0.01 });
      assert.equal((await decoder.next()).number, n);
      await decoder.seek({ time: frame.time });
      const rest = [];
      for await (const later of decoder) rest.push(frameHashes(later));
      assert.deepEqual(rest, expected.slice(n));
    }
    decoder.close();
  }
});

test("aborting ends the iteration", async () => {
  const abort = new AbortController();
  const endless = new ReadableStream({ pull: () => new Promise(() => {}) });
  const decoder = await createDecoder({ source: endless, signal: abort.signal });
  setTimeout(() => abort.abort(), 20);
  for await (const _ of decoder) assert.fail("there is no frame");
  await assert.rejects(createDecoder({ source: new Uint8Array(0), signal: AbortSignal.abort() }), {
    name: "AbortError",
  });
});

test("environments are reported, however their group is reached", async () => {
  const expected = nativeEnvironment(clips.environment);
  assert.ok(Object.keys(expected).some((what) => what.startsWith("part-uvs")));
  assert.ok(Object.keys(expected).some((what) => what.startsWith("light")));
  const bytes = new Uint8Array(fs.readFileSync(clips.environment));
  for (const [source, start] of [[bytes], [pieces(bytes, 977)], [bytes, 4]]) {
    const environment = await onlyEnvironment(source, start);
    assert.deepEqual(environmentHashes(environment), expected);
    assert.ok(environment.parts[0].colour.every((x) => x >= 0 && x <= 1));
  }
});

test("a codec is loaded while the rest of its first frame arrives", async () => {
  const bytes = new Uint8Array(fs.readFileSync(clips.moving));
  const asked = [];
  const codec = async (name) => {
    asked.push(name);
    throw new Error("not yet");
  };
  const decoder = await Session.create({ module: await compileCore(), codec });
  decoder.start(0);
  let frames = 0;
  for (let at = 0; at < bytes.length && !frames; at += 64)
    for (const _ of decoder.push(bytes.subarray(at, at + 64))) {
      for (let kind; (kind = decoder.next()) !== "need data";) if (kind === "frame") frames++;
      const before = asked.length;
      decoder.prepareCodecs();
      if (asked.length > before) assert.equal(frames, 0);
    }
  assert.equal(frames, 1);
  assert.deepEqual(asked, ["draco"]);
});
