// Samples with good CRCs and bad bits: a report and no picture, or a picture of the right size; never a decoder that hangs,
// grows without bound, or fails for the next group.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { createDecoder } from "../../decoder/dist/index.js";
import { SoftwareVideo } from "../../decoder/dist/media/software_video.js";
import { replaceFirst } from "../../decoder/test/edit_streams.mjs";
import { compile } from "../dist/index.js";
import { makeVideoClips } from "./clips.mjs";

const codecs = ["h264", "hevc", "hevc10", "vp9"];
const { clips, done } = makeVideoClips(...codecs);
after(done);

/** Layout and samples of a clip's video, and its pictures. */
async function samplesOf(name) {
  const source = new Uint8Array(readFileSync(clips[name]));
  const decoder = await createDecoder({ source, video: "encoded" });
  const samples = [];
  for await (const frame of decoder) samples.push(frame.samples[0]);
  return { layout: decoder.configuration.videos[0], samples };
}

function createVideo(options = {}) {
  const reports = [];
  const corrupt = (error) => reports.push(error.message);
  return { video: new SoftwareVideo({ load: compile, memoryBytes: 2 ** 26, corrupt, ...options }), reports };
}

const repeated = (bytes, count) => new Uint8Array(Buffer.concat(Array(count).fill(bytes)));

/** Pseudo-random numbers, the same on every machine. */
function* numbers(seed) {
  for (;;) yield (seed = (Math.imul(seed, 1103515245) + 12345) >>> 0) >>> 8;
}

for (const name of codecs)
  test(`${name}: flipped bits and cuts`, async () => {
    const { layout, samples } = await samplesOf(name);
    const { video, reports } = createVideo();
    const random = numbers(7);
    const upTo = (n) => random.next().value % n;
    let reported = 0;
    for (let n = 0; n < 60; n++) {
      const track = await video.open(layout);
      for (const [i, sample] of samples.entries()) {
        // The key picture of the second group is not damaged.
        const whole = i >= 3;
        const data = whole ? sample.data : sample.data.slice(0, upTo(8) ? undefined : upTo(sample.data.length) + 1);
        // Damage in headers has more effects than in the data after them.
        const place = () => upTo(upTo(2) ? Math.min(16, data.length) : data.length);
        if (!whole) for (let k = upTo(4); k > 0; k--) data[place()] ^= 1 << upTo(8);
        const before = reports.length;
        const picture = await track.submit({ key: sample.key, data }, i);
        if (picture) assert.deepEqual([picture.codedWidth, picture.codedHeight], [layout.width, layout.height]);
        assert.ok(reports.length === before || !picture, "a picture that was reported as damaged");
        reported += reports.length - before;
        if (whole) assert.ok(picture, `picture ${i} after damage: ${reports.at(-1)}`);
        picture?.close();
      }
      track.close();
    }
    assert.ok(reported >= 20, `${reported} were reported`);
  });

test("pictures whose size or bit depth differs from the configuration are rejected before memory is allocated", async () => {
  for (const name of codecs) {
    const { layout, samples } = await samplesOf(name);
    const { video, reports } = createVideo();
    for (const change of [
      { width: 16, height: 16 },
      { width: layout.width + 16 },
      { bitDepth: 18 - layout.bitDepth },
    ]) {
      const track = await video.open({ ...layout, ...change });
      assert.equal(await track.submit(samples[0], 0), null);
      assert.match(reports.pop(), /pixel|size|bits|damaged|PPS|VPS|SPS|dimensions/i);
      track.close();
    }
    assert.deepEqual(reports, []);
  }
});

test("a sample that would take forever is aborted, and the next key picture uses another instance", async () => {
  const { layout, samples } = await samplesOf("h264");
  const { video, reports } = createVideo({ sampleMs: 400, memoryBytes: 2 ** 29 });
  const track = await video.open(layout);
  assert.ok(await track.submit(samples[0], 0));
  // Each slice covers the whole picture.
  const endless = { key: true, data: repeated(samples[0].data, 6000) };
  assert.equal(await track.submit(endless, 1), null);
  assert.match(reports.pop(), /more than 400 ms/);
  assert.equal(await track.submit(samples[1], 2), null, "only a key picture may follow");
  assert.ok(await track.submit(samples[3], 3));
  // The number of attempts is limited.
  for (let n = 0; n < 6; n++) await track.submit(endless, n);
  assert.equal(reports.length, 5);
  assert.match(reports.pop(), /no more pictures/);
  assert.equal(await track.submit(samples[3], 9), null);
});

test("memory is bounded", async () => {
  const { layout, samples } = await samplesOf("h264");
  const { video, reports } = createVideo({ memoryBytes: 2 ** 23 });
  const track = await video.open(layout);
  assert.equal(await track.submit({ key: true, data: repeated(samples[0].data, 9000) }, 0), null);
  assert.match(reports.pop(), /no memory for/);
  assert.ok(await track.submit(samples[0], 1), reports.pop());
});

test("invalid configuration records", async () => {
  for (const name of ["h264", "hevc"]) {
    const { layout, samples } = await samplesOf(name);
    const { video, reports } = createVideo();
    for (let n = 0; n < layout.record.length; n++) {
      const record = layout.record.slice();
      record[n] ^= 0x55;
      // The record is rejected, or the change has no effect.
      const track = await video.open({ ...layout, record }).catch(() => null);
      if (track && !(await track.submit(samples[0], 0))) assert.ok(reports.pop());
      track?.close();
    }
    const track = await video.open(layout);
    assert.ok(await track.submit(samples[0], 0), "the instance does not recover");
  }
});

test("a damaged sample in a stream is reported as damage; its frame has no picture", async () => {
  const bytes = new Uint8Array(readFileSync(clips.h264));
  const changed = replaceFirst("VPKT", bytes, (payload) => payload.fill(0xff, 40));
  const decoder = await createDecoder({ source: changed, videoFallback: () => import("../dist/index.js") });
  const corrupt = [];
  onReports(decoder, ["damage"], (_, detail) => corrupt.push(detail));
  const pictures = [];
  for await (const frame of decoder) {
    pictures[frame.number] = frame.pictures.length;
    frame.close();
  }
  const [first] = corrupt.filter(({ chunk }) => chunk === "VPKT");
  assert.equal(first.code, "invalid");
  assert.equal(first.fatal, false);
  assert.match(first.message, /video track \d+ \(avc1\.\w+\): the sample of 0 us: /);
  assert.deepEqual([pictures[0], pictures[1]], [0, 0], "the next picture refers to the missing one");
  assert.deepEqual([pictures[3], pictures[4]], [1, 1]);
});
