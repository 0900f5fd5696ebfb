// URLs: few requests to hosts that support Range, and the same frames from others.

import assert from "node:assert/strict";
import { readFileSync, statSync } from "node:fs";
import { after, test } from "node:test";

import { GroupIndex } from "../dist/sources/group_index.js";
import { createDecoder } from "../dist/index.js";
import { compileCore } from "../dist/modules.js";
import { RangeSource } from "../dist/sources/types.js";
import { Session } from "../dist/session.js";
import { joinStreams } from "./edit_streams.mjs";
import { frameHashes, makeClips, nativeFrames } from "./native.mjs";
import { serve } from "./server.mjs";

const { clips, done } = makeClips("moving");
const server = await serve(clips);
after(() => {
  server.close();
  done();
});

async function open(path, limits) {
  const decoder = await createDecoder({ source: `${server.url}/${path}`, limits });
  const warnings = [];
  decoder.addEventListener("warning", (event) => warnings.push(event.detail.code));
  return { decoder, warnings };
}

async function frames(decoder) {
  const all = [];
  for await (const frame of decoder) all.push(frameHashes(frame));
  return all;
}

test("a host that supports Range: its first and last bytes at the same time, one request more, and seeking", async () => {
  const { decoder, warnings } = await open("range/moving", { cacheBytes: 0 });
  assert.deepEqual(await frames(decoder), nativeFrames(clips.moving));
  assert.deepEqual(warnings, []);
  assert.equal((await decoder.stats()).requests, 3);
  await decoder.seek({ frame: 1 });
  assert.deepEqual(await frames(decoder), nativeFrames(clips.moving).slice(1));
  const { bytesRead, requests } = await decoder.stats();
  assert.equal(requests, 4);
  assert.ok(bytesRead < 2 * statSync(clips.moving).size);
  decoder.close();
});

test("requests for ranges bypass a browser's cache, which would handle them one at a time", async (t) => {
  const real = globalThis.fetch;
  t.after(() => (globalThis.fetch = real));
  const modes = new Set();
  globalThis.fetch = (url, init) => {
    if (init.headers.Range) modes.add(init.cache);
    return real(url, init);
  };
  const { decoder } = await open("range/moving", {});
  await frames(decoder);
  decoder.close();
  assert.deepEqual([...modes], ["no-store"]);
});

for (const behaviour of ["whole", "wrong", "gzip"])
  test(`a host without Range support (${behaviour}): a warning, and the same frames`, async () => {
    const { decoder, warnings } = await open(`${behaviour}/moving`, { cacheBytes: 0 });
    assert.equal(decoder.seekable, false);
    assert.deepEqual(await frames(decoder), nativeFrames(clips.moving));
    assert.deepEqual(warnings, ["no-range"]);
    await assert.rejects(decoder.seek({ frame: 0 }), { code: "state", fatal: false });
    decoder.close();
  });

// Another ETag with the footer of the same index is the same file, from another node of a network.
for (const [behaviour, expected] of [
  ["changing", []],
  ["growing", ["changed"]],
])
  test(`a file that changes while it is read (${behaviour}) is opened again, not mixed`, async () => {
    const { decoder, warnings } = await open(`${behaviour}/moving`, { cacheBytes: 0 });
    assert.deepEqual(await frames(decoder), nativeFrames(clips.moving));
    await decoder.seek({ time: 0n });
    assert.deepEqual(await frames(decoder), nativeFrames(clips.moving));
    assert.deepEqual(warnings, expected);
    assert.equal(decoder.frameCount, 5);
    decoder.close();
  });

test("a host that stops supporting Range: a warning, and the same frames", async () => {
  const { decoder, warnings } = await open("unranged/moving", { cacheBytes: 0 });
  await frames(decoder);
  await decoder.seek({ frame: 1 });
  assert.deepEqual(await frames(decoder), nativeFrames(clips.moving).slice(1));
  assert.deepEqual(warnings, ["no-range"]);
  decoder.close();
});

test("a missing file is an error with its status", async () => {
  await assert.rejects(open("range/nothing"), {
    code: "io",
    message: /\/range\/nothing: HTTP status 404, .*check the address/,
  });
});

test("a host that takes the last bytes for the first ones: a request more, and no warning", async () => {
  const { decoder, warnings } = await open("front/moving");
  assert.equal(decoder.seekable, true);
  assert.deepEqual(await frames(decoder), nativeFrames(clips.moving));
  assert.deepEqual(warnings, []);
  assert.equal((await decoder.stats()).requests, statSync(clips.moving).size > 8192 ? 4 : 3);
  decoder.close();
});

test("a page in place of the stream is named with its type", async () => {
  const message = /\/page\/moving: expected an fvv stream, found Content-Type text\/html: a page .*\[FVV-1001\]$/;
  const { decoder } = await open("page/moving");
  await assert.rejects(decoder.next(), { code: "invalid", issue: 1001, message });
});

test("a host that does not respond is named", async () => {
  const source = "http://127.0.0.1:9/clip.fvv";
  await assert.rejects(createDecoder({ source }), {
    code: "io",
    message: /^http:\/\/127\.0\.0\.1:9\/clip\.fvv: no response \(.+\)\. /,
  });
});

test("the path of a file is explained", async () => {
  for (const source of ["clip.fvv", "./clip.fvv", "/clips/clip.fvv", "C:\\clips\\clip.fvv", "file:///clips/clip.fvv"])
    await assert.rejects(createDecoder({ source }), (error) => {
      assert.equal(error.code, "argument");
      assert.ok(error.message.includes(`found ${source}; in Node, pass the content`), error.message);
      return true;
    });
});

test("a configuration block is one read of its size, also that of a repetition", async () => {
  const clip = readFileSync(clips.moving);
  const bytes = joinStreams(clip, clip, 1); // the block again before the second group
  const reads = [];
  const source = Object.assign(new RangeSource(), {
    size: bytes.length,
    async read(offset, size) {
      reads.push([offset, size]);
      return new Uint8Array(bytes.subarray(offset, offset + size));
    },
  });
  const index = new GroupIndex(source, { readsAnywhere: true });
  const read = (offset, out) => index.readInto(offset, out);
  index.session = await Session.create({ module: await compileCore(), read });
  assert.equal(await index.open(), null);
  const [first, second] = index.groups;
  assert.equal(first.configurationSize, first.offset - 24);
  assert.ok(second.configurationOffset > first.offset);
  const readsOf = async (group) => {
    reads.length = 0;
    index.forgetReads(0);
    assert.ok(await index.satisfied(() => index.session.play(group)));
    return [...reads];
  };
  assert.deepEqual(await readsOf(1), [[second.configurationOffset, second.configurationSize]]);
  bytes[first.configurationOffset + 40] ^= 1; // in SCEN
  const whole = (group) => [group.configurationOffset, group.configurationSize];
  assert.deepEqual(await readsOf(0), [whole(first), whole(second)]);
  index.session.close();
});
