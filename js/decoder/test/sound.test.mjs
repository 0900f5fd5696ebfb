// Sound in browsers: decoded samples compared with the files that fvvdemux writes, which the browser decodes by other means,
// and claps where fvvsynth put them.

import assert from "node:assert/strict";
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";

import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { createDecoder } from "../dist/index.js";

const FRAMES = 50;
const RATE = 48000;
/** At 25 frames/s the claps are in frames 12 and 37. */
const CLAPS = [12, 37].map((frame) => (frame / 25) * RATE);

let folder;
const at = (name) => join(folder, name);

before(() => {
  folder = mkdtempSync(join(tmpdir(), "fvv-sound-"));
  const rig = ["--rig", "small", "--cameras", "2", "--size", "96x64", "--frames", `${FRAMES}`];
  tool("fvvsynth", "-o", at("capture"), ...rig, "--sound");
  tool("fvvmux", at("capture"), "-o", at("clip.fvv"), "--group", "10", "--triangles", "1000", "--quality", "36dB");
  tool("fvvdemux", at("clip.fvv"), "-o", at("unpacked"), "--pictures", "none", "--meshes", "drc");
});
after(() => rmSync(folder, { recursive: true, force: true }));

test("packets arrive ahead of their frames, and none after a seek that belongs before it", async () => {
  const bytes = readFileSync(at("clip.fvv"));
  const decoder = await createDecoder({ source: bytes, audio: "packets", worker: false, video: "samples" });
  let heard = []; // [track, first sample that is played]
  decoder.addEventListener("sound", ({ detail }) => heard.push(detail));
  const ends = [];
  for await (const frame of decoder) {
    await new Promise((done) => setTimeout(done, 20));
    const end = (track) =>
      Math.max(...heard.filter((c) => c.track === track).map((c) => Number(c.start) + c.packetCount * 960));
    ends.push([frame.seconds, end(10001) / RATE]);
    frame.close();
  }
  const { sounds } = decoder.configuration;
  assert.deepEqual(
    sounds.map(({ track, codec, channels, packetDuration, moves }) => [track, codec, channels, packetDuration, moves]),
    [
      [10001, "opus", 1, 960, false],
      [10002, "opus", 1, 960, true],
    ],
  );
  // The first frames do not wait.
  for (const [seconds, end] of ends.slice(5)) assert.ok(end >= Math.min(2, seconds + 0.4), `${end} s at ${seconds} s`);
  heard = [];
  await decoder.seek({ seconds: 1.3 });
  const frame = await decoder.next();
  assert.equal(frame.number, 32);
  frame.close();
  await new Promise((done) => setTimeout(done, 20));
  const first = heard.find((chunk) => chunk.track === 10001);
  // Its group begins at 1.2 s, with what it repeats.
  assert.equal(Number(first.start) + first.prerollCount * 960, 1.2 * RATE);
  assert.ok(first.prerollCount >= 4);
  decoder.close();
  await assert.rejects(createDecoder({ source: bytes, audio: "loud" }), /audio: expected/);
});

test("without the option nothing is read ahead and nothing is dispatched", async () => {
  const decoder = await createDecoder({ source: readFileSync(at("clip.fvv")), worker: false, video: "samples" });
  let heard = 0;
  decoder.addEventListener("sound", () => heard++);
  let frames = 0;
  for await (const frame of decoder) {
    frames++;
    frame.close();
  }
  assert.equal(frames, FRAMES);
  assert.equal(heard, 0);
});

/** In the page: the sound of a clip from a time on, and what decodeAudioData makes of a file. */
async function listen({ seconds, worker, rate }) {
  const { createDecoder: create } = await import("/dist/index.js");
  const decoder = await create({ source: "/clip.fvv", audio: "samples", worker: worker ? undefined : false });
  const warnings = [];
  const blocks = new Map();
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail.message));
  decoder.addEventListener("soundrestart", () => blocks.clear());
  decoder.addEventListener("sound", ({ detail }) => {
    if (!blocks.has(detail.track)) blocks.set(detail.track, []);
    blocks.get(detail.track).push(detail);
  });
  if (seconds) await decoder.seek({ seconds });
  let frames = 0;
  for await (const frame of decoder) {
    frames++;
    frame.close();
  }
  await new Promise((done) => setTimeout(done, 300));
  decoder.close();
  const byTrack = [...blocks].sort(([a], [b]) => a - b);
  const tracks = byTrack.map(([track, list]) => {
    const start = list[0].start;
    const end = list.at(-1).start + list.at(-1).channels[0].length;
    const samples = new Float32Array(end - start);
    let gaps = 0;
    let expected = start;
    for (const block of list) {
      if (block.start !== expected) gaps++;
      samples.set(block.channels[0], block.start - start);
      expected = block.start + block.channels[0].length;
    }
    const { position } = list[0];
    return { track, start, gaps, rate: list[0].rate, position, samples: Array.from(samples) };
  });
  const files = [];
  for (const { track } of tracks) {
    const context = new OfflineAudioContext(1, rate, rate);
    const file = await (await fetch(`/audio/${track}.opus`)).arrayBuffer();
    files.push(Array.from((await context.decodeAudioData(file)).getChannelData(0)));
  }
  return { frames, warnings, tracks, files };
}

const click = (samples, about) => {
  let best = 0;
  for (let i = about - 960; i < about + 960; i++) if (Math.abs(samples[i]) > Math.abs(samples[best])) best = i;
  return best;
};

for (const name of ["chromium", "firefox"])
  describe(name, { skip: missingBrowser(name) }, () => {
    let served, browser, page;
    before(async () => {
      served = await serveFolder();
      cpSync(fileURLToPath(new URL("../dist", import.meta.url)), join(served.folder, "dist"), { recursive: true });
      cpSync(at("clip.fvv"), join(served.folder, "clip.fvv"));
      cpSync(at("unpacked/audio"), join(served.folder, "audio"), { recursive: true });
      writeFileSync(join(served.folder, "index.html"), "<!doctype html><title>sound</title>");
      browser = await openBrowser(name);
      page = await browser.newPage(`${served.url}/index.html`);
    });
    after(async () => {
      await browser?.close();
      served?.close();
    });

    for (const worker of [true, false])
      test(`decoded samples are those of the file, ${worker ? "worker" : "window"}`, async (t) => {
        if (!(await page.evaluate(() => typeof AudioDecoder === "function"))) return t.skip("no AudioDecoder");
        const { frames, warnings, tracks, files } = await page.evaluate(listen, { seconds: 0, worker, rate: RATE });
        assert.equal(frames, FRAMES);
        assert.deepEqual(warnings, []);
        assert.deepEqual(
          tracks.map(({ track, gaps, rate }) => [track, gaps, rate]),
          [
            [10001, 0, RATE],
            [10002, 0, RATE],
          ],
        );
        assert.ok(tracks[1].position.length === 3 && Math.abs(tracks[1].position[0]) > 0.1);
        tracks.forEach(({ start, samples }, i) => {
          // The file begins 648 samples before the scene: a packet, without the delay of the encoder.
          const file = files[i].slice(960 - 312);
          const ours = samples.slice(-start);
          let [signal, noise] = [0, 0];
          for (let k = 960; k < 2 * RATE; k++) {
            signal += file[k] ** 2;
            noise += (file[k] - ours[k]) ** 2;
          }
          t.diagnostic(`track ${i}: ${(10 * Math.log10(signal / noise)).toFixed(1)} dB`);
          assert.ok(noise < signal * 1e-4, `track ${i}: ${10 * Math.log10(signal / noise)} dB`);
        });
        for (const clap of CLAPS) {
          const found = click(tracks[0].samples, clap - tracks[0].start) + tracks[0].start;
          t.diagnostic(`clap at ${clap}, found at ${found}`);
          assert.ok(Math.abs(found - clap) <= 2, `clap at ${clap}, found at ${found}`);
        }
      });

    test("after a seek sound begins with the group, and is right there", async (t) => {
      if (!(await page.evaluate(() => typeof AudioDecoder === "function"))) return t.skip("no AudioDecoder");
      const { tracks } = await page.evaluate(listen, { seconds: 1.3, worker: true, rate: RATE });
      assert.equal(tracks[0].start, 1.2 * RATE);
      const found = click(tracks[0].samples, CLAPS[1] - tracks[0].start) + tracks[0].start;
      assert.ok(Math.abs(found - CLAPS[1]) <= 2, `clap at ${CLAPS[1]}, found at ${found}`);
    });

    test("a browser without AudioDecoder gets a warning, and the frames", async () => {
      const { frames, warnings, tracks } = await page.evaluate(
        async (text, options) => {
          const former = globalThis.AudioDecoder;
          globalThis.AudioDecoder = undefined;
          try {
            return await new Function(`return ${text}`)()(options);
          } finally {
            globalThis.AudioDecoder = former;
          }
        },
        listen.toString(),
        { seconds: 0, worker: false, rate: RATE },
      );
      assert.equal(frames, FRAMES);
      assert.equal(tracks.length, 0);
      assert.equal(warnings.filter((text) => /track 1000\d is silent/.test(text)).length, 2);
    });
  });
