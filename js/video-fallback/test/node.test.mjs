// Pictures in Node, which has no video decoders of its own, by the fallback: bit-identical to the native library.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { createDecoder } from "../../decoder/dist/index.js";
import { nativePictures } from "../../decoder/test/native.mjs";
import { loadPictures } from "../../shading/src/pictures.js";
import { makeVideoClips } from "./clips.mjs";

const videoFallback = () => import("../dist/index.js");
const { clips, done } = makeVideoClips("h264", "hevc", "hevc10", "vp9", "vp910", "av1");
after(done);
const read = (name) => new Uint8Array(readFileSync(clips[name]));
const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

async function bytesOf(image) {
  const bytes = new Uint8Array(image.allocationSize());
  await image.copyTo(bytes);
  return bytes;
}

/** Plays a stream: hashes of the pictures of each frame, and all reports. */
async function play(options, each = () => {}) {
  const decoder = await createDecoder({ videoFallback, ...options });
  const reports = [];
  onReports(decoder, ["warning", "damage", "gap"], (type, detail) => reports.push({ type, detail }));
  const frames = [];
  for await (const frame of decoder) {
    const pictures = [];
    for (const { track, picture } of frame.pictures) {
      assert.equal(picture.timestamp, Math.round(frame.seconds * 1e6), "a picture of another time");
      pictures.push({ track, hash: sha256(await bytesOf(picture)) });
    }
    frames.push({ number: frame.number, pictures });
    await each(frame);
    frame.close();
  }
  decoder.close();
  return { frames, reports };
}

for (const name of ["h264", "hevc", "hevc10", "vp9", "vp910"])
  test(`${name}: the pictures of the native libavcodec`, async () => {
    const { frames, reports } = await play({ source: read(name) });
    assert.deepEqual(reports, []);
    const pictures = frames.flatMap((frame) => frame.pictures);
    assert.equal(frames.length, 5);
    assert.deepEqual(pictures, nativePictures(clips[name]));
    assert.equal(new Set(pictures.map(({ hash }) => hash)).size, pictures.length, "some pictures are equal");
  });

test("seeking yields the picture of that frame, whatever was decoded before", async () => {
  const expected = nativePictures(clips.hevc);
  const decoder = await createDecoder({ source: read("hevc"), videoFallback });
  for (const n of [4, 1, 3, 0, 2]) {
    await decoder.seek({ frame: n });
    const frame = await decoder.next();
    assert.equal(frame.number, n);
    assert.equal(sha256(await bytesOf(frame.picture())), expected[n].hash);
    frame.close();
  }
  decoder.close();
});

test("a compiled module works like the package", async () => {
  const wasm = await WebAssembly.compile(readFileSync(new URL("../dist/video.wasm", import.meta.url)));
  const { frames } = await play({ source: read("vp9"), videoFallback: async () => wasm });
  assert.deepEqual(
    frames.flatMap((frame) => frame.pictures),
    nativePictures(clips.vp9),
  );
});

test("a codec that cannot be decoded is reported once, and frames have no pictures", async () => {
  const unloadable = () => Promise.reject(new Error("404"));
  const cases = [
    [{ source: read("av1") }, /av01.*not in it/],
    [{ source: read("hevc"), videoFallback: unloadable }, /hvc1.*404/],
    [{ source: read("hevc"), videoFallback: undefined, video: "decoded" }, /hvc1.*no decoder/],
  ];
  for (const [options, expected] of cases) {
    const { frames, reports } = await play(options);
    assert.deepEqual(
      frames.map(({ pictures }) => pictures),
      [[], [], [], [], []],
    );
    assert.deepEqual(
      reports.map(({ type, detail }) => `${type} ${detail.code}`),
      ["warning unsupported"],
    );
    assert.match(reports[0].detail.message, expected);
  }
  await assert.rejects(createDecoder({ source: read("hevc"), videoFallback: "@fvv/video-fallback" }), {
    code: "argument",
  });
});

test("a planar picture has the interface of VideoFrame", async () => {
  let checked = 0;
  await play({ source: read("hevc10") }, async (frame) => {
    if (frame.number > 0) return;
    const [{ width, height, colour }] = frame.configuration.videos;
    const image = frame.picture();
    assert.equal(image.format, "I420P10");
    assert.deepEqual([image.displayWidth, image.displayHeight], [width, height]);
    assert.equal(image.colorSpace.fullRange, colour.fullRange);
    const whole = await bytesOf(image);
    // A part of it, with gaps between rows.
    const rect = { x: 16, y: 8, width: 10, height: 6 };
    const layout = [
      { offset: 4, stride: 64 },
      { offset: 500, stride: 32 },
      { offset: 700, stride: 32 },
    ];
    const part = new Uint8Array(image.allocationSize({ rect, layout }));
    assert.deepEqual(await image.copyTo(part, { rect, layout }), layout);
    const row = (at, count) => whole.subarray(at, at + count);
    assert.deepEqual(part.subarray(4 + 2 * 64, 4 + 2 * 64 + 20), row(2 * ((8 + 2) * width + 16), 20));
    const v = 2 * (width * height + (width / 2) * (height / 2) + (4 + 1) * (width / 2) + 8);
    assert.deepEqual(part.subarray(700 + 32, 700 + 32 + 10), row(v, 10));
    await assert.rejects(image.copyTo(new Uint8Array(10)), { code: "argument" });
    await assert.rejects(image.copyTo(part, { rect: { ...rect, x: 15 } }), { code: "argument" });
    await assert.rejects(image.copyTo(part, { format: "RGBA" }), { code: "unsupported" });
    const twin = image.clone();
    frame.close();
    assert.equal(image.format, null);
    await assert.rejects(image.copyTo(part), { code: "state" });
    assert.deepEqual(await bytesOf(twin), whole);
    checked++;
  });
  assert.equal(checked, 1);
});

test("players get planes of 8 bits, also of 10", async () => {
  for (const [name, bits] of [
    ["hevc", 8],
    ["hevc10", 10],
  ]) {
    const decoder = await createDecoder({ source: read(name), videoFallback });
    const frame = await decoder.next();
    const [{ planes }] = await loadPictures(frame);
    const whole = await bytesOf(frame.picture());
    const samples = bits === 8 ? whole : new Uint16Array(whole.buffer);
    const joined = planes.flatMap(({ data }) => Array.from(data));
    assert.equal(joined.length, samples.length);
    for (const [i, value] of joined.entries())
      assert.ok(Math.abs(samples[i] / 2 ** (bits - 8) - value) <= 0.5, `sample ${i}: ${value} of ${samples[i]}`);
    assert.ok(new Set(joined).size > 50);
    frame.close();
    decoder.close();
  }
});

test("it takes over from a decoder of the browser that fails at its first picture, and no picture is missing", async () => {
  globalThis.EncodedVideoChunk = class {};
  globalThis.VideoDecoder = class {
    static isConfigSupported = async () => ({ supported: true });
    state = "unconfigured";
    constructor({ error }) {
      this.error = error;
    }
    configure() {
      this.state = "configured";
    }
    decode() {
      // Some samples later, as decoders have queues.
      setTimeout(() => {
        if (this.state === "closed") return;
        this.state = "closed";
        this.error(new Error("Decoding error."));
      }, 30);
    }
    async flush() {}
    close() {
      this.state = "closed";
    }
  };
  try {
    const { frames, reports } = await play({ source: read("h264") });
    assert.deepEqual(
      frames.flatMap((frame) => frame.pictures),
      nativePictures(clips.h264),
    );
    assert.deepEqual(
      reports.map(({ detail }) => detail.code),
      ["video"],
    );
  } finally {
    delete globalThis.VideoDecoder;
    delete globalThis.EncodedVideoChunk;
  }
});
