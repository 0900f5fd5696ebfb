// What a viewpoint costs of a file with several tracks of video: node view.mjs FILE [X,Y,Z]. All of it is played from a host that
// keeps to Range, with every track and then from the places of some cameras, with what look selects. Prints JSON: bytes
// and requests that were asked for.

import { createDecoder } from "../js/decoder/dist/index.js";
import { serve } from "../js/decoder/test/server.mjs";

/** Where viewers look: in the generated captures, above the ground in the middle of the scene. */
const target = (process.argv[3] ?? "0,1,0").split(",").map(Number);
const SHARES = [0.8, 0.9, 1];

const server = await serve({ clip: process.argv[2] });

async function play(look) {
  const before = server.requests.length;
  const decoder = await createDecoder({ source: `${server.url}/range/clip`, video: "samples", look });
  let seconds = 0;
  let cameras, tracks;
  for await (const frame of decoder) {
    seconds += frame.duration;
    ({ cameras } = frame);
    const { videos } = frame.configuration;
    tracks = [frame.tracks?.length ?? videos.length, videos.length];
    frame.close();
  }
  const bytes = server.requests.slice(before).reduce((sum, line) => {
    const [, from, to] = /bytes=(\d*)-(\d+)/.exec(line);
    return sum + (from === "" ? Number(to) : to - from + 1);
  }, 0);
  decoder.close();
  return { seconds, cameras, tracks, bytes, requests: server.requests.length - before };
}

const mean = (rows, value) => rows.reduce((sum, row) => sum + value(row), 0) / rows.length;

const { cameras, seconds, ...whole } = await play();
const views = [];
for (const share of SHARES) {
  const rows = [];
  for (const { centre } of cameras.filter((_, i) => i % 3 === 0)) rows.push(await play({ eye: centre, target, share }));
  const tracks = mean(rows, (row) => row.tracks[0]);
  views.push({ share, tracks, bytes: mean(rows, (row) => row.bytes), requests: mean(rows, (row) => row.requests) });
}
console.log(JSON.stringify({ seconds, all: { ...whole, tracks: whole.tracks[1] }, views }));
server.close();
