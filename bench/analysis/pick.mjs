// Measures picks of @fvv/analysis: node pick.mjs FILE. Prints as JSON the median milliseconds for the hierarchy of a frame's
// mesh, in a process that has built others, and for a ray, of rays from the cameras to vertices of the mesh.

import { readFileSync } from "node:fs";

import { SurfaceTree } from "../../js/analysis/src/index.js";
import { createDecoder } from "../../js/decoder/dist/index.js";

const FRAMES = 25;
const RAYS = 2000;
const median = (times) => times.sort((a, b) => a - b)[times.length >> 1];

const decoder = await createDecoder({ source: readFileSync(process.argv[2]), video: "encoded", normals: false });
const builds = [];
const rays = [];
let first = null;
let triangles = 0;
let hits = 0;
for await (const frame of decoder) {
  const { mesh, cameras } = frame;
  const points = mesh.localPositions;
  const begin = performance.now();
  const tree = new SurfaceTree(points, mesh.faces);
  builds.push(performance.now() - begin);
  first ??= builds[0];
  triangles = mesh.faceCount;
  const started = performance.now();
  for (let i = 0; i < RAYS; i++) {
    const v = 3 * Math.floor((i * mesh.vertexCount) / RAYS);
    const origin = cameras[i % cameras.length].centre.map((x, k) => x - mesh.origin[k]);
    const direction = origin.map((x, k) => points[v + k] - x);
    hits += tree.cast(origin, direction) !== null;
  }
  rays.push((performance.now() - started) / RAYS);
  frame.close();
  if (builds.length === FRAMES) break;
}
decoder.close();
console.log(
  JSON.stringify({
    first_build: first,
    build: median(builds),
    ray: median(rays),
    triangles,
    hits: hits / (RAYS * builds.length),
  }),
);
