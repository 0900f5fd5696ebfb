// Plays a live stream with a ladder over a link whose rate changes: node live_ladder.mjs FILE. fvvserve sends FILE at its pace.
// Prints, as JSON, what the decoder chose, how late frames came and what was lost, beside each rung alone. Time is real.

import { createDecoder } from "../../js/decoder/dist/index.js";
import { WebSocket } from "../../js/decoder/test/server.mjs";
import { serveFolder } from "../../js/testing/served.mjs";
import { shapedProxy } from "./shaped_proxy.mjs";

const [file] = process.argv.slice(2);
const ROUND_TRIP_MS = 40;
/** Megabits per second, each for a part of the time: from 16 to 1 and back. */
const PATTERN = [16, 1, 16];
const SECONDS = 60;

/** delays: seconds that each frame came later than if it had come as fast as the fastest. */
async function play(rung) {
  const served = await serveFolder({ clip: file });
  const proxy = await shapedProxy(Number(new URL(served.url).port), {
    bitsPerSecond: 1e6 * PATTERN[0],
    roundTripMs: ROUND_TRIP_MS,
  });
  const decoder = await createDecoder({
    source: { url: `ws://127.0.0.1:${proxy.port}/live/clip`, WebSocket },
    rung,
    normals: false,
    visibility: false,
  });
  let gaps = 0;
  decoder.addEventListener("warning", ({ detail }) => (gaps += detail.code === "gap"));
  const timers = PATTERN.map((rate, i) =>
    setTimeout(() => proxy.setRate(1e6 * rate), (1000 * SECONDS * i) / PATTERN.length),
  );
  const began = performance.now();
  const frames = [];
  while (performance.now() - began < 1000 * SECONDS) {
    const frame = await decoder.next();
    if (!frame || frame.seconds < (frames.at(-1)?.seconds ?? 0)) break; // the loop begins again
    const now = (performance.now() - began) / 1000;
    const { seconds, rung, samples, meshes } = frame;
    frames.push({ now, seconds, late: now - seconds, rung, whole: samples.length === 1 && meshes.length === 1 });
    frame.close();
  }
  timers.forEach(clearTimeout);
  const { rungs } = decoder;
  decoder.close();
  proxy.close();
  served.close();
  const least = Math.min(...frames.map(({ late }) => late));
  return { rungs, gaps, frames: frames.map(({ late, ...frame }) => ({ ...frame, delay: late - least })) };
}

const rows = [];
let rungs;
for (const rung of ["auto", 0, 1, 2]) {
  if (rungs && rung >= rungs.length) break;
  const found = await play(rung);
  rungs ??= found.rungs;
  const delays = found.frames.map(({ delay }) => delay).sort((a, b) => a - b);
  const third = (i) =>
    found.frames.filter(({ now }) => Math.floor((now / SECONDS) * PATTERN.length) === i).map(({ rung }) => rung);
  rows.push({
    rung,
    frames: found.frames.length,
    gaps: found.gaps,
    wrong_frames: found.frames.filter(({ whole }) => !whole).length,
    median_delay: Number(delays[delays.length >> 1].toFixed(3)),
    p95_delay: Number(delays[Math.floor(0.95 * delays.length)].toFixed(3)),
    largest_delay: Number(delays.at(-1).toFixed(3)),
    // Share of frames in each rung, for each rate.
    shares: PATTERN.map((_, i) =>
      found.rungs.map((__, rung) => Number((third(i).filter((r) => r === rung).length / third(i).length).toFixed(2))),
    ),
  });
}
console.log(JSON.stringify({ rungs: rungs.map(({ bitRate, scale }) => ({ bitRate, scale })), rows }));
