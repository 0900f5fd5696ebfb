// Damaged and hostile bytes lead to an error or a gap, never to a wrong frame, an aborted instance, or more memory than
// the limit.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { root } from "../../testing/served.mjs";
import { createDecoder, FvvError } from "../dist/index.js";
import { compileCodec, compileCore } from "../dist/modules.js";
import { Session } from "../dist/session.js";
import { Cache } from "../dist/sources/cache.js";
import { createCodec, sample } from "../dist/wasm.js";
import { damaged, joinStreams, replaceFirst, replaceMesh, withEmptyGroups, withUnknown } from "./edit_streams.mjs";
import { conformanceFiles, frameHashes, makeClips, nativeFrames } from "./native.mjs";

const { clips, done } = makeClips("delta", "moving", "draco", "fast", "hull");
after(done);

/** All frames, and the kinds of all reports. */
async function survive(source, options = {}) {
  const frames = [];
  const reports = [];
  try {
    const decoder = await createDecoder({ source, ...options });
    onReports(decoder, ["warning", "damage", "gap"], (kind) => reports.push(kind));
    for await (const frame of decoder) frames.push(frameHashes(frame));
    decoder.close();
  } catch (error) {
    assert.ok(error instanceof FvvError, `${error.stack}`);
    reports.push(error.code);
  }
  return { frames, reports };
}

for (const file of [...conformanceFiles(), clips.delta, clips.moving])
  test(`${file.split("/").at(-1)}: flipped bits and cuts never yield a wrong frame`, async () => {
    const whole = new Uint8Array(readFileSync(file));
    const good = new Map(nativeFrames(file).map((frame) => [frame["time 0"], frame]));
    let reported = 0;
    const cases = [...damaged(whole, 60)];
    for (const bytes of cases) {
      // As bytes with an index, and as a stream without.
      for (const source of [bytes, new Blob([bytes]).stream()]) {
        const { frames, reports } = await survive(source);
        for (const frame of frames) assert.deepEqual(frame, good.get(frame["time 0"]));
        if (reports.length) reported++;
      }
    }
    assert.ok(reported > cases.length / 2, `${reported} of ${2 * cases.length} were reported`);
  });

test("an intact repetition of a lost configuration block serves the groups before and after it", async () => {
  const clip = readFileSync(clips.delta);
  const whole = joinStreams(clip, clip, 1); // the block again before the second group
  const second = whole.indexOf("SCEN", 30, "latin1");
  const { frames: good, reports } = await survive(new Uint8Array(whole));
  assert.deepEqual(reports, []);
  const hurt = (at) => {
    const bytes = new Uint8Array(whole);
    bytes[at] ^= 1;
    return bytes;
  };
  for (const at of [24 + 9, 24 + 40, second + 9, second + 40]) {
    const found = await survive(hurt(at));
    assert.deepEqual(found.frames, good);
    assert.ok(found.reports.includes("damage"));
  }
  // A stream that is read once has only the blocks that came before.
  const stream = (at) => survive(new Blob([hurt(at)]).stream());
  assert.deepEqual((await stream(second + 40)).frames, good);
  const late = (await stream(24 + 40)).frames;
  assert.ok(late.length > 0 && late.length < good.length);
  assert.deepEqual(late, good.slice(-late.length));
});

/** Offset, size and type of each chunk. */
function* chunksOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  for (let at = 24; at < bytes.length;) {
    const size = 32 + Math.ceil(Number(view.getBigUint64(at + 16, true)) / 8) * 8;
    yield { at, end: at + size, type: String.fromCharCode(...bytes.subarray(at, at + 4)) };
    at += size;
  }
}
const vector = (name) => new Uint8Array(readFileSync(conformanceFiles().find((file) => file.endsWith(name))));

test("a configuration that only the second group finds is reported before its frames", async () => {
  const whole = vector("vector_texturing_default/input.fvv");
  const chunks = [...chunksOf(whole)];
  const group = chunks.find(({ type }) => type === "GRUP");
  const block = chunks.find(({ at, type }) => type === "SCEN" && at > group.at);
  const part = ({ at, end }) => whole.subarray(at, end);
  // The first group begins where the second block did, and has lost its own block.
  const pieces = [whole.subarray(0, group.at), part(block), whole.subarray(group.end, block.at), part(group)];
  const bytes = new Uint8Array(Buffer.concat([...pieces, whole.subarray(block.end)]));
  const { reports } = await survive(bytes);
  assert.ok(
    reports.every((code) => ["damage", "gap", "warning"].includes(code)),
    reports.join(" "),
  );
});

test("a group that names another configuration is not decoded", async () => {
  const file = join(root, "conformance/cases/faulty/digest_wrong/input.fvv");
  const decoder = await createDecoder({ source: new Uint8Array(readFileSync(file)) });
  const issues = [];
  onReports(decoder, ["damage"], (_, detail) => issues.push(detail.issue));
  const times = [];
  for await (const frame of decoder) times.push(frame.time);
  decoder.close();
  assert.deepEqual(times, [0n, 1n, 10n, 11n]);
  assert.ok(issues.includes(1207));
});

test("sound comes after the configuration, also where damage comes first", async () => {
  const whole = vector("vector_audio_two_sounds/input.fvv");
  const chunks = [...chunksOf(whole)];
  const [begin] = chunks.filter(({ type }) => type === "GRUP");
  const [end] = chunks.filter(({ type }) => type === "GEND");
  const bytes = new Uint8Array(Buffer.concat([whole.subarray(0, begin.at), whole.subarray(end.end)]));
  const decoder = await createDecoder({ source: bytes, sound: "encoded", video: "encoded" });
  const configured = [];
  decoder.addEventListener("sound", () => configured.push(decoder.configuration !== null));
  for await (const frame of decoder) frame.close();
  decoder.close();
  assert.ok(configured.length > 0 && configured.every(Boolean));
});

test("the worker ends if a stream cannot be opened", async () => {
  const started = [];
  globalThis.Worker = class extends EventTarget {
    terminated = false;
    constructor() {
      super();
      started.push(this);
      queueMicrotask(() => this.#post({ id: 0, result: "ready" }));
    }
    #post(data) {
      this.dispatchEvent(Object.assign(new Event("message"), { data }));
    }
    postMessage({ id }) {
      const error = new FvvError({ code: "io", message: "gone" }).toPlain();
      queueMicrotask(() => this.#post({ id, error }));
    }
    terminate() {
      this.terminated = true;
    }
  };
  try {
    await assert.rejects(createDecoder({ source: new Uint8Array(24), worker: () => new Worker() }), /gone/);
  } finally {
    delete globalThis.Worker;
  }
  assert.deepEqual(
    started.map(({ terminated }) => terminated),
    [true],
  );
});

test("a worker that the page started earlier is used, though its announcement was missed", async () => {
  globalThis.Worker = class extends EventTarget {
    terminate() {}
    postMessage({ id, name }) {
      const result = name === "ready" ? name : { rungs: null };
      queueMicrotask(() => this.dispatchEvent(Object.assign(new Event("message"), { data: { id, result } })));
    }
  };
  try {
    const worker = new Worker();
    const decoder = await createDecoder({ source: new Uint8Array(24), worker });
    assert.equal(decoder.inWorker, true);
    decoder.close();
  } finally {
    delete globalThis.Worker;
  }
});

test("an unknown chunk in the middle of a frame does not affect it", async () => {
  const { frames } = await survive(new Blob([withUnknown(new Uint8Array(readFileSync(clips.delta)))]).stream());
  assert.ok(frames.length >= 2, `${frames.length} frames`);
  assert.deepEqual(frames, nativeFrames(clips.delta).slice(0, frames.length));
});

test("a lost group leaves a gap, and playback continues after it", async () => {
  const bytes = new Uint8Array(readFileSync(clips.delta));
  const session = await Session.create({
    module: await compileCore(),
    read: (at, out) => (out.set(bytes.subarray(at, at + out.length)), true),
  });
  session.open(bytes.length);
  const [first, second] = session.groups();
  bytes[first.offset + 200] ^= 1;
  const decoder = await createDecoder({ source: bytes });
  const gaps = [];
  onReports(decoder, ["gap"], (_, detail) => gaps.push(detail));
  const numbers = [];
  for await (const frame of decoder) numbers.push(frame.number);
  assert.deepEqual(numbers, [3, 4]);
  assert.equal(gaps.length, 1);
  assert.equal(gaps[0].to, second.start);
  assert.equal(gaps[0].issue, 1103);
});

for (const [name, file] of [
  ["a decimated mesh", clips.draco],
  ["a hull", clips.hull],
])
  test(`Draco with good CRCs and bad bits, ${name}: the same as libfvv`, async () => {
    const bytes = new Uint8Array(readFileSync(file));
    const folder = mkdtempSync(join(tmpdir(), "fvv-bits-"));
    let decoded = 0;
    for (let n = 0; n < 150; n++) {
      const changed = replaceMesh(bytes, (payload) => {
        // Half of them in what the connectivity begins with.
        const length = n % 2 ? payload.length - 24 : 400;
        payload[24 + ((n * 7919) % length)] ^= 1 << (n % 8);
        return payload;
      });
      const path = join(folder, `${n}.fvv`);
      writeFileSync(path, changed);
      const { frames } = await survive(changed);
      const expected = nativeFrames(path);
      const mesh = Object.keys(expected[0]).some((name) => name.startsWith("lattice"));
      if (mesh) decoded++;
      // Without a mesh, the decoder drops the group.
      assert.deepEqual(frames, mesh ? expected : expected.slice(3));
    }
    rmSync(folder, { recursive: true });
    assert.ok(decoded > 10 && decoded < 140, `${decoded} of 150 decode to another mesh`);
  });

test("the mesh that warms Draco up decodes, by what large meshes are coded with", async () => {
  const bytes = Uint8Array.from(atob(sample.base64), (c) => c.charCodeAt(0));
  const { memory, exports } = await createCodec(await compileCodec("draco"), 2 ** 26);
  const input = exports.fvvcodec_alloc(bytes.length);
  new Uint8Array(memory.buffer, input).set(bytes);
  const VALENCE = 2;
  assert.equal(bytes[11], VALENCE);
  assert.equal(exports.fvvcodec_check(input, bytes.length, sample.vertices, sample.faces, 0, 0), 0);
  assert.equal(exports.fvvcodec_decode(input, bytes.length, sample.vertices, sample.faces, 0, 0), 0);
  const indices = new Uint32Array(memory.buffer, exports.fvvcodec_array(1), 3 * sample.faces);
  assert.equal(new Set(indices).size, sample.vertices);
});

test("Draco decodes only what has been checked", async () => {
  const { memory, exports } = await createCodec(await compileCodec("draco"), 2 ** 26);
  const bytes = new Uint8Array(64);
  const input = exports.fvvcodec_alloc(bytes.length);
  new Uint8Array(memory.buffer, input).set(bytes);
  const STATE = -5;
  assert.equal(exports.fvvcodec_decode(input, bytes.length, 4, 4, 0, 0), STATE);
  assert.ok(exports.fvvcodec_check(input, bytes.length, 4, 4, 0, 0) < 0);
  assert.equal(exports.fvvcodec_decode(input, bytes.length, 4, 4, 0, 0), STATE);
});

/** Issues that are reported if a bit of the first such chunk is flipped. at: negative counts from the end. */
async function issuesOf(file, type, at) {
  const changed = replaceFirst(type, new Uint8Array(readFileSync(file)), (payload) => {
    payload[at < 0 ? payload.length + at : at] ^= 0x40;
    return payload;
  });
  const decoder = await createDecoder({ source: changed });
  const issues = [];
  onReports(decoder, ["damage"], (_, detail) => issues.push(detail.issue));
  for await (const frame of decoder) frame.close();
  return issues;
}

test("rarely used codecs check their input, as libfvv does", async () => {
  const picture = conformanceFiles().find((file) => file.endsWith("vector_openexr_bars/input.fvv"));
  // The first byte of the vertex stream follows a header of 16 bytes and a size of 4; the index stream ends with its
  // table; a picture begins with a magic number.
  assert.equal((await issuesOf(clips.fast, "MESH", 20))[0], 3025);
  assert.equal((await issuesOf(clips.fast, "MESH", -1))[0], 3026);
  assert.equal((await issuesOf(picture, "VPKT", 0))[0], 4206);
});

test("counts without data cost no memory", async () => {
  const bytes = new Uint8Array(readFileSync(clips.draco));
  for (const count of [2 ** 22, 2 ** 23, 2 ** 32 - 1]) {
    const changed = replaceMesh(bytes, (payload) => {
      new DataView(payload.buffer, payload.byteOffset).setUint32(4, count, true);
      return payload;
    });
    const decoder = await createDecoder({ source: changed });
    const corrupt = [];
    onReports(decoder, ["damage"], (_, detail) => corrupt.push(detail));
    for await (const frame of decoder) frame.close();
    assert.ok(corrupt.length > 0 && corrupt[0].chunk === "MESH");
    assert.ok((await decoder.stats()).memoryBytes <= 2 ** 24);
  }
});

test("no instance grows beyond limits.memory", async () => {
  const vertices = 400000;
  const tetrahedron = conformanceFiles().find((file) => file.endsWith("vector_tiny_tetrahedron/input.fvv"));
  const large = replaceMesh(new Uint8Array(readFileSync(tetrahedron)), (payload) => {
    // A raw mesh that is as large as it claims.
    const faces = vertices / 4;
    const out = new Uint8Array(payload.length - 12 * 8 + 12 * (vertices + faces));
    out.set(payload.subarray(0, payload.length - 12 * 8));
    const view = new DataView(out.buffer);
    view.setUint32(4, vertices, true);
    view.setUint32(8, faces, true);
    return out;
  });
  const { frames, reports } = await survive(large, { limits: { memory: 2 ** 23 } });
  assert.deepEqual(frames, []);
  assert.ok(reports.includes("memory"), reports.join());
  await assert.rejects(createDecoder({ source: large, limits: { memory: 1000 } }), { code: "argument" });
});

test("limits are enforced", async () => {
  const { reports } = await survive(new Uint8Array(readFileSync(clips.draco)), { limits: { maxVertices: 100 } });
  assert.ok(reports.includes("damage"));
});

test("other files are rejected", async () => {
  for (const bytes of [new Uint8Array(0), new TextEncoder().encode("<!doctype html><title>404</title>".repeat(9))])
    await assert.rejects(
      async () => {
        const decoder = await createDecoder({ source: bytes });
        for await (const _ of decoder);
      },
      (error) => error instanceof FvvError && error.fatal && error.issue > 0,
    );
});

test("a hundred thousand groups without frames take about ten times as long as ten thousand", async () => {
  const path = join(root, "conformance/cases/valid/groups_empty_many/input.fvv");
  const base = readFileSync(path);
  const secondsOf = async (count) => {
    const source = withEmptyGroups(base, count);
    const began = performance.now();
    const decoder = await createDecoder({ source });
    assert.equal(decoder.groups.length, count);
    const damage = [];
    onReports(decoder, ["damage"], (_, detail) => damage.push(detail.message));
    assert.equal(await decoder.next(), null);
    await decoder.buffered();
    decoder.close();
    assert.equal(damage[0], undefined);
    return (performance.now() - began) / 1000;
  };
  await secondsOf(1000); // compiles
  const few = Math.min(await secondsOf(10000), await secondsOf(10000));
  const many = await secondsOf(100000);
  // With scans it would be a hundred times.
  assert.ok(many < 25 * few + 0.5, `${few} s, then ${many} s`);
});

test("the cache finds a byte among a hundred thousand units at once", () => {
  const secondsOf = (count) => {
    const cache = new Cache(() => 2 ** 30);
    cache.divide(Array.from({ length: count }, (_, i) => 100 * i));
    const began = performance.now();
    for (let i = 0; i < count; i++) cache.put(100 * i, new Uint8Array(50));
    let found = 0;
    for (let i = 0; i < count; i++) found += cache.coveredUntil(100 * i, 100 * i + 50) - 100 * i;
    assert.equal(found, 50 * count);
    return (performance.now() - began) / 1000;
  };
  secondsOf(1000);
  const few = Math.min(secondsOf(10000), secondsOf(10000));
  const many = secondsOf(100000);
  assert.ok(many < 30 * few + 0.5, `${few} s, then ${many} s`);
});
