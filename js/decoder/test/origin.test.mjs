// Positions of streams in map coordinates: exact relative to an origin, which is 0 for streams near 0.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { createDecoder } from "../dist/index.js";
import { localOriginOf, localPositionsOf } from "../dist/wasm_structs.js";
import { moveCapture } from "../../testing/moved_capture.mjs";
import { tool } from "../../testing/served.mjs";

const BY = [4000000, -2500000.5, 4700000.25];
const folder = mkdtempSync(join(tmpdir(), "fvv-origin-"));
const at = (name) => join(folder, name);

before(() => {
  const what = ["--rig", "small", "--cameras", "3", "--frames", "1", "--size", "120x80", "--environment"];
  tool("fvvsynth", "-o", at("small"), ...what);
  for (const [name, by] of Object.entries({ near: [0, 0, 0], far: BY }))
    tool("fvvmux", moveCapture(at("small"), name, { by }), "-o", at(`${name}.fvv`), "--visibility", "none");
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** The first frame and the environment. */
async function read(name) {
  const source = new Uint8Array(readFileSync(at(`${name}.fvv`)));
  const decoder = await createDecoder({ source, worker: false, video: "encoded" });
  const frame = await decoder.next();
  while (await decoder.next());
  const [environment] = decoder.environments;
  decoder.close();
  return { frame, environment };
}

test("the origin is the lattice's, in whole multiples of 2^20 steps", () => {
  const origin = (...values) => localOriginOf({ origin: values, step: 2 ** -20 });
  assert.deepEqual(origin(0, 0.49, -0.49), [0, 0, 0]);
  assert.deepEqual(origin(0.5, -0.5, 7.2), [1, -1, 7]);
  assert.ok(origin(-0.1, 0, 0).every((x) => Object.is(x, 0)));
  assert.deepEqual(localOriginOf({ origin: [5, 5, 5], step: 1e303 }), [0, 0, 0], "a unit beyond all doubles");
});

test("local positions are differences in doubles, rounded once", () => {
  const lattice = { origin: [4194304.1, 0.3, -8388608], step: 0.1 };
  const origin = localOriginOf(lattice);
  const indices = Int32Array.of(7, -3, 100000);
  const local = localPositionsOf({ positions: new Float32Array(3), lattice: indices }, lattice, origin);
  const exact = lattice.origin.map((x, k) => Math.fround(x - origin[k] + lattice.step * indices[k]));
  assert.deepEqual([...local], exact);
});

test("near 0 they are the positions", async () => {
  const { frame, environment } = await read("near");
  assert.deepEqual(frame.configuration.localOrigin, [0, 0, 0]);
  for (const mesh of [frame.mesh, ...environment.parts]) {
    assert.deepEqual(mesh.origin, [0, 0, 0]);
    assert.equal(mesh.localPositions, mesh.positions);
  }
});

test("far from 0 they are as fine as near 0, and positions are as before", async () => {
  const [near, far] = [await read("near"), await read("far")];
  const { lattice, localOrigin } = far.frame.configuration;
  const { mesh } = far.frame;
  assert.deepEqual(lattice.origin, BY);
  assert.deepEqual(localOrigin, localOriginOf(lattice));
  assert.deepEqual(mesh.origin, localOrigin);
  assert.deepEqual(mesh.lattice, near.frame.mesh.lattice);
  mesh.lattice.forEach((index, i) => {
    const metres = lattice.origin[i % 3] + lattice.step * index;
    assert.equal(mesh.positions[i], Math.fround(metres));
    assert.equal(
      mesh.localPositions[i],
      Math.fround(lattice.origin[i % 3] - localOrigin[i % 3] + lattice.step * index),
    );
  });
  const parts = far.environment.parts.map((part, i) => [part, near.environment.parts[i]]);
  assert.ok(parts.length >= 2);
  for (const [part, other] of parts) {
    assert.deepEqual(part.origin, localOrigin);
    part.localPositions.forEach((x, i) => {
      const off = x + localOrigin[i % 3] - BY[i % 3] - other.positions[i];
      assert.ok(Math.abs(off) < 2e-5, `${off} m`);
    });
  }
});

test("a worker gives the same arrays", async () => {
  const { connect } = await import("../dist/worker_rpc.js");
  const { port1, port2 } = new MessageChannel();
  try {
    const positions = Float32Array.of(1, 2, 3);
    connect(port1, { frame: async () => ({ positions, localPositions: positions }) });
    const found = await connect(port2, {}).call("frame");
    assert.equal(found.localPositions, found.positions);
    assert.deepEqual([...found.positions], [1, 2, 3]);
  } finally {
    port1.close();
    port2.close();
  }
});
