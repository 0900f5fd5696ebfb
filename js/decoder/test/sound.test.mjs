// Sound in browsers: decoded samples compared with the files that fvvdemux writes, which the browser decodes by other means,
// claps where fvvsynth put them, and the same samples without AudioDecoder.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath } from "node:url";

import { build as bundle } from "esbuild";

import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { build, serveFolder, tool } from "../../testing/served.mjs";
import { createDecoder } from "../dist/index.js";
import { OpusPackets } from "../dist/media/software_sound.js";

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
  const options = ["--group", "10", "--triangles", "1000", "--quality", "36dB"];
  tool("fvvmux", at("capture"), "-o", at("clip.fvv"), ...options);
  tool("fvvdemux", at("clip.fvv"), "-o", at("unpacked"), "--pictures", "none", "--meshes", "drc");
  const { status, stderr } = spawnSync(join(build, "tests/js/sound_files"), [at("capture"), "2"], { encoding: "utf8" });
  assert.equal(status, 0, stderr);
  const about = JSON.parse(readFileSync(at("capture/capture.json"), "utf8"));
  about.audio = [{ file: "stereo.m4a" }, { file: "surround.opus" }];
  writeFileSync(at("capture/capture.json"), JSON.stringify(about));
  tool("fvvmux", at("capture"), "-o", at("other.fvv"), ...options);
});
after(() => rmSync(folder, { recursive: true, force: true }));

test("packets arrive ahead of their frames, and none after a seek that belongs before it", async () => {
  const bytes = readFileSync(at("clip.fvv"));
  const decoder = await createDecoder({ source: bytes, sound: "encoded", worker: false, video: "encoded" });
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
  await assert.rejects(createDecoder({ source: bytes, sound: "loud" }), /sound: expected/);
});

test("without the option nothing is read ahead and nothing is dispatched", async () => {
  const decoder = await createDecoder({ source: readFileSync(at("clip.fvv")), worker: false, video: "encoded" });
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

const click = (samples, about) => {
  let best = 0;
  for (let i = about - 960; i < about + 960; i++) if (Math.abs(samples[i]) > Math.abs(samples[best])) best = i;
  return best;
};
const assertClap = (t, { samples, start }, clap) => {
  const found = click(samples, clap - start) + start;
  t.diagnostic(`clap at ${clap}, found at ${found}`);
  assert.ok(Math.abs(found - clap) <= 2, `clap at ${clap}, found at ${found}`);
};

const nodeOptions = { worker: false, video: "encoded" };
const importOpus = () => import("opus-decoder");

test("in Node sound is decoded by soundFallback", async (t) => {
  const source = readFileSync(at("clip.fvv"));
  const decoder = await createDecoder({ source, sound: "decoded", soundFallback: importOpus, ...nodeOptions });
  const blocks = [];
  decoder.addEventListener("sound", ({ detail }) => detail.track === 10001 && blocks.push(detail));
  for await (const frame of decoder) frame.close();
  const end = () => (blocks.length ? blocks.at(-1).start + blocks.at(-1).channels[0].length : 0);
  while (end() < 1.95 * RATE) await new Promise((done) => setTimeout(done, 20));
  decoder.close();
  const samples = blocks.flatMap(({ channels }) => Array.from(channels[0]));
  for (const clap of CLAPS) assertClap(t, { samples, start: blocks[0].start }, clap);
  await assert.rejects(createDecoder({ source, soundFallback: "opus-decoder" }), /soundFallback: expected a function/);
});

test("a fallback that cannot be loaded is a warning for each track", async () => {
  const soundFallback = () => Promise.reject(new Error("no such package"));
  const source = readFileSync(at("clip.fvv"));
  const decoder = await createDecoder({ source, sound: "decoded", soundFallback, ...nodeOptions });
  const warnings = [];
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail.message));
  for await (const frame of decoder) frame.close();
  assert.deepEqual(
    warnings,
    [10001, 10002].map((track) => `no such package: track ${track} is silent`),
  );
});

test("the gain of Opus applies, and a damaged packet is an error", async () => {
  const { OpusDecoder } = await importOpus();
  const decoder = await createDecoder({ source: readFileSync(at("clip.fvv")), sound: "encoded", ...nodeOptions });
  const [chunk] = await new Promise((done) => {
    const chunks = [];
    decoder.addEventListener("sound", ({ detail }) => chunks.push(detail) === 4 && done(chunks));
    decoder.next().then((frame) => frame.close());
  });
  const about = decoder.configuration.sounds.find(({ track }) => track === chunk.track);
  decoder.close();
  const decode = (gain, packets) => {
    const record = about.record.slice();
    new DataView(record.buffer).setInt16(16, gain, true);
    return new Promise((output, fail) => {
      const callbacks = { output: (_, [samples]) => output(samples), fail };
      new OpusPackets(OpusDecoder, { ...about, record }, callbacks).decode(packets);
    });
  };
  let end = 0;
  const packets = Array.from(chunk.sizes, (size) => ({ start: 0, data: chunk.data.slice(end, (end += size)) }));
  const loud = await decode(0, packets);
  const soft = await decode(-6 * 256, packets);
  const most = loud.indexOf(loud.reduce((a, b) => (Math.abs(a) > Math.abs(b) ? a : b)));
  assert.ok(Math.abs(20 * Math.log10(soft[most] / loud[most]) + 6) < 1e-3, `${soft[most]} of ${loud[most]}`);
  const { error } = console;
  console.error = () => {}; // opus-decoder prints what it also returns
  try {
    await assert.rejects(decode(0, [{ start: 0, data: Uint8Array.of(255, 255, 255) }]), /OPUS_INVALID_PACKET/);
  } finally {
    console.error = error;
  }
});

for (const name of ["chromium", "firefox"])
  describe(name, { skip: missingBrowser(name) }, () => {
    let served, browser, page;
    before(async () => {
      served = await serveFolder();
      const put = (from, to) => cpSync(from, join(served.folder, to), { recursive: true });
      put(fileURLToPath(new URL("../dist", import.meta.url)), "dist");
      put(fileURLToPath(new URL("audio_page.mjs", import.meta.url)), "audio_page.js");
      put(at("clip.fvv"), "clip.fvv");
      put(at("other.fvv"), "other.fvv");
      put(at("unpacked/audio"), "audio");
      const stdin = {
        contents: 'export { OpusDecoder } from "opus-decoder";',
        resolveDir: fileURLToPath(new URL(".", import.meta.url)),
      };
      await bundle({ stdin, bundle: true, minify: true, format: "esm", outfile: join(served.folder, "opus.js") });
      writeFileSync(join(served.folder, "index.html"), "<!doctype html><title>sound</title>");
      browser = await openBrowser(name);
      page = await browser.newPage(`${served.url}/index.html`);
    });
    after(async () => {
      await browser?.close();
      served?.close();
    });
    const inPage = (what, ...values) =>
      page.evaluate(async (called, given) => (await import("/audio_page.js"))[called](...given), what, values);
    const fileSamples = (track) =>
      page.evaluate(
        async (url, rate) => Array.from((await (await import("/audio_page.js")).listenToFile(url, rate))[0]),
        `/audio/${track}.opus`,
        RATE,
      );
    const lacksDecoder = async () => !(await page.evaluate(() => typeof AudioDecoder === "function"));

    for (const { worker, software } of [
      { worker: true, software: false },
      { worker: false, software: false },
      { worker: true, software: true },
    ])
      test(`decoded samples are those of the file, ${worker ? "worker" : "window"}${software ? ", without AudioDecoder" : ""}`, async (t) => {
        if (!software && (await lacksDecoder())) return t.skip("no AudioDecoder");
        const { frames, warnings, calls, tracks } = await inPage("report", { worker, software });
        assert.equal(frames, FRAMES);
        assert.deepEqual(warnings, []);
        // Only who needs it loads it.
        assert.equal(calls > 0, software);
        assert.deepEqual(
          tracks.map(({ track, gaps, rate }) => [track, gaps, rate]),
          [
            [10001, 0, RATE],
            [10002, 0, RATE],
          ],
        );
        assert.ok(tracks[1].position.length === 3 && Math.abs(tracks[1].position[0]) > 0.1);
        for (const { track, start, samples } of tracks) {
          // The file begins 648 samples before the scene: a packet, without the delay of the encoder.
          const file = (await fileSamples(track)).slice(960 - 312);
          const ours = samples.slice(-start);
          let [signal, noise] = [0, 1e-12];
          for (let k = 960; k < 2 * RATE; k++) {
            signal += file[k] ** 2;
            noise += (file[k] - ours[k]) ** 2;
          }
          const decibels = 10 * Math.log10(signal / noise);
          t.diagnostic(`track ${track}: ${decibels.toFixed(1)} dB`);
          assert.ok(decibels > 40, `track ${track}: ${decibels} dB`);
        }
        for (const clap of CLAPS) assertClap(t, tracks[0], clap);
      });

    for (const software of [false, true])
      test(`after a seek sound begins with the group, and is right there${software ? ", without AudioDecoder" : ""}`, async (t) => {
        if (!software && (await lacksDecoder())) return t.skip("no AudioDecoder");
        const { tracks } = await inPage("report", { seconds: 1.3, software });
        assert.equal(tracks[0].start, 1.2 * RATE);
        assertClap(t, tracks[0], CLAPS[1]);
      });

    test("AAC, and Opus of six channels, are the same without AudioDecoder, also after a seek", async (t) => {
      const clip = "/other.fvv";
      const native = { clip, software: await lacksDecoder() };
      for (const [one, other] of [
        [native, { clip, software: true }],
        [
          { clip, software: true },
          { clip, software: true, seconds: 1.3 },
        ],
      ]) {
        const { warnings, gaps, starts, ends, decibels } = await inPage("compare", one, other);
        t.diagnostic(`dB: ${decibels.map((track) => track.map((x) => x.toFixed(0)).join(" ")).join("; ")}`);
        assert.deepEqual(warnings, []);
        assert.deepEqual(
          decibels.map(({ length }) => length),
          [2, 6],
        );
        assert.deepEqual(gaps.flat(), [0, 0, 0, 0]);
        assert.deepEqual(ends[0], ends[1]);
        if (!other.seconds) assert.deepEqual(starts[0], starts[1]);
        // After a seek Opus converges within its pre-roll.
        const least = other.seconds ? [60, 25] : [60, 60];
        decibels.forEach((track, i) => assert.ok(Math.min(...track) > least[i], `track ${i}: ${track} dB`));
      }
    });

    test("without AudioDecoder and soundFallback there is a warning, and the frames", async () => {
      const { frames, warnings, tracks } = await inPage("report", { worker: false, software: true, fallback: false });
      assert.equal(frames, FRAMES);
      assert.equal(tracks.length, 0);
      assert.equal(warnings.filter((text) => /no AudioDecoder .* track 1000\d is silent/.test(text)).length, 2);
    });
  });
