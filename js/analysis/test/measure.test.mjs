// Measurements and their uncertainties: the cases that Python has as well, and a ball of fvvsynth, whose meshes are the truth.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

import { createDecoder } from "../../decoder/dist/index.js";
import { root, tool } from "../../testing/served.mjs";
import * as analysis from "../src/index.js";
import { frameOf } from "./frames.mjs";

const cases = JSON.parse(readFileSync(join(root, "tests/analysis/cases.json"), "utf8"));
const { measures } = cases;

/** Numbers within 1e-7 of each other, which doubles keep in coordinates of maps. */
function assertNear(found, expected, what = "") {
  if (expected === null || typeof expected !== "object") {
    const equal =
      typeof expected === "number" && found !== null
        ? Math.abs(found - expected) < 1e-7 * (1 + Math.abs(expected))
        : found === expected;
    return assert.ok(equal, `${what}: expected ${expected}, found ${found}`);
  }
  assert.ok(found !== null, `${what}: found null`);
  for (const key of Object.keys(expected)) assertNear(found[key], expected[key], `${what}.${key}`);
}

test("distances, angles and heights", () => {
  for (const { a, b, expected } of measures.distances) assertNear(analysis.distance(a, b), expected);
  for (const { at, a, b, expected } of measures.angles) assertNear(analysis.angle(at, a, b), expected);
  for (const { point, floor, expected } of measures.heights) assertNear(analysis.height(point, floor), expected);
});

for (const { name, samples, expected } of measures.motions)
  test(`motion: ${name}`, () => {
    // The second derivative multiplies what rounding leaves of coordinates of maps by ten thousand.
    const found = analysis.motion(samples);
    found.forEach((one, i) => {
      if (!expected[i]) return assert.equal(one, null, `sample ${i}`);
      assertNear(one.seconds, expected[i].seconds);
      for (const quantity of ["speed", "acceleration"])
        for (const part of ["value", "uncertainty"])
          assert.ok(
            Math.abs(one[quantity][part] - expected[i][quantity][part]) < 1e-4,
            `${i} ${quantity} ${part}: ${one[quantity][part]}`,
          );
      assert.ok(one.velocity.every((x, k) => Math.abs(x - expected[i].velocity[k]) < 1e-4));
    });
    assert.equal(found.length, expected.length);
  });

test("motion asks for enough samples", () => {
  assert.throws(() => analysis.motion([], { around: 1 }), /around: expected an integer of 2 or more, found 1/);
  assert.deepEqual(analysis.motion([]), []);
});

test("what a stream says of its meshes", () => {
  for (const { texts, expected } of measures.mesh_errors)
    assert.deepEqual(analysis.meshErrorOf({ metadata: texts }), expected);
});

for (const { name, mesh_error: stated, hull, ray, expected } of measures.points)
  test(`the uncertainty of a place: ${name}`, () => {
    const frame = frameOf(cases, ["box"], stated ? [JSON.stringify({ mesh_error: stated })] : []);
    const picked = analysis.pick(frame, measures.rays[ray]);
    assertNear(analysis.pointUncertainty(frame, picked, { hull }), expected);
    const point = analysis.pointOf(frame, picked, { hull });
    if (expected === null) assert.equal(point, null);
    else assert.equal(point.position, picked.position);
  });

test("a camera that no tile shows says nothing of sharpness, and one that is shown smaller says less", () => {
  const frame = frameOf(cases, ["box"], ['{"mesh_error":{"vertex":0.001,"pixels":0.2}}']);
  const picked = analysis.pick(frame, cases.picks[0].ray);
  const tile = (camera, width) => ({ camera, source: { width: 640 }, destination: { width } });
  const of = (...tiles) => analysis.pointUncertainty({ ...frame, tiles: () => tiles }, picked);
  const whole = of(tile(3, 640));
  assertNear(of(tile(3, 160)), 4 * whole);
  assert.ok(of(tile(9, 640)) > whole);
  assert.equal(analysis.pointUncertainty({ ...frame, cameras: [] }, picked), null);
});

for (const { id, mesh_error: stated, uncertainty, expected } of cases.objects.paths)
  test(`points of a path, with ${stated ? "" : "no "}uncertainty`, () => {
    const texts = [JSON.stringify({ objects: cases.objects.value }), JSON.stringify({ mesh_error: stated })];
    const found = analysis.pathOf(frameOf(cases, ["box"], texts), id);
    assert.equal(found.length, expected.length);
    found.forEach((point, i) => {
      const { time, position } = expected[i];
      if (position === null) return assert.equal(point, null);
      assert.deepEqual([Number(point.time), point.seconds], [time, time / 4]);
      assert.ok(position.every((x, k) => Math.abs(x - point.position[k]) < 2e-9));
      assertNear(point.uncertainty, uncertainty);
    });
    assert.deepEqual(analysis.pathOf(frameOf(cases, ["box"]), id), []);
  });

test("a place is followed while the faces stay", () => {
  const frame = frameOf(cases, ["box"], ['{"mesh_error":{"vertex":0.001,"metres":0.01}}']);
  const [{ ray }] = cases.picks;
  const picked = analysis.pick(frame, ray);
  const place = new analysis.SurfacePoint(frame, picked, ray.origin);
  const moved = frameOf(cases, ["box"], frame.configuration.metadata);
  moved.meshes[0].localPositions = moved.meshes[0].localPositions.map((x, i) => (i % 3 === 1 ? x + 0.5 : x));
  const found = place.in(moved);
  assert.ok(found.position.every((x, k) => Math.abs(x - picked.position[k] - (k === 1 ? 0.5 : 0)) < 1e-6));
  assert.ok(found.normal.every((x, k) => Math.abs(x - picked.normal[k]) < 1e-6));
  assert.ok(analysis.pointOf(moved, found).uncertainty > 0);
  moved.meshes[0].faces = moved.meshes[0].faces.slice().reverse();
  assert.equal(place.in({ ...moved, meshes: [{ ...moved.meshes[0] }] }), null, "other faces");
  assert.equal(place.in(frameOf(cases, ["plate"])), null, "another mesh");
  assert.equal(place.in({ ...moved, meshes: [] }), null, "no mesh");
});

test("comma-separated values", () => {
  const rows = [
    { time: 0n, "a, b": { value: 1.5, uncertainty: 0.1 }, who: 'the "ball"' },
    { time: 1n, "a, b": null, who: null },
  ];
  assert.equal(analysis.csv(rows), 'time,"a, b","a, b uncertainty",who\r\n0,1.5,0.1,"the ""ball"""\r\n1,,,\r\n');
});

test("figures of a packed stream hold the truth, which the unchanged meshes are", async () => {
  const folder = mkdtempSync(join(tmpdir(), "fvv-measure-"));
  const at = (name) => join(folder, name);
  try {
    tool("fvvsynth", "-o", at("capture"), "--rig", "small", "--cameras", "4", "--frames", "13", "--size", "160x90");
    const pack = (name, ...more) =>
      tool("fvvmux", at("capture"), "-o", at(name), "--no-pictures", "--objects", "auto", ...more);
    pack("exact.fvv", "--keep-geometry", "--step", "0.1mm");
    pack("packed.fvv", "--max-error", "0.3");
    const read = async (name) => {
      const decoder = await createDecoder({ source: readFileSync(at(name)), normals: false });
      const found = [];
      for await (const frame of decoder) {
        const points = [1, 2, 3].map((id) => analysis.centreOf(frame, id));
        found.push({ seconds: frame.seconds, points, floor: analysis.floorOf(frame) });
        frame.close();
      }
      decoder.close();
      return found;
    };
    const [exact, packed] = [await read("exact.fvv"), await read("packed.fvv")];
    const held = { distance: [], height: [], speed: [] };
    const note = (kind, found, truth) => {
      assert.ok(found.uncertainty > 0 && Number.isFinite(found.uncertainty));
      held[kind].push(Math.abs(found.value - truth.value) <= found.uncertainty + truth.uncertainty);
    };
    packed.forEach((one, i) => {
      const [a, b, ball] = one.points;
      const truth = exact[i].points;
      note("distance", analysis.distance(a, ball), analysis.distance(truth[0], truth[2]));
      note("distance", analysis.distance(a, b), analysis.distance(truth[0], truth[1]));
      note("height", analysis.height(ball, one.floor), analysis.height(truth[2], exact[i].floor));
    });
    const speeds = (frames) => analysis.motion(frames.map(({ seconds, points }) => ({ seconds, ...points[2] })));
    const truth = speeds(exact);
    speeds(packed).forEach((one, i) => one && note("speed", one.speed, truth[i].speed));
    const share = (list) => list.filter(Boolean).length / list.length;
    for (const [kind, list] of Object.entries(held))
      assert.ok(list.length >= 9 && share(list) >= 0.95, `${kind}: ${share(list)}`);
    // The uncertainties are no excuse: centimetres, not decimetres.
    assert.ok(packed.every(({ points }) => points.every(({ uncertainty }) => uncertainty < 0.05)));
  } finally {
    rmSync(folder, { recursive: true });
  }
});
