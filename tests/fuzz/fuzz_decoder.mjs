// Mutations of streams for the browser's decoder, in Node: it throws nothing but its own error, and never hangs.
//
// usage: node fuzz_decoder.mjs [--seconds=N] [--seed=N] [--crashes=FOLDER] FOLDER...
// The first folder is for what other fuzzers find, and is not written to. A worker decodes, so that this process
// can notice that it hangs. Exit code 1: an input was written to the folder of crashes.

import { mkdirSync, readdirSync, readFileSync, existsSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { isMainThread, parentPort, Worker, workerData } from "node:worker_threads";

const dist = new URL("../../js/decoder/dist/", import.meta.url);
const mostSeconds = 10; // for one input
const mostBytes = 16384;

/** Pseudorandom numbers of a seed, the same everywhere. */
class Random {
  constructor(seed) {
    this.state = BigInt(seed) * 2n + 1n;
  }
  below(count) {
    this.state = BigInt.asUintN(64, this.state * 6364136223846793005n + 1442695040888963407n);
    return Number(this.state >> 33n) % count;
  }
}

const table = Uint32Array.from({ length: 256 }, (_, byte) => {
  for (let bit = 0; bit < 8; bit++) byte = (byte >>> 1) ^ (byte & 1 ? 0x82f63b78 : 0);
  return byte;
});

/** Unlike the decoder's, it continues. */
function crc32c(bytes, before = 0) {
  let crc = ~before;
  for (let i = 0; i < bytes.length; i++) crc = (crc >>> 8) ^ table[(crc ^ bytes[i]) & 255];
  return ~crc >>> 0;
}

/** The chunks of a stream by the sizes in their headers; what does not fit is cut. */
function split(bytes) {
  const chunks = [];
  for (let at = 24; at + 32 <= bytes.length;) {
    const size = new DataView(bytes.buffer, bytes.byteOffset + at).getUint32(16, true);
    const end = Math.min(bytes.length, at + 32 + size);
    chunks.push({ header: bytes.slice(at, at + 32), payload: bytes.slice(at + 32, end) });
    at += 32 + 8 * Math.ceil(size / 8);
  }
  return { head: bytes.slice(0, 24), chunks };
}

function join_({ head, chunks }) {
  const size = chunks.reduce((sum, { payload }) => sum + 32 + 8 * Math.ceil(payload.length / 8), head.length);
  const out = new Uint8Array(size);
  out.set(head);
  let at = head.length;
  for (const { header, payload } of chunks) {
    out.set(header, at);
    out.set(payload, at + 32);
    at += 32 + 8 * Math.ceil(payload.length / 8);
  }
  return out;
}

const typeOf = ({ header }) => String.fromCharCode(...header.subarray(0, 4));
const viewOf = (array) => new DataView(array.buffer, array.byteOffset, array.length);

/** Sizes and CRCs; all: also counters, digests, chains and the index, as long as no chunk came or went. */
function repair(stream, all) {
  const { head, chunks } = stream;
  if (head.length === 24) viewOf(head).setUint32(20, crc32c(head.subarray(0, 20)), true);
  const digests = [];
  const chains = [];
  let counter = 0;
  let digest = 0;
  let chain = 0;
  let inGroup = false;
  let indexCrc = 0;
  for (const chunk of chunks) {
    const type = typeOf(chunk);
    const header = viewOf(chunk.header);
    const payload = viewOf(chunk.payload);
    if (all) {
      if (["SCEN", "GRUP", "INDX"].includes(type)) counter = 0;
      chunk.header[5] = counter++ & 255;
      if (type === "SCEN") digest = 0;
      if (type === "SCEN" || type === "INDX") inGroup = false;
      if (type === "GRUP" && payload.byteLength >= 8) {
        payload.setUint32(4, digest, true);
        if (!inGroup) digests.push(digest);
        inGroup = true;
        chain = 0;
      }
      if (type === "GEND" && payload.byteLength >= 12) {
        payload.setUint32(8, chain, true);
        chains.push(chain);
        inGroup = false;
      }
      if (type === "INDX") repairIndex(payload, digests, chains);
      if (type === "FOOT" && payload.byteLength >= 20) payload.setUint32(16, indexCrc, true);
    }
    header.setUint32(16, chunk.payload.length, true);
    header.setUint32(24, crc32c(chunk.payload), true);
    header.setUint32(28, crc32c(chunk.header.subarray(0, 28)), true);
    if (type === "INDX") indexCrc = header.getUint32(24, true);
    if (inGroup) chain = crc32c(chunk.header.subarray(0, 28), chain);
    else digest = crc32c(chunk.header.subarray(0, 28), digest);
  }
  return join_(stream);
}

function repairIndex(payload, digests, chains) {
  if (payload.byteLength < 8) return;
  const groups = payload.getUint32(0, true);
  const blocks = payload.getUint32(4, true);
  if (payload.byteLength < 8 + 16 * blocks + 52 * groups) return;
  for (let i = 0; i < blocks; i++) payload.setUint32(8 + 16 * i + 12, digests[i] ?? 0, true);
  for (let i = 0; i < groups; i++) payload.setUint32(8 + 16 * blocks + 52 * i + 40, chains[i] ?? 0, true);
}

const odd = [0, 1, 2, 0x7f, 0x80, 0xff, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff];

function mutatePayload(payload, random) {
  if (!payload.length) return payload;
  const place = random.below(Math.min(payload.length, random.below(3) ? 48 : payload.length));
  if (random.below(3) || place + 4 > payload.length) payload[place] ^= 1 << random.below(8);
  else viewOf(payload).setUint32(place, odd[random.below(odd.length)], true);
  return payload;
}

function mutate(bytes, random) {
  if (!random.below(12)) {
    const out = bytes.slice(0, random.below(4) ? bytes.length : random.below(bytes.length + 1));
    if (out.length) out[random.below(out.length)] ^= 1 << random.below(8);
    return out;
  }
  const stream = split(bytes);
  const { chunks } = stream;
  if (!chunks.length) return bytes;
  for (let edits = 1 + random.below(3); edits; edits--) {
    const i = random.below(chunks.length);
    const what = random.below(12);
    if (what < 8) chunks[i].payload = mutatePayload(chunks[i].payload, random);
    else if (what === 8) chunks[i].header[random.below(16)] ^= 1 << random.below(8);
    else if (what === 9) chunks.splice(i, 1);
    else if (what === 10) chunks.splice(i, 0, { header: chunks[i].header.slice(), payload: chunks[i].payload.slice() });
    else chunks[i].payload = chunks[i].payload.slice(0, random.below(chunks[i].payload.length + 1));
    if (!chunks.length) break;
  }
  return repair(stream, random.below(4) > 0);
}

/** Reads all that a frame has, so that lazy parts are decoded too. */
function touch(frame) {
  for (const mesh of frame.meshes)
    for (const name of ["lattice", "faces", "positions", "normals", "uvs", "colours"]) void mesh[name]?.length;
  for (const visibility of frame.visibility)
    for (const camera of visibility.cameras) void visibility.weightsOf(camera).length;
  for (const camera of frame.cameras) if (camera.calibrated) void camera.project(0.25, 1, -0.5);
  for (const { track, shows } of frame.configuration.videos) if (shows === "tiles") void frame.tiles(track).length;
  for (const sample of frame.samples) void sample.data.length;
}

async function decode(source, { createDecoder, FvvError }) {
  try {
    const decoder = await createDecoder({ source });
    decoder.addEventListener("warning", () => {});
    for await (const frame of decoder) {
      touch(frame);
      frame.close();
    }
    decoder.close();
  } catch (error) {
    if (!(error instanceof FvvError)) return `${error?.stack ?? error}`;
  }
  return null;
}

async function work() {
  const { createDecoder, FvvError } = await import(new URL("index.js", dist));
  const { seeds, seed } = workerData;
  const random = new Random(seed);
  for (;;) {
    let bytes = seeds[random.below(seeds.length)];
    for (let rounds = 1 + random.below(4); rounds; rounds--) bytes = mutate(bytes, random);
    const live = random.below(2) === 1;
    parentPort.postMessage({ bytes, live });
    const problem = await decode(live ? new Blob([bytes]).stream() : bytes, { createDecoder, FvvError });
    if (problem) parentPort.postMessage({ problem });
  }
}

/** All files of the folders that are short enough. */
function seedsOf(folders) {
  const files = folders.filter(existsSync).flatMap((folder) =>
    readdirSync(folder)
      .sort()
      .map((name) => join(folder, name)),
  );
  return files.map((file) => new Uint8Array(readFileSync(file))).filter((bytes) => bytes.length <= mostBytes);
}

async function main() {
  const options = { seconds: 10, seed: 1, crashes: "" };
  const folders = [];
  for (const word of process.argv.slice(2)) {
    const [, name, value] = /^--(\w+)=?(.*)$/.exec(word) ?? [];
    if (name === "available") {
      if (!existsSync(dist)) console.log("js/decoder/dist is missing: js/decoder/wasm/build.sh makes it");
      return existsSync(dist) ? 0 : 1;
    }
    if (name && !(name in options)) {
      console.error(`fuzz_decoder.mjs: unknown option ${word}`);
      return 2;
    }
    if (name) options[name] = name === "crashes" ? value : Number(value);
    else folders.push(word);
  }
  const seeds = seedsOf(folders);
  if (!seeds.length) {
    console.error("fuzz_decoder.mjs: no seeds: name folders with streams of at most 16 KiB");
    return 2;
  }
  const end = performance.now() + 1000 * options.seconds;
  let executions = 0;
  let crashes = 0;
  let last = null;
  const keep = (problem) => {
    crashes++;
    console.error(`${last.live ? "live" : "file"}: ${problem}`);
    if (!options.crashes) return;
    mkdirSync(options.crashes, { recursive: true });
    writeFileSync(join(options.crashes, `crash-${options.seed}-${executions}`), last.bytes);
  };
  for (let part = 0; performance.now() < end && crashes < 10; part++) {
    const worker = new Worker(fileURLToPath(import.meta.url), {
      workerData: { seeds, seed: options.seed + 1000 * part },
    });
    let heard = performance.now();
    let ended = null;
    worker.on("message", ({ bytes, live, problem }) => {
      heard = performance.now();
      if (problem) keep(problem);
      else {
        last = { bytes, live };
        executions++;
      }
    });
    worker.on("error", (error) => (ended = `the worker ended: ${error.stack ?? error}`));
    while (performance.now() < end && !ended && performance.now() - heard < 1000 * mostSeconds)
      await new Promise((resolve) => setTimeout(resolve, 50));
    if (ended) keep(ended);
    else if (performance.now() - heard >= 1000 * mostSeconds) keep(`nothing for ${mostSeconds} s`);
    await worker.terminate();
  }
  console.log(`stat::number_of_executed_units: ${executions}\nstat::new_units_added: 0`);
  return crashes ? 1 : 0;
}

if (isMainThread) process.exitCode = await main();
else await work();
