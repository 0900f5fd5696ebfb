// Streams as folders: from the beginning, from any time, and with files that are missing.

import assert from "node:assert/strict";
import { mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";

import { createDecoder } from "../dist/index.js";
import { frameHashes, makeClips, nativeFrames, tool } from "./native.mjs";
import { serve } from "./server.mjs";

const { clips, done } = makeClips("moving");
const folder = mkdtempSync(join(tmpdir(), "fvv-segments-"));
tool("fvvmux", clips.moving, "--segments", join(folder, "moving"));
const files = Object.fromEntries(
  readdirSync(join(folder, "moving")).map((name) => [`moving/${name}`, join(folder, "moving", name)]),
);
for (const [name, text] of [
  ["none.json", "not json"],
  ["other.json", '{"fvv_segments": 2}'],
  ["escaping.json", '{"fvv_segments": 1, "configuration": {"file": "../x", "bytes": 1}}'],
]) {
  files[name] = join(folder, name);
  writeFileSync(files[name], text);
}
files["lossy/manifest.json"] = files["moving/manifest.json"];
files["lossy/configuration.fvv"] = files["moving/configuration.fvv"];
files["lossy/group-000001.fvv"] = files["moving/group-000001.fvv"];
const server = await serve(files);
after(() => {
  server.close();
  done();
  rmSync(folder, { recursive: true });
});

async function frames(decoder) {
  const all = [];
  for await (const frame of decoder) all.push(frameHashes(frame));
  return all;
}

test("the same frames, in order and from any of them", async () => {
  const expected = nativeFrames(clips.moving);
  const decoder = await createDecoder({ source: `${server.url}/whole/moving/manifest.json`, shares: true });
  const said = [];
  for (const type of ["corrupt", "gap", "warning"]) decoder.addEventListener(type, ({ detail }) => said.push(detail));
  assert.equal(decoder.seekable, true);
  assert.equal(decoder.frameCount, 5);
  assert.deepEqual(await frames(decoder), expected);
  for (const n of [4, 1, 3]) {
    await decoder.seek({ frame: n });
    const frame = await decoder.next();
    assert.equal(frame.number, n);
    assert.deepEqual([frameHashes(frame), ...(await frames(decoder))], expected.slice(n));
    await decoder.seek({ time: frame.time });
    assert.equal((await decoder.next()).number, n);
  }
  assert.deepEqual(said, []);
  decoder.close();
});

test("a group that is missing is a gap", async () => {
  const decoder = await createDecoder({ source: `${server.url}/whole/lossy/manifest.json`, shares: true });
  const gaps = [];
  decoder.addEventListener("gap", ({ detail }) => gaps.push(detail));
  assert.deepEqual(await frames(decoder), nativeFrames(clips.moving).slice(3));
  assert.equal(gaps.length, 1);
  assert.match(gaps[0].error.message, /404/);
  decoder.close();
});

test("manifests that are none", async () => {
  for (const name of ["none", "other", "escaping"])
    await assert.rejects(createDecoder({ source: `${server.url}/whole/${name}.json` }), { code: "invalid" });
});
