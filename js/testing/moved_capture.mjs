// A capture of fvvsynth's rig "small" at another place and in another size: what a stream in map coordinates, or of a tiny
// object, has to look like is known.

import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

/** The lattice's step in metres, and that of the environment, before scaling. */
const STEP = 5e-4;
const ENVIRONMENT_STEP = 2e-3;

/** A binary PLY with floats, as fvvsynth writes it: {points: [[x, y, z]], faces: [[a, b, c]]}. */
function readPly(path) {
  const bytes = readFileSync(path);
  const end = bytes.indexOf("end_header\n") + "end_header\n".length;
  const [, vertices, faces] = /element vertex (\d+)[^]*element face (\d+)/.exec(bytes.toString("latin1", 0, end));
  const points = Array.from({ length: Number(vertices) }, (_, i) =>
    [0, 4, 8].map((at) => bytes.readFloatLE(end + 12 * i + at)),
  );
  const from = end + 12 * points.length;
  const corners = (i) => [1, 5, 9].map((at) => bytes.readUInt32LE(from + 13 * i + at));
  return { points, faces: Array.from({ length: Number(faces) }, (_, i) => corners(i)) };
}

const moved = (point, by, scale) => point.map((x, k) => scale * x + by[k]);

/** Nodes of a GLB, whose translations are JSON and thus doubles; vertices are floats. */
function moveGlb(from, to, by) {
  const bytes = readFileSync(from);
  const size = bytes.readUInt32LE(12);
  const document = JSON.parse(bytes.toString("utf8", 20, 20 + size));
  for (const node of document.nodes) node.translation = (node.translation ?? [0, 0, 0]).map((x, k) => x + by[k]);
  const text = Buffer.from(JSON.stringify(document));
  const json = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, " ")]);
  const rest = bytes.subarray(20 + size);
  const head = Buffer.alloc(20);
  bytes.copy(head, 0, 0, 20);
  head.writeUInt32LE(20 + json.length + rest.length, 8);
  head.writeUInt32LE(json.length, 12);
  writeFileSync(to, Buffer.concat([head, json, rest]));
}

/**
 * Writes NAME.json into the folder of a capture: the same scene, scaled and then moved by metres. Its lattice is moved with it,
 * so that indices are the same. Returns the path.
 */
export function moveCapture(folder, name, { by = [0, 0, 0], scale = 1 }) {
  const capture = JSON.parse(readFileSync(join(folder, "capture.json"), "utf8"));
  const { first, count } = capture.frames;
  for (let frame = first; frame < first + count; frame++) {
    const number = String(frame).padStart(4, "0");
    const { points, faces } = readPly(join(folder, `meshes/${number}.ply`));
    const lines = points.map((point) => `v ${moved(point, by, scale).join(" ")}`);
    for (const corners of faces) lines.push(`f ${corners.map((corner) => corner + 1).join(" ")}`);
    writeFileSync(join(folder, `meshes/${name}_${number}.obj`), `${lines.join("\n")}\n`);
  }
  capture.meshes.pattern = `meshes/${name}_%04d.obj`;
  capture.lattice = { origin: by, step: scale * STEP };
  for (const camera of capture.cameras)
    camera.translation = camera.rotation.map(
      (row, i) => scale * camera.translation[i] - row.reduce((sum, x, k) => sum + x * by[k], 0),
    );
  if (capture.environment && scale === 1) {
    capture.environment = { file: `${name}.glb`, lattice: { origin: by, step: ENVIRONMENT_STEP } };
    moveGlb(join(folder, "environment.glb"), join(folder, `${name}.glb`), by);
  } else delete capture.environment;
  const path = join(folder, `${name}.json`);
  writeFileSync(path, JSON.stringify(capture));
  return path;
}
