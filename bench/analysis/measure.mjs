// Measures how far figures of @fvv/analysis are off: node measure.mjs EXACT PACKED, two streams of the same capture with the same
// objects, of which the first has its meshes unchanged. Prints as JSON, for each kind of figure, how many there are, the rms error, the percentage
// whose uncertainty holds the truth, and the rms uncertainty over the rms error.

import { readFileSync } from "node:fs";

import { centreOf, distance, floorOf, height, motion, objectsOf, pick, pointOf } from "../../js/analysis/src/index.js";
import { createDecoder } from "../../js/decoder/dist/index.js";

/** Picked places of a frame. */
const RAYS = 24;

/** Of each frame: points of objects, the floor, and picked places along the same rays. rays: null for the exact stream, which chooses them. */
async function read(path, rays) {
  const decoder = await createDecoder({ source: readFileSync(path), normals: false, video: "encoded" });
  const frames = [];
  for await (const frame of decoder) {
    const ids = objectsOf(frame.configuration).list.map(({ id }) => id);
    const chosen = rays?.[frames.length] ?? chooseRays(frame);
    const picked = chosen.map((ray) => {
      const found = pick(frame, ray);
      return found && pointOf(frame, found);
    });
    const points = ids.map((id) => centreOf(frame, id));
    frames.push({ seconds: frame.seconds, points, floor: floorOf(frame), picked, rays: chosen });
    frame.close();
  }
  decoder.close();
  return frames;
}

function chooseRays({ mesh, cameras }) {
  return Array.from({ length: RAYS }, (_, i) => {
    const v = 3 * Math.floor(((i + 0.5) * mesh.vertexCount) / RAYS);
    const origin = cameras[i % cameras.length].centre;
    return { origin, direction: origin.map((x, k) => mesh.positions[v + k] - x) };
  });
}

const exact = await read(process.argv[2]);
const packed = await read(
  process.argv[3],
  exact.map(({ rays }) => rays),
);
const kinds = {};
function note(kind, found, truth) {
  if (!found || !truth) return;
  kinds[kind] ??= { errors: [], widths: [], relative: [], held: 0 };
  const error = Math.abs(found.value - truth.value);
  kinds[kind].errors.push(error);
  kinds[kind].widths.push(found.uncertainty);
  kinds[kind].relative.push(error / truth.value);
  kinds[kind].held += error <= found.uncertainty;
}

exact.forEach((truth, i) => {
  const found = packed[i];
  const pairs = (list) => list.flatMap((a, j) => list.slice(j + 1).map((b) => a && b && distance(a, b)));
  const expected = pairs(truth.points);
  pairs(found.points).forEach((one, j) => note("centres", one, expected[j]));
  for (let j = 1; j < RAYS; j++) {
    const [a, b] = [found, truth].map(({ picked }) => picked[j - 1] && picked[j] && distance(picked[j - 1], picked[j]));
    // Where one ray just passes a limb, the other stream shows what is behind.
    const passes = [j - 1, j].some((k) => {
      const [p, q] = [found.picked[k], truth.picked[k]];
      return p && q && distance(p, q).value > 0.05;
    });
    if (!passes) note("picks", a, b);
  }
  found.points.forEach((one, j) => {
    if (one && truth.points[j]) note("heights", height(one, found.floor), height(truth.points[j], truth.floor));
  });
});
exact[0].points.forEach((_, k) => {
  const of = (frames) => motion(frames.map(({ seconds, points }) => points[k] && { seconds, ...points[k] }));
  const truth = of(exact);
  of(packed).forEach(
    (one, i) => truth[i] && note("speeds", one?.speed, truth[i].speed.value > 1 ? truth[i].speed : null),
  );
});

const rms = (list) => Math.sqrt(list.reduce((sum, x) => sum + x * x, 0) / list.length);
console.log(
  JSON.stringify(
    Object.fromEntries(
      Object.entries(kinds).map(([kind, { errors, widths, relative, held }]) => [
        kind,
        {
          count: errors.length,
          rms: rms(errors),
          relative: rms(relative),
          coverage: (100 * held) / errors.length,
          width: rms(widths) / rms(errors),
        },
      ]),
    ),
  ),
);
