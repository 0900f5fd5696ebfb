// How far apart pictures and sound are: node sound.mjs [SECONDS]. A long clip with a clap in each second is played once, then
// its first seconds in a loop, by Chromium without a GPU. Prints JSON: offsets of flashes on the screen from their clicks at
// the device, and apart from them the two causes, errors of the clock and late frames.

import { linkSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";

import { tool } from "../../../testing/served.mjs";
import { beginRecording, offsetsOf } from "../audio_page.mjs";
import { openPage } from "../page_driver.mjs";

const RATE = 25;
/** Frames of the capture that the clip repeats, a whole number of seconds. */
const PERIOD = 50;
/** Frame of the clap, in each second. */
const CLAP = 12;
/** Milliseconds of the beginning that do not count: the page starts. */
const START = 3000;
/** Seconds of the loop, and of its playback. */
const LOOP = 4;
const LOOPED = 60;
const TARGET = 20;
/** Milliseconds: animation frames that follow at a shorter distance are in time. */
const REGULAR = 25;
const WAV_HEAD = 44;

/** A capture whose files are those of a short one again and again: frames of 500 triangles, one picture of 64x48. */
function makeClip(folder, seconds) {
  const [short, meshes, long, clip] = ["short", "meshes", "long", "players.fvv"].map((name) => join(folder, name));
  const rig = ["--rig", "small", "--meshes", "tracked", "--cameras", "1", "--size", "64x48", "--frames", `${PERIOD}`];
  tool("fvvsynth", "-o", short, ...rig, "--sound");
  tool("fvvmux", short, "-o", clip, "--triangles", "500", "--no-pictures", "--no-sound");
  tool("fvvdemux", clip, "-o", meshes, "--meshes", "ply");
  const frames = seconds * RATE;
  for (const name of ["meshes", "cam0"]) mkdirSync(join(long, name), { recursive: true });
  for (let frame = 0; frame < frames; frame++) {
    const [from, to] = [String(frame % PERIOD).padStart(4, "0"), String(frame).padStart(6, "0")];
    linkSync(join(meshes, `meshes/${from}.ply`), join(long, `meshes/${to}.ply`));
    linkSync(join(short, `cam0/${from}.png`), join(long, `cam0/${to}.png`));
    linkSync(join(short, `cam0/mask_${from}.png`), join(long, `cam0/mask_${to}.png`));
  }
  const wave = readFileSync(join(short, "claps.wav"));
  const samples = Array(Math.ceil(frames / PERIOD)).fill(wave.subarray(WAV_HEAD));
  const head = Buffer.from(wave.subarray(0, WAV_HEAD));
  const bytes = samples.length * samples[0].length;
  head.writeUInt32LE(WAV_HEAD - 8 + bytes, 4);
  head.writeUInt32LE(bytes, WAV_HEAD - 4);
  writeFileSync(join(long, "claps.wav"), Buffer.concat([head, ...samples]));
  const about = JSON.parse(readFileSync(join(short, "capture.json"), "utf8"));
  about.frames.count = frames;
  about.meshes.pattern = "meshes/%06d.ply";
  // Without the ball, whose thumps are loud as well.
  about.audio.length = 1;
  Object.assign(about.cameras[0], { pictures: "cam0/%06d.png", masks: "cam0/mask_%06d.png" });
  writeFileSync(join(long, "capture.json"), JSON.stringify(about));
  tool("fvvmux", long, "-o", clip, "--keep-geometry", "--quality", "36dB", "--visibility", "none", "--force");
  return clip;
}

const percentile = (values, percent) =>
  values.length ? [...values].sort((a, b) => a - b)[Math.floor(((values.length - 1) * percent) / 100)] : null;
const largest = (values) => percentile(values.map(Math.abs), 100);
const mean = (values) => values.reduce((sum, x) => sum + x, 0) / values.length;

/** What the record of a page shows. refreshes: times of animation frames. */
function judge({ clicks, shown, refreshes }, seconds) {
  const from = refreshes[0] + START;
  const heard = clicks.filter(([time]) => time > from);
  const frames = Array.from({ length: seconds }, (_, second) => second * RATE + CLAP);
  const claps = heard.map(([time, position], i) => ({ time, position, offset: offsetsOf(heard, shown, frames)[i] }));
  const seen = claps.filter(({ offset }) => offset !== null);
  const offsets = seen.map(({ offset }) => offset);
  // Of the clock: where playback was when the click was heard, less where the clap is.
  const clock = claps.map(({ position }) => {
    const second = position - CLAP / RATE;
    return 1000 * (second - Math.round(second));
  });
  const intervals = refreshes.slice(1).map((time, i) => [time, time - refreshes[i]]);
  const isRegular = (time) =>
    intervals.every(([end, length]) => Math.abs(end - time) > 150 || length < REGULAR || end < time - 100);
  const regular = seen.filter(({ time, offset }) => isRegular(time + offset)).map(({ offset }) => offset);
  const lateness = shown.filter(([, time]) => time > from).map(([frame, , at]) => 1000 * (at - frame / RATE));
  const tenth = Math.max(1, Math.floor(offsets.length / 10));
  return {
    claps: heard.length,
    seen: seen.length,
    offset: {
      max: largest(offsets),
      median: percentile(offsets.map(Math.abs), 50),
      p95: percentile(offsets.map(Math.abs), 95),
    },
    beyondTarget: offsets.filter((offset) => Math.abs(offset) > TARGET).length,
    drift: mean(offsets.slice(-tenth)) - mean(offsets.slice(0, tenth)),
    clock: { max: largest(clock), median: percentile(clock.map(Math.abs), 50) },
    // Claps around which the screen was refreshed in time.
    regular: { claps: regular.length, max: largest(regular), median: percentile(regular.map(Math.abs), 50) },
    lateness: { median: percentile(lateness, 50), p5: percentile(lateness, 5), p95: percentile(lateness, 95) },
    refresh: {
      median: percentile(
        intervals.map(([, x]) => x),
        50,
      ),
      p95: percentile(
        intervals.map(([, x]) => x),
        95,
      ),
    },
    load: loadavg()[0],
  };
}

/** Plays a clip to its end; loop: its first seconds, for a while. */
async function play(clip, seconds, loop) {
  const opened = await openPage("chromium", clip);
  try {
    const { page } = opened;
    // Few pixels: the renderer is not what is measured.
    await page.setViewport({ width: 320, height: 240 });
    await page.waitForFunction(() => window.player.readyState === 4);
    await beginRecording(opened);
    await page.mouse.click(100, 100);
    await page.evaluate((range) => {
      window.refreshes = [];
      const refresh = (now) => window.refreshes.push(now) && requestAnimationFrame(refresh);
      requestAnimationFrame(refresh);
      if (range) window.player.loopRange = { from: 0, to: range };
      return window.player.play();
    }, loop);
    const end = performance.now() + 1000 * (loop ? LOOPED : seconds + 60);
    while (performance.now() < end && !(await page.evaluate(() => window.player.ended)))
      await new Promise((done) => setTimeout(done, 500));
    const record = await page.evaluate(() => ({
      clicks: window.heard.clicks,
      shown: window.shown,
      refreshes: window.refreshes,
    }));
    if (opened.browser.troubles.length) throw new Error(opened.browser.troubles.join("\n"));
    return judge(record, seconds);
  } finally {
    await opened.close();
  }
}

const seconds = Number(process.argv[2] ?? 60);
const folder = mkdtempSync(join(tmpdir(), "fvv-sound-"));
try {
  const clip = makeClip(folder, seconds);
  console.log(JSON.stringify({ seconds, once: await play(clip, seconds, 0), loop: await play(clip, seconds, LOOP) }));
} finally {
  rmSync(folder, { recursive: true, force: true });
}
