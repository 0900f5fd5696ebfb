// Rays against the surface: the cases that Python has as well, every triangle one by one, and a stream as fvvmux writes it.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

import { createDecoder } from "../../decoder/dist/index.js";
import { root, tool } from "../../testing/served.mjs";
import { pick, rayThrough, SurfaceTree } from "../src/index.js";
import { camerasOf, frameOf as makeFrame } from "./frames.mjs";

const cases = JSON.parse(readFileSync(join(root, "tests/analysis/cases.json"), "utf8"));
const cameras = camerasOf(cases);
const frameOf = (meshes) => makeFrame(cases, meshes);

function near(found, expected, tolerance, what) {
  assert.ok(
    found.every((x, k) => Math.abs(x - expected[k]) <= tolerance),
    `${what}: expected ${expected}, found ${found}`,
  );
}

for (const { name, meshes, ray, expected } of cases.picks)
  test(`a ray meets ${expected ? name : `nothing: ${name}`}`, () => {
    const found = pick(frameOf(meshes), ray);
    if (!expected) return assert.equal(found, null);
    assert.deepEqual(
      [found.time, found.frame, found.track, found.face, found.camera, found.object],
      [7n, 2, expected.track, expected.face, expected.camera, null],
    );
    // The positions are those of a map: doubles have nanometres there.
    near(found.position, expected.position, 2e-9, "position");
    near(found.normal, expected.normal, 1e-12, "normal");
    near(found.barycentric, expected.barycentric, 1e-9, "barycentric");
    assert.ok(Math.abs(found.distance - expected.distance) < 2e-9);
  });

test("a camera whose picture is not sent, or that is not calibrated, is not reported", () => {
  const [{ ray }] = cases.picks;
  const frame = frameOf(["box"]);
  const other = frame.tiles().filter(({ camera }) => camera === 9);
  assert.equal(pick({ ...frame, tiles: () => other }, ray).camera, null);
  const away = cameras.map((camera) => ({ ...camera, calibrated: camera.id !== 3 }));
  assert.equal(pick({ ...frame, cameras: away }, ray).camera, null);
  const narrow = frame.tiles().map((tile) => ({ ...tile, source: { ...tile.source, width: 10 } }));
  assert.equal(pick({ ...frame, tiles: () => narrow }, ray).camera, null);
});

test("a ray without a direction is refused", () => {
  const frame = frameOf(["box"]);
  for (const ray of [
    { origin: [0, 0, 0], direction: [0, 0, 0] },
    { origin: [0, NaN, 0], direction: [1, 0, 0] },
    { origin: [0, 0, 0], direction: [1, Infinity, 0] },
  ])
    assert.throws(() => pick(frame, ray), /pick: expected a ray of finite numbers/);
});

/** Numbers from 0 to 1 that are the same each time. */
function numbers(seed) {
  return () => (seed = (seed * 48271) % 2147483647) / 2147483647;
}

/** The nearest triangle on a ray, one after the other. */
function nearest(points, faces, origin, direction) {
  let best = { face: -1, distance: Infinity };
  const corner = (i) => [0, 1, 2].map((k) => points[3 * faces[i] + k]);
  const minus = (a, b) => a.map((x, k) => x - b[k]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
  for (let face = 0; face < faces.length / 3; face++) {
    const [a, b, c] = [0, 1, 2].map((k) => corner(3 * face + k));
    const normal = cross(minus(b, a), minus(c, a));
    const distance = dot(normal, minus(a, origin)) / dot(normal, direction);
    const at = origin.map((x, k) => x + distance * direction[k]);
    const inside = [
      [a, b],
      [b, c],
      [c, a],
    ].every(([p, q]) => dot(cross(minus(q, p), minus(at, p)), normal) >= 0);
    if (inside && distance >= 0 && distance < best.distance) best = { face, distance };
  }
  return best;
}

test("the hierarchy finds the triangle that a search of all of them finds", () => {
  const next = numbers(11);
  const count = 301; // not a multiple of what a box holds
  const points = new Float32Array(9 * count);
  for (let i = 0; i < count; i++) {
    const middle = [next(), next(), next()];
    for (let k = 0; k < 9; k++) points[9 * i + k] = middle[k % 3] + 0.2 * (next() - 0.5);
  }
  const faces = Uint32Array.from({ length: 3 * count }, (_, i) => i);
  const tree = new SurfaceTree(points, faces);
  let hits = 0;
  for (let i = 0; i < 400; i++) {
    const origin = [3 * next() - 1, 3 * next() - 1, 3 * next() - 1];
    // Some along the axes.
    const target = [next(), next(), next()];
    if (i % 4 === 0) for (const k of [i % 3, (i + 1) % 3]) origin[k] = target[k];
    const direction = target.map((x, k) => x - origin[k]);
    const expected = nearest(points, faces, origin, direction);
    const found = tree.cast(origin, direction);
    assert.equal(found?.face ?? -1, expected.face);
    if (found) assert.ok(Math.abs(found.distance - expected.distance) < 1e-9 * (1 + expected.distance));
    hits += found !== null;
  }
  assert.ok(hits > 100 && hits < 350, `${hits} of 400 rays meet something`);
});

test("triangles nearer, further and left out are passed through", () => {
  // Three squares across the ray, at 1, 2 and 3.
  const points = Float32Array.from([1, 2, 3].flatMap((z) => [-9, -9, z, 9, -9, z, 0, 9, z]));
  const tree = new SurfaceTree(
    points,
    Uint32Array.from({ length: 9 }, (_, i) => i),
  );
  const cast = (options) => tree.cast([0, 0, 0], [0, 0, 1], options)?.face;
  assert.deepEqual(
    [cast(), cast({ except: 0 }), cast({ least: 2.5 }), cast({ least: 1.5, most: 1.9 })],
    [0, 1, 2, undefined],
  );
});

test("a mesh without faces is met by nothing", () => {
  assert.equal(new SurfaceTree(new Float32Array(0), new Uint32Array(0)).cast([0, 0, 0], [1, 0, 0]), null);
});

test("rays through the pixels of a stream's cameras meet the vertices that project there", async () => {
  const folder = mkdtempSync(join(tmpdir(), "fvv-pick-"));
  try {
    tool("fvvsynth", "-o", join(folder, "capture"), "--rig", "small", "--frames", "1", "--size", "320x180");
    tool("fvvmux", join(folder, "capture"), "-o", join(folder, "clip.fvv"), "--keep-geometry", "--no-pictures");
    const decoder = await createDecoder({ source: readFileSync(join(folder, "clip.fvv")), video: "encoded" });
    const frame = await decoder.next();
    const { positions, vertexCount } = frame.mesh;
    const [camera] = frame.cameras;
    assert.deepEqual(camera.distortion.filter(Boolean), [], "the ray below is that of a camera without a lens");
    let front = 0;
    for (let v = 0; v < vertexCount; v += 7) {
      const vertex = Array.from(positions.subarray(3 * v, 3 * v + 3));
      const [u, w] = camera.project(...vertex);
      const found = pick(frame, rayThrough(camera, u, w));
      assert.ok(found, `nothing at vertex ${v}`);
      const away = Math.hypot(...camera.centre.map((x, k) => x - vertex[k]));
      // Nothing is further than the vertex itself.
      assert.ok(found.distance < away + 1e-5, `${found.distance} and ${away}`);
      if (found.distance < away - 1e-3) continue;
      front++;
      near(found.position, vertex, 1e-3, "position");
    }
    assert.ok(front > 20, `${front} vertices are in front`);
    decoder.close();
  } finally {
    rmSync(folder, { recursive: true });
  }
});
