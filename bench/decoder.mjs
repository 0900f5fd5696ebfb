// Measures the browser's decoder in Node: node decoder.mjs first|warm|draco3d|beside|stages FILE. Prints milliseconds per
// frame as JSON. first: the first mesh in a new process, without and with compilation of the modules; warm: the median of all frames,
// after enough rounds for the engine's optimising compiler; draco3d: the same for key frames with the npm package of that
// name; beside: both, each frame with one directly after the other, so that other load slows both, and the median ratio;
// stages: what loading, the first key frame and later ones consist of.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

import { compileCodec, compileCore } from "../js/decoder/dist/modules.js";
import { Session } from "../js/decoder/dist/session.js";

const [what, file] = process.argv.slice(2);
const bytes = new Uint8Array(readFileSync(file));
const want = { normals: false, visibility: false };
// During these rounds the engine replaces its first, quick compilation.
const COLD_ROUNDS = 3;
const ROUNDS = 10;
const median = (times) => times.sort((a, b) => a - b)[Math.floor(times.length / 2)];
const least = (times) => (times.length ? Math.min(...times) : null);

async function* frames(session) {
  session.start(0);
  for (const _ of session.push(bytes))
    for (let kind; (kind = session.next()) !== "need data";) {
      if (kind === "done") return;
      if (kind === "frame") yield;
    }
}

/** Milliseconds for which this thread waited for a core; 0 where the system does not report them. */
function waited() {
  try {
    return Number(readFileSync("/proc/self/schedstat", "latin1").split(" ")[1]) / 1e6;
  } catch {
    return 0;
  }
}

async function first() {
  const begin = performance.now();
  const session = await Session.create({ module: await compileCore(), codec: compileCodec });
  for await (const _ of frames(session)) {
    if (session.lacksCodecs) await session.loadCodecs();
    const waitedBefore = waited();
    const ready = performance.now();
    const { meshes } = session.decode(want);
    const end = performance.now();
    return {
      first_ms: end - ready,
      first_waiting_ms: waited() - waitedBefore,
      load_and_first_ms: end - begin,
      triangles: meshes[0].faceCount,
    };
  }
}

async function warm() {
  const session = await Session.create({ module: await compileCore(), codec: compileCodec });
  const key = [];
  const delta = [];
  let triangles;
  for (let round = 0; round < ROUNDS; round++) {
    let former = false;
    for await (const _ of frames(session)) {
      if (session.lacksCodecs) await session.loadCodecs();
      const begin = performance.now();
      const { meshes } = session.decode(want);
      const time = performance.now() - begin;
      triangles = meshes[0].faceCount;
      if (round < COLD_ROUNDS) continue;
      // The first delta frame after a key frame prepares the following ones.
      if (meshes[0].key) key.push(time);
      else if (former) delta.push(time);
      former = !meshes[0].key;
    }
  }
  return {
    key_ms: median(key) ?? null,
    delta_ms: median(delta) ?? null,
    least_key_ms: least(key),
    least_delta_ms: least(delta),
    triangles,
  };
}

/** Bitstreams of Draco in the file's MESH chunks. */
function* bitstreams() {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  for (let at = 24; at + 32 <= bytes.length; at += 32 + 8 * Math.ceil(view.getUint32(at + 16, true) / 8)) {
    const payload = bytes.subarray(at + 32, at + 32 + view.getUint32(at + 16, true));
    if (view.getUint32(at, true) === 0x4853454d && payload[0] === 1) yield payload.subarray(16);
  }
}

/** decode(data): decodes a bitstream with draco3d and returns milliseconds. */
async function createDraco3d() {
  const require = createRequire(new URL("../js/package.json", import.meta.url));
  const draco = await require("draco3d").createDecoderModule({});
  return (data) => {
    const begin = performance.now();
    const decoder = new draco.Decoder();
    const mesh = new draco.Mesh();
    decoder.DecodeArrayToMesh(data, data.length, mesh);
    const corners = 3 * mesh.num_faces();
    const attribute = decoder.GetAttributeByUniqueId(mesh, 0);
    const positions = 3 * mesh.num_points();
    const pointer = draco._malloc(4 * Math.max(corners, positions));
    decoder.GetTrianglesUInt32Array(mesh, 4 * corners, pointer);
    const indices = new Uint32Array(draco.HEAPF32.buffer, pointer, corners).slice();
    decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco.DT_INT32, 4 * positions, pointer);
    const lattice = new Int32Array(draco.HEAPF32.buffer, pointer, positions).slice();
    if (!indices.length || !lattice.length) throw new Error("draco3d decodes nothing");
    draco._free(pointer);
    draco.destroy(mesh);
    draco.destroy(decoder);
    return performance.now() - begin;
  };
}

async function draco3d() {
  const begin = performance.now();
  const decode = await createDraco3d();
  const times = [];
  let loaded = null;
  for (let round = 0; round < ROUNDS; round++)
    for (const data of bitstreams()) {
      times.push(decode(data));
      loaded ??= performance.now() - begin;
    }
  const first_ms = times[0];
  return {
    first_ms,
    load_and_first_ms: loaded,
    key_ms: median(times.slice(COLD_ROUNDS * Math.floor(times.length / ROUNDS))),
    least_key_ms: least(times),
  };
}

/** Of a file of key frames. */
async function beside() {
  const session = await Session.create({ module: await compileCore(), codec: compileCodec });
  const other = await createDraco3d();
  const streams = [...bitstreams()];
  const times = { key: [], draco3d: [], ratio: [] };
  for (let round = 0; round < 2 * ROUNDS; round++) {
    let frame = 0;
    for await (const _ of frames(session)) {
      if (session.lacksCodecs) await session.loadCodecs();
      const begin = performance.now();
      session.decode(want);
      const key = performance.now() - begin;
      const reference = other(streams[frame++]);
      if (round < COLD_ROUNDS) continue;
      times.key.push(key);
      times.draco3d.push(reference);
      times.ratio.push(key / reference);
    }
  }
  return {
    key_ms: median(times.key),
    draco3d_ms: median(times.draco3d),
    ratio: median(times.ratio),
    least_key_ms: least(times.key),
    least_draco3d_ms: least(times.draco3d),
  };
}

/** Sums of the time that calls take. Those of WebAssembly are replaced, and what instances export and import. */
function meterCalls() {
  const sums = {};
  const add = (name, begin) => (sums[name] = (sums[name] ?? 0) + performance.now() - begin);
  const meter =
    (name, call) =>
    (...parameters) => {
      const begin = performance.now();
      try {
        return call(...parameters);
      } finally {
        add(name, begin);
      }
    };
  const { compile, instantiate } = WebAssembly;
  const timed = async (name, call) => {
    const begin = performance.now();
    const result = await call();
    add(name, begin);
    return result;
  };
  WebAssembly.compile = (bytes) => timed("compile", () => compile(bytes));
  WebAssembly.instantiate = async (module, imports) => {
    for (const name of Object.keys(imports.fvv ?? {}))
      if (/^draco/.test(name)) imports.fvv[name] = meter("codec", imports.fvv[name]);
    const { exports } = await timed("instantiate", () => instantiate(module, imports));
    const metered = /^(fvvjs_decode|fvvcodec_(check|decode))$/;
    const entries = Object.entries(exports).map(([name, value]) => [
      name,
      metered.test(name) ? meter(name, value) : value,
    ]);
    return { exports: Object.fromEntries(entries) };
  };
  return {
    /** What was added since the last call. */
    take() {
      const taken = { ...sums };
      for (const name of Object.keys(sums)) delete sums[name];
      return taken;
    },
  };
}

async function stages() {
  const meter = meterCalls();
  const time = async (call) => {
    meter.take();
    const begin = performance.now();
    await call();
    return { all: performance.now() - begin, ...meter.take() };
  };
  const newSession = async () => Session.create({ module: await compileCore(), codec: compileCodec });
  const frame = async (session) =>
    time(() => session.decode(want)).then(({ all, fvvjs_decode, codec, fvvcodec_check, fvvcodec_decode }) => ({
      all,
      check: fvvcodec_check,
      draco: fvvcodec_decode,
      copies: codec - fvvcodec_check - fvvcodec_decode,
      core: fvvjs_decode - codec,
      arrays: all - fvvjs_decode,
    }));
  const load = ({ all, compile = 0, instantiate = 0, fvvcodec_check = 0, fvvcodec_decode = 0 }) => ({
    unpack: all - compile - instantiate - fvvcodec_check - fvvcodec_decode,
    compile,
    instantiate,
    warm_up: fvvcodec_check + fvvcodec_decode,
  });
  let session;
  const core = load(await time(async () => (session = await newSession())));
  let codec;
  let first;
  const later = [];
  for (let round = 0; round < ROUNDS; round++)
    for await (const _ of frames(session)) {
      if (session.lacksCodecs) codec = load(await time(() => session.loadCodecs()));
      const stages = await frame(session);
      first ??= stages;
      if (round >= COLD_ROUNDS) later.push(stages);
    }
  // The code is optimised by now, and only the memory is new.
  const another = await newSession();
  let fresh;
  for await (const _ of frames(another)) {
    await another.loadCodecs();
    fresh = await frame(another);
    break;
  }
  const names = Object.keys(first);
  const key = Object.fromEntries(names.map((name) => [name, median(later.map((stages) => stages[name]))]));
  return { core, codec, first, fresh, key };
}

console.log(JSON.stringify(await { first, warm, draco3d, beside, stages }[what]()));
