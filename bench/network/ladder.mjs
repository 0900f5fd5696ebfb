// Plays a stream with a ladder over a link whose rate changes: node ladder.mjs FILE [MBIT,...]. Prints stalls and quality as
// JSON, beside each rung alone and beside an oracle that knows the link. Time is real: the stream's duration for each line.

import { createDecoder } from "../../js/decoder/dist/index.js";
import { serve } from "../../js/decoder/test/server.mjs";
import { shapedProxy } from "./shaped_proxy.mjs";

const [file, rates] = process.argv.slice(2);
const ROUND_TRIP_MS = 40;
/** Megabits per second, each for a part of the stream's duration; default: from 16 to 1 and back. */
const PATTERN = rates ? rates.split(",").map(Number) : [16, 1, 16];
/** Seconds that are read ahead at most, as in the decoder. */
const TARGET = 12;

const wait = (ms) => new Promise((resolve) => setTimeout(resolve, Math.max(0, ms)));

/** Takes each frame when its time has come, up to until (seconds). Returns stalls, their seconds, the rung of each group and the switches. */
async function play(rung, until = Infinity) {
  const server = await serve({ clip: file });
  const proxy = await shapedProxy(Number(new URL(server.url).port), {
    bitsPerSecond: 1e6 * PATTERN[0],
    roundTripMs: ROUND_TRIP_MS,
  });
  const source = `http://127.0.0.1:${proxy.port}/range/clip`;
  const began = performance.now();
  const decoder = await createDecoder({
    source,
    rung,
    normals: false,
    visibility: false,
    limits: { cacheBytes: 0 },
  });
  let clock = null; // when the first frame would have been shown, moved by stalls
  let duration;
  const timers = [];
  const groups = new Map();
  const result = {
    stalls: 0,
    stalledSeconds: 0,
    firstMs: 0,
    wrong: 0,
    decoder: null,
  };
  for (;;) {
    const frame = await decoder.next();
    if (!frame) break;
    const seconds = frame.seconds;
    if (seconds > until) break;
    if (clock === null) {
      clock = performance.now() - 1000 * seconds;
      result.firstMs = performance.now() - began;
      const { groups: all } = decoder;
      const { numerator, denominator } = frame.configuration.timeBase;
      duration = (Number(all.at(-1).end) * numerator) / denominator;
      PATTERN.forEach((rate, i) =>
        timers.push(setTimeout(() => proxy.setRate(1e6 * rate), (1000 * duration * i) / PATTERN.length)),
      );
    }
    const late = performance.now() - (clock + 1000 * seconds);
    if (late > 40) {
      result.stalls++;
      result.stalledSeconds += late / 1000;
      clock += late;
    }
    const { group, rung, samples, meshes } = frame;
    // Mesh and pictures of one rung each, and all of them.
    if (samples.length !== 1 || meshes.length !== 1) result.wrong++;
    groups.set(group.sequence, rung);
    frame.close();
    await wait(clock + 1000 * seconds - performance.now());
  }
  result.bytes = proxy.bytes();
  result.rungs = [...groups.values()];
  result.table = { rungs: decoder.rungs, groups: decoder.groups, duration };
  timers.forEach(clearTimeout);
  decoder.close();
  proxy.close();
  server.close();
  return result;
}

/** ln of the size beside the lowest rung, as in the paper on BOLA. */
const utilityOf = (rungs) => (rung) => Math.log(rungs[rung].bitRate / rungs.at(-1).bitRate);
const mean = (values) => values.reduce((sum, x) => sum + x, 0) / values.length;

/** Seconds at which bits have arrived that are asked for at a time. */
function arrival(from, bits, duration) {
  let [time, left] = [from, bits];
  for (;;) {
    const part = Math.min(PATTERN.length - 1, Math.floor((time / duration) * PATTERN.length));
    const end = part === PATTERN.length - 1 ? Infinity : ((part + 1) * duration) / PATTERN.length;
    const rate = 1e6 * PATTERN[part];
    if (time + left / rate <= end) return time + left / rate;
    left -= (end - time) * rate;
    time = end;
  }
}

/** The most utility without a stall, for one who knows the link: states are Pareto-optimal pairs of time and utility. */
function oracle({ rungs, groups, duration }) {
  const utility = utilityOf(rungs);
  const seconds = duration / groups.length;
  const bits = rungs.map(({ bitRate }) => bitRate * seconds);
  let states = [{ time: arrival(0, bits.at(-1), duration), sum: 0 }];
  const start = states[0].time;
  for (let i = 1; i < groups.length; i++) {
    const next = [];
    for (const { time, sum } of states)
      rungs.forEach((_, rung) => {
        const from = Math.max(time, start + i * seconds - TARGET);
        const arrived = arrival(from, bits[rung], duration);
        if (arrived <= start + i * seconds) next.push({ time: arrived, sum: sum + utility(rung) });
      });
    next.sort((a, b) => a.time - b.time || b.sum - a.sum);
    let best = -1;
    states = next.filter(({ sum }) => sum > best && ((best = sum), true));
    if (!states.length) return null;
  }
  return Math.max(...states.map(({ sum }) => sum)) / groups.length;
}

// The first line would else wait for code to be compiled.
await play("auto", 2);
const auto = await play("auto");
const { rungs } = auto.table;
const utility = utilityOf(rungs);
const fixed = [];
for (let rung = 0; rung < rungs.length; rung++) fixed.push(await play(rung));
const rows = [auto, ...fixed].map(({ stalls, stalledSeconds, firstMs, wrong, bytes, rungs: taken }, i) => ({
  rung: i ? i - 1 : "auto",
  stalls,
  stalled_seconds: Number(stalledSeconds.toFixed(2)),
  first_ms: Math.round(firstMs),
  wrong_frames: wrong,
  megabytes: Number((bytes / 1e6).toFixed(2)),
  mean_utility: Number(mean(taken.map(utility)).toFixed(3)),
  switches: taken.filter((rung, k) => k && rung !== taken[k - 1]).length,
}));
const smooth = rows.slice(1).filter(({ stalls }) => !stalls);
console.log(
  JSON.stringify({
    rungs: rungs.map(({ bitRate, scale }) => ({ bitRate, scale })),
    rows,
    best_fixed: smooth.length ? Math.max(...smooth.map(({ mean_utility }) => mean_utility)) : null,
    oracle: oracle(auto.table),
    taken: auto.rungs,
  }),
);
