// The icon of the site, an eye. Browsers request favicon.ico even if pages do not name it.

import { PNG } from "pngjs";

const SIZE = 48;
const SAMPLES = 4;
const [BLUE, WHITE] = [
  [10, 95, 194],
  [255, 255, 255],
];

/** The colour at a point, -1 to 1 in each axis; null: transparent. */
function paint(x, y) {
  const corner = Math.hypot(Math.max(0, Math.abs(x) - 0.55), Math.max(0, Math.abs(y) - 0.55));
  if (corner > 0.45) return null;
  // Two arcs form the eye, a disc its iris.
  const white = Math.hypot(x, y - 0.55) < 0.95 && Math.hypot(x, y + 0.55) < 0.95;
  return white && Math.hypot(x, y) > 0.24 ? WHITE : BLUE;
}

function drawn() {
  const png = new PNG({ width: SIZE, height: SIZE });
  for (let i = 0; i < SIZE * SIZE; i++) {
    const sum = [0, 0, 0, 0];
    for (let k = 0; k < SAMPLES * SAMPLES; k++) {
      const along = (position, part) => (2 * (position + (part + 0.5) / SAMPLES)) / SIZE - 1;
      const colour = paint(along(i % SIZE, k % SAMPLES), along(Math.floor(i / SIZE), Math.floor(k / SAMPLES)));
      if (colour) [...colour, 255].forEach((value, c) => (sum[c] += value));
    }
    const inside = sum[3] / 255;
    for (let c = 0; c < 3; c++) png.data[4 * i + c] = inside ? Math.round(sum[c] / inside) : 0;
    png.data[4 * i + 3] = Math.round(sum[3] / SAMPLES ** 2);
  }
  return PNG.sync.write(png);
}

/** Bytes of an .ico file with one picture. */
export function icon() {
  const picture = drawn();
  const head = Buffer.alloc(22);
  head.writeUInt16LE(1, 2); // an icon
  head.writeUInt16LE(1, 4); // of one picture
  head.set([SIZE, SIZE], 6);
  head.writeUInt16LE(1, 10); // plane
  head.writeUInt16LE(32, 12); // bits a pixel
  head.writeUInt32LE(picture.length, 14);
  head.writeUInt32LE(head.length, 18);
  return Buffer.concat([head, picture]);
}
