// Streams as folders: from the beginning, from any time, and with missing or wrong files.

import assert from "node:assert/strict";
import { cpSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { createDecoder } from "../dist/index.js";
import {
  environmentHashes,
  frameHashes,
  makeClips,
  nativeEnvironment,
  nativeFrames,
  onlyEnvironment,
  tool,
} from "./native.mjs";
import { serve } from "./server.mjs";

const { clips, done } = makeClips("moving", "environment");
const folder = mkdtempSync(join(tmpdir(), "fvv-segments-"));
tool("fvvmux", clips.moving, "--segments", join(folder, "moving"));
tool("fvvmux", clips.environment, "--segments", join(folder, "environment"));
const files = Object.fromEntries(
  ["moving", "environment"].flatMap((clip) =>
    readdirSync(join(folder, clip)).map((name) => [`${clip}/${name}`, join(folder, clip, name)]),
  ),
);
/** The same folder with a flipped bit in one file. */
function damage(clip, as, name) {
  for (const [known, path] of Object.entries(files))
    if (known.startsWith(`${clip}/`)) files[known.replace(clip, as)] = path;
  const bytes = readFileSync(files[`${as}/${name}`]);
  bytes[bytes.length >> 1] ^= 1;
  files[`${as}/${name}`] = join(folder, `${as}-${name}`);
  writeFileSync(files[`${as}/${name}`], bytes);
}
damage("moving", "flipped", "group-000000.fvv");
damage("moving", "lost", "configuration.fvv");
const [environment] = readdirSync(join(folder, "environment")).filter((name) => name.startsWith("environment"));
damage("environment", "bare", environment);
// Another group, valid in itself.
files["swapped/manifest.json"] = files["moving/manifest.json"];
files["swapped/configuration.fvv"] = files["moving/configuration.fvv"];
files["swapped/group-000000.fvv"] = files["moving/group-000000.fvv"];
files["swapped/group-000001.fvv"] = join(folder, "swapped");
tool(
  "fvvmux",
  clips.moving.replace("moving.fvv", "studio"),
  "-o",
  join(folder, "other.fvv"),
  "--quality",
  "30dB",
  "--group",
  "3",
  "--keep-geometry",
);
tool("fvvmux", join(folder, "other.fvv"), "--segments", join(folder, "other"));
for (const [name, quality] of [
  ["ladder", "36dB"],
  ["ladder-other", "30dB"],
]) {
  const file = join(folder, `${name}.fvv`);
  const studio = clips.moving.replace("moving.fvv", "studio");
  tool("fvvmux", studio, "-o", file, "--quality", quality, "--group", "3", "--ladder", "1,0.5", "--keep-geometry");
  tool("fvvmux", file, "--segments", join(folder, name));
}
cpSync(join(folder, "other/group-000001.fvv"), files["swapped/group-000001.fvv"]);
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
  const decoder = await createDecoder({ source: `${server.url}/whole/moving/manifest.json` });
  const reports = [];
  onReports(decoder, ["damage", "gap", "warning"], (_, detail) => reports.push(detail));
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
  assert.deepEqual(reports, []);
  decoder.close();
});

test("a missing group is a gap", async () => {
  const decoder = await createDecoder({ source: `${server.url}/whole/lossy/manifest.json` });
  const gaps = [];
  onReports(decoder, ["gap"], (_, detail) => gaps.push(detail));
  assert.deepEqual(await frames(decoder), nativeFrames(clips.moving).slice(3));
  assert.equal(gaps.length, 1);
  assert.match(gaps[0].cause.message, /404/);
  decoder.close();
});

test("a file that does not match the manifest: damage, a gap, and nothing of it is shown", async () => {
  const expected = nativeFrames(clips.moving);
  const kinds = [
    ["flipped", "damaged", expected.slice(3)],
    ["swapped", "changed", expected.slice(0, 3)],
  ];
  for (const [name, code, kept] of kinds) {
    const decoder = await createDecoder({
      source: `${server.url}/whole/${name}/manifest.json`,
    });
    const reports = [];
    onReports(decoder, ["damage", "gap"], (kind, detail) => reports.push([kind, detail]));
    assert.deepEqual(await frames(decoder), kept);
    assert.deepEqual(
      reports.map(([type]) => type),
      ["damage", "gap"],
    );
    assert.equal(reports[0][1].code, code);
    assert.match(reports[0][1].message, /group-00000\d\.fvv: .* expected/);
    assert.equal(reports[1][1].cause.code, code);
    decoder.close();
  }
  const decoder = await createDecoder({ source: `${server.url}/whole/lost/manifest.json` });
  await assert.rejects(decoder.next(), { code: "damaged", fatal: true });
});

for (const rungs of [false, true])
  test(`a folder that is replaced${rungs ? ", with a ladder," : ""} is opened again, once`, async () => {
    const [former, latter] = rungs ? ["ladder", "ladder-other"] : ["moving", "other"];
    const take = (name) => {
      for (const entry of readdirSync(join(folder, name), { recursive: true }))
        files[`replaced/${entry}`] = join(folder, name, entry);
    };
    take(former);
    const source = `${server.url}/whole/replaced/manifest.json`;
    const decoder = await createDecoder({ source, rung: rungs ? 0 : "auto", limits: { cacheBytes: 0 } });
    const reports = [];
    onReports(decoder, ["damage", "gap", "warning"], (_, { code }) => reports.push(code));
    const before = await frames(decoder);
    take(latter);
    await decoder.seek({ frame: 0 });
    const other = await frames(decoder);
    assert.deepEqual(reports, ["changed"]);
    assert.notDeepEqual(other, before);
    await decoder.seek({ frame: 0 });
    assert.deepEqual(await frames(decoder), other);
    assert.deepEqual(reports, ["changed"]);
    if (!rungs) assert.deepEqual(other, nativeFrames(join(folder, "other.fvv")));
    decoder.close();
  });

test("environments are also reported after a seek", async () => {
  const expected = nativeEnvironment(clips.environment);
  assert.ok(Object.keys(expected).length > 3);
  for (const start of [0, 4]) {
    const environment = await onlyEnvironment(`${server.url}/whole/environment/manifest.json`, start);
    assert.deepEqual(environmentHashes(environment), expected);
  }
  const decoder = await createDecoder({ source: `${server.url}/whole/bare/manifest.json` });
  const codes = [];
  onReports(decoder, ["damage"], (_, { code, fatal }) => codes.push(code, fatal));
  await decoder.seek({ frame: 4 });
  assert.equal((await decoder.next()).number, 4);
  assert.equal(await decoder.next(), null);
  assert.deepEqual(codes, ["damaged", false]);
  assert.deepEqual(decoder.environments, []);
  decoder.close();
});

test("invalid manifests", async () => {
  for (const name of ["none", "other", "escaping"])
    await assert.rejects(createDecoder({ source: `${server.url}/whole/${name}.json` }), { code: "invalid" });
});
