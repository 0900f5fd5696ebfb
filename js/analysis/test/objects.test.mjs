// Pieces of meshes and the objects that they are: the cases that Python has as well, and a stream of fvvmux --objects.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

import { createDecoder } from "../../decoder/dist/index.js";
import { root, tool } from "../../testing/served.mjs";
import { ObjectPaths, objectsOf, pick, piecesOfFrame } from "../src/index.js";
import { piecesOf } from "../src/pieces.js";

const cases = JSON.parse(readFileSync(join(root, "tests/analysis/cases.json"), "utf8"));
const away = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));

for (const { mesh: name, of_faces: ofFaces, pieces } of cases.pieces)
  test(`pieces of a mesh: ${name}`, () => {
    const { origin, points, faces } = cases.meshes[name];
    const mesh = { origin, localPositions: Float32Array.from(points.flat()), faces: Uint32Array.from(faces.flat()) };
    const found = piecesOf(mesh);
    assert.deepEqual(Array.from(found.ofFace), ofFaces);
    assert.equal(found.pieces.length, pieces.length);
    pieces.forEach((expected, i) => {
      const one = found.pieces[i];
      assert.ok(away(one.centre, expected.centre) < 2e-9, `${one.centre}`);
      assert.ok(Math.abs(one.area - expected.area) < 1e-9 && Math.abs(one.radius - expected.radius) < 1e-9);
      assert.equal(one.faces, expected.faces);
    });
    assert.equal(piecesOf(mesh), found, "found once");
  });

test("paths of objects", () => {
  const paths = new ObjectPaths(cases.objects.value);
  assert.deepEqual(paths.list, cases.objects.list);
  assert.deepEqual([paths.find("ball"), paths.find("umpire")], [9, null]);
  assert.deepEqual(paths.splits, [{ from: 4, object: 12, time: 2n }]);
  assert.deepEqual(paths.touching, [{ objects: [4, 9], from: 6n, to: 8n, sure: false }]);
  for (const { id, time, expected } of cases.objects.centres) {
    const found = paths.centreOf(id, BigInt(time));
    if (expected) assert.ok(away(found, expected) < 2e-9, `${id} at ${time}: ${found}`);
    else assert.equal(found, null, `${id} at ${time}`);
  }
  assert.throws(() => paths.centreOf(5, 0n), /no object has the identifier 5/);
});

for (const { name, centre, time, expected } of cases.objects.pieces)
  test(`the objects of a piece: ${name}`, () => {
    assert.deepEqual(new ObjectPaths(cases.objects.value).at(centre, BigInt(time)), expected);
  });

test("what is not as the registry says is ignored", () => {
  const of = (...values) => objectsOf({ metadata: values });
  assert.ok(of('{"name":"x"}', "{", JSON.stringify({ objects: cases.objects.value })) instanceof ObjectPaths);
  for (const value of cases.objects.refused)
    assert.equal(of(JSON.stringify({ objects: value })), null, JSON.stringify(value));
  assert.equal(of("null", "[]", "{"), null);
  assert.equal(of(), null);
});

test("in a stream of fvvmux the ball is the ball in every frame, also after a seek", async () => {
  const folder = mkdtempSync(join(tmpdir(), "fvv-objects-"));
  const at = (name) => join(folder, name);
  try {
    tool("fvvsynth", "-o", at("capture"), "--rig", "small", "--cameras", "2", "--frames", "20", "--size", "96x64");
    tool("fvvmux", at("capture"), "-o", at("clip.fvv"), "--no-pictures", "--group", "8", "--objects", "auto");
    const decoder = await createDecoder({ source: readFileSync(at("clip.fvv")), normals: false });
    const shown = [];
    const look = (frame) => {
      const pieces = piecesOfFrame(frame);
      assert.deepEqual(pieces.flatMap(({ objects }) => objects).sort(), [1, 2, 3]);
      const ball = pieces.find(({ objects }) => objects[0] === 3);
      assert.ok(ball.radius > 0.11 && ball.radius < 0.13, `${ball.radius}`);
      const paths = objectsOf(frame.configuration);
      // The path is that of the capture's mesh, rounded; the piece is decimated.
      const off = away(ball.centre, paths.centreOf(3, frame.time));
      assert.ok(off < 0.012, `${off} m off its path`);
      const eye = [ball.centre[0], ball.centre[1], ball.centre[2] + 0.2];
      const found = pick(frame, { origin: eye, direction: [0, 0, -1] });
      assert.deepEqual([found.object, found.touching], [3, []]);
      shown.push(frame.number);
      frame.close();
    };
    for await (const frame of decoder) look(frame);
    await decoder.seek({ frame: 13 });
    look(await decoder.next());
    assert.deepEqual([shown.length, shown.at(-1)], [21, 13]);
    decoder.close();
  } finally {
    rmSync(folder, { recursive: true });
  }
});
