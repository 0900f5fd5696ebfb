// Measures viewpoints of a file with several tracks of video: node view.mjs FILE [X,Y,Z]. Plays the file from a host that
// supports Range, over 8 Mbit/s and 40 ms, with all tracks, and then from positions of cameras with the tracks that look
// selects. Prints JSON: requested bytes, requests, milliseconds to the first and to the last frame, and requests of a second
// loop.

import { createDecoder } from "../js/decoder/dist/index.js";
import { compileCodec, compileCore, compileProjection } from "../js/decoder/dist/modules.js";
import { serve } from "../js/decoder/test/server.mjs";
import { shapedProxy } from "./network/shaped_proxy.mjs";

/** The target of viewers; default: the middle of the generated captures. */
const target = (process.argv[3] ?? "0,1,0").split(",").map(Number);
const SHARES = [0.8, 0.95, 1];

const LINK = { bitsPerSecond: 8e6, roundTripMs: 40 };

await Promise.all([compileCore(), compileCodec("draco"), compileProjection()]);
const server = await serve({ clip: process.argv[2] });

async function play(look) {
  const proxy = await shapedProxy(Number(new URL(server.url).port), LINK);
  const before = server.requests.length;
  const begin = performance.now();
  const decoder = await createDecoder({ source: `http://127.0.0.1:${proxy.port}/range/clip`, video: "encoded", look });
  let seconds = 0;
  let firstMs, cameras, tracks;
  for await (const frame of decoder) {
    firstMs ??= performance.now() - begin;
    seconds += frame.duration;
    ({ cameras } = frame);
    const { videos } = frame.configuration;
    tracks = [frame.tracks?.length ?? videos.length, videos.length];
    frame.close();
  }
  const ms = performance.now() - begin;
  const requests = server.requests.length - before;
  const bytes = server.requests.slice(before).reduce((sum, line) => {
    const [, from, to] = /bytes=(\d*)-(\d+)/.exec(line);
    return sum + (from === "" ? Number(to) : to - from + 1);
  }, 0);
  await decoder.seek({ frame: 0 });
  for await (const frame of decoder) frame.close();
  const requestsAgain = server.requests.length - before - requests;
  decoder.close();
  proxy.close();
  return { seconds, cameras, tracks, bytes, requests, firstMs, ms, requestsAgain };
}

const mean = (rows, value) => rows.reduce((sum, row) => sum + value(row), 0) / rows.length;

await play(); // warms up the code
const { cameras, seconds, ...whole } = await play();
const views = [];
for (const share of SHARES) {
  const rows = [];
  for (const { centre } of cameras.filter((_, i) => i % 3 === 0)) rows.push(await play({ eye: centre, target, share }));
  const means = ["bytes", "requests", "firstMs", "ms", "requestsAgain"].map((name) => [
    name,
    mean(rows, (row) => row[name]),
  ]);
  views.push({ share, tracks: mean(rows, (row) => row.tracks[0]), ...Object.fromEntries(means) });
}
console.log(JSON.stringify({ seconds, all: { ...whole, tracks: whole.tracks[1] }, views }));
server.close();
