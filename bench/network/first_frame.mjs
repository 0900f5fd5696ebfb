// Measures the first frame of a clip over 8 Mbit/s and 40 ms: node first_frame.mjs FILE. Prints requests, received kilobytes
// and milliseconds as JSON: in Node to the first mesh with its encoded picture; in Chromium, if installed, to the decoded
// picture. Code is loaded and cached before.

import { spawnSync } from "node:child_process";

import { createDecoder } from "../../js/decoder/dist/index.js";
import { compileCodec, compileCore, compileProjection } from "../../js/decoder/dist/modules.js";
import { awaitPost, browsers, visit } from "../../js/decoder/test/browsers.mjs";
import { serve } from "../../js/decoder/test/server.mjs";
import { shapedProxy } from "./shaped_proxy.mjs";

const LINK = { bitsPerSecond: 8e6, roundTripMs: 40 };
const ROUNDS = 5;
const files = { clip: process.argv[2] };
const median = (rows, name) => rows.map((row) => row[name]).sort((a, b) => a - b)[Math.floor(rows.length / 2)];

async function inNode() {
  const server = await serve(files);
  const proxy = await shapedProxy(Number(new URL(server.url).port), LINK);
  const before = server.requests.length;
  const bytesBefore = proxy.bytes();
  const begin = performance.now();
  const decoder = await createDecoder({
    source: `http://127.0.0.1:${proxy.port}/range/clip`,
    queue: 1,
  });
  const frame = await decoder.next();
  const ms = performance.now() - begin;
  if (!frame.mesh || !frame.samples.length) throw new Error("the first frame lacks its mesh or its picture");
  const row = {
    ms,
    kilobytes: (proxy.bytes() - bytesBefore) / 1000,
    requests: server.requests.length - before,
  };
  decoder.close();
  proxy.close();
  server.close();
  return row;
}

async function inChromium() {
  const { result, post } = awaitPost(60);
  const server = await serve(files, post);
  const proxy = await shapedProxy(Number(new URL(server.url).port), LINK);
  const leave = visit(browsers.chromium, `http://127.0.0.1:${proxy.port}/test/first_frame_page.html`);
  try {
    const { ms, error } = await result;
    if (error) throw new Error(error);
    return { ms };
  } finally {
    await leave();
    proxy.close();
    server.close();
  }
}

await Promise.all([compileCore(), compileCodec("draco"), compileProjection()]);
const rows = [];
for (let round = 0; round < ROUNDS; round++) rows.push(await inNode());
const figures = {
  requests: Math.max(...rows.map(({ requests }) => requests)),
  kilobytes: median(rows, "kilobytes"),
  ms: median(rows, "ms"),
};
if (!spawnSync(browsers.chromium.program, ["--version"]).error) {
  const pictures = [];
  for (let round = 0; round < 3; round++) pictures.push(await inChromium());
  figures.picture_ms = median(pictures, "ms");
}
console.log(JSON.stringify(figures));
