// A capture in which every frame encodes its number twice: the mesh by the positions of its squares, the pictures by their
// brightness. A drawn picture shows whether both are of the same frame.

import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { PNG } from "pngjs";

import { BITS, RATE, cellOf, groupMarkOf } from "./board_layout.js";

const [WIDTH, HEIGHT, FOCAL, DISTANCE] = [160, 120, 300, 3];
/** Positions of the cameras in metres. */
const CAMERAS = [-0.03, 0.03];
const [DARK, LIGHT, GREY] = [30, 225, 128];

/** Corners of the squares of frame n, counter-clockwise as the cameras see them. */
function squaresOf(n, group) {
  const cells = Array.from({ length: BITS }, (_, bit) => cellOf(bit, (n >> bit) & 1));
  return [...cells, groupMarkOf(Math.floor(n / group))].map(({ x, y, half }) => [
    [x - half, y - half],
    [x + half, y - half],
    [x + half, y + half],
    [x - half, y + half],
  ]);
}

function meshOf(n, group) {
  const squares = squaresOf(n, group);
  const vertices = squares.flat().map(([x, y]) => `${x} ${y} 0`);
  const faces = squares.flatMap((_, i) => [
    `3 ${4 * i} ${4 * i + 1} ${4 * i + 2}`,
    `3 ${4 * i} ${4 * i + 2} ${4 * i + 3}`,
  ]);
  return [
    "ply",
    "format ascii 1.0",
    `element vertex ${vertices.length}`,
    ...["x", "y", "z"].map((axis) => `property float ${axis}`),
    `element face ${faces.length}`,
    "property list uchar int vertex_indices",
    "end_header",
    ...vertices,
    ...faces,
    "",
  ].join("\n");
}

/** The picture of a camera at x for number n: a light or dark stripe for each bit. */
function pictureOf(n, x) {
  const png = new PNG({ width: WIDTH, height: HEIGHT });
  const [first, second] = [cellOf(0, 0).x, cellOf(1, 0).x];
  for (let column = 0; column < WIDTH; column++) {
    const there = ((column + 0.5 - WIDTH / 2) * DISTANCE) / FOCAL + x;
    const bit = Math.round((there - first) / (second - first));
    for (let row = 0; row < HEIGHT; row++) {
      // Above the group mark, which is grey.
      const painted = row < 0.7 * HEIGHT && bit >= 0 && bit < BITS;
      const value = painted ? ((n >> bit) & 1 ? LIGHT : DARK) : GREY;
      png.data.set([value, value, value, 255], 4 * (row * WIDTH + column));
    }
  }
  return PNG.sync.write(png, { filterType: 0, deflateLevel: 1 });
}

/** pictureNumber(n): the number in the pictures of frame n; tests use wrong numbers as well. */
export function writeBoard(folder, { frames, group, pictureNumber = (n) => n }) {
  const name = (n) => String(n).padStart(4, "0");
  for (const part of ["meshes", ...CAMERAS.map((_, i) => `cam${i}`)])
    mkdirSync(join(folder, part), { recursive: true });
  for (let n = 0; n < frames; n++) {
    writeFileSync(join(folder, "meshes", `${name(n)}.ply`), meshOf(n, group));
    CAMERAS.forEach((x, i) => writeFileSync(join(folder, `cam${i}`, `${name(n)}.png`), pictureOf(pictureNumber(n), x)));
  }
  const cameras = CAMERAS.map((x, id) => ({
    id,
    width: WIDTH,
    height: HEIGHT,
    intrinsics: { fx: FOCAL, fy: FOCAL, cx: WIDTH / 2, cy: HEIGHT / 2 },
    rotation: [
      [1, 0, 0],
      [0, -1, 0],
      [0, 0, -1],
    ],
    translation: [-x, 0, DISTANCE],
    pictures: `cam${id}/%04d.png`,
  }));
  const capture = {
    fvv_capture: 1,
    name: "numbered board",
    frame_rate: RATE,
    frames: { first: 0, count: frames },
    units: "metres",
    up: "+y",
    meshes: { pattern: "meshes/%04d.ply" },
    cameras,
  };
  writeFileSync(join(folder, "capture.json"), JSON.stringify(capture));
}
