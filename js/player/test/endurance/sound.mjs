// How far apart pictures and sound are while a long clip is played once: node sound.mjs [SECONDS]. Prints JSON. The clip has a
// clap in each second; Chromium plays it without a GPU.

import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { tool } from "../../../testing/served.mjs";
import { beginRecording, offsetsOf } from "../hearing.mjs";
import { openPage } from "../page_driver.mjs";

const seconds = Number(process.argv[2] ?? 60);
const RATE = 25;
/** Seconds in which the page starts. */
const START = 3;

const folder = mkdtempSync(join(tmpdir(), "fvv-sound-"));
let opened;
try {
  const capture = join(folder, "capture");
  const clip = join(folder, "players.fvv");
  const rig = ["--rig", "small", "--cameras", "1", "--size", "64x48", "--frames", `${seconds * RATE}`];
  tool("fvvsynth", "-o", capture, ...rig, "--sound");
  // Without the ball, whose thumps are loud as well.
  const description = join(capture, "capture.json");
  const { audio, ...rest } = JSON.parse(readFileSync(description, "utf8"));
  writeFileSync(description, JSON.stringify({ ...rest, audio: audio.slice(0, 1) }));
  tool("fvvmux", capture, "-o", clip, "--triangles", "500", "--quality", "36dB", "--visibility", "none");
  opened = await openPage("chromium", clip);
  const { page } = opened;
  await page.waitForFunction(() => window.player.readyState === 4);
  await beginRecording(opened);
  await page.mouse.click(100, 100);
  await page.evaluate(() => window.player.play());
  await page.waitForFunction(() => window.player.ended, { timeout: 1000 * seconds + 60000, polling: 500 });
  const [clicks, shown] = await page.evaluate(() => [window.heard.clicks, window.shown]);
  const frames = Array.from({ length: seconds }, (_, second) => Math.floor((second + 0.5) * RATE));
  const all = offsetsOf(clicks, shown, frames).slice(START);
  const offsets = all.filter((offset) => offset !== null);
  const sorted = offsets.map(Math.abs).sort((a, b) => a - b);
  const mean = (part) => part.reduce((sum, x) => sum + x, 0) / part.length;
  const tenth = Math.max(1, Math.floor(offsets.length / 10));
  const drift = mean(offsets.slice(-tenth)) - mean(offsets.slice(0, tenth));
  const found = { seconds, claps: clicks.length, seen: offsets.length };
  console.log(JSON.stringify({ ...found, maxMs: sorted.at(-1), medianMs: sorted[sorted.length >> 1], driftMs: drift }));
} finally {
  await opened?.close();
  rmSync(folder, { recursive: true, force: true });
}
