// Reads the OpenEXR files of fvvrender: one part, scan lines, channels of 32-bit floats, ZIP in blocks of 16 rows.

import { readFileSync } from "node:fs";
import { inflateSync } from "node:zlib";

const MAGIC = 20000630;
const FLOAT = 2;
const ZIP = 3;
const ROWS = 16;

function attributesOf(file) {
  let at = 8;
  const text = () => {
    const end = file.indexOf(0, at);
    const found = file.toString("latin1", at, end);
    at = end + 1;
    return found;
  };
  const attributes = new Map();
  for (let name = text(); name; name = text()) {
    text(); // its type
    const size = file.readInt32LE(at);
    attributes.set(name, file.subarray(at + 4, at + 4 + size));
    at += 4 + size;
  }
  return { attributes, end: at };
}

function channelsOf(list, path) {
  const names = [];
  for (let at = 0; list[at] !== 0;) {
    const end = list.indexOf(0, at);
    names.push(list.toString("latin1", at, end));
    if (list.readInt32LE(end + 1) !== FLOAT) throw new Error(`${path}: channel ${names.at(-1)}: expected floats`);
    at = end + 17;
  }
  return names;
}

/** Undoes OpenEXR's predictor and the separation of even and odd bytes. */
function unpacked(packed) {
  const bytes = inflateSync(packed);
  for (let i = 1; i < bytes.length; i++) bytes[i] = bytes[i - 1] + bytes[i] - 128;
  const out = Buffer.alloc(bytes.length);
  const half = (bytes.length + 1) >> 1;
  for (let i = 0; i < bytes.length; i++) out[i] = bytes[(i >> 1) + (i & 1 ? half : 0)];
  return out;
}

/** {width, height, channels: Map from name to Float32Array, rows from the top} */
export function readExr(path) {
  const file = readFileSync(path);
  if (file.readInt32LE(0) !== MAGIC) throw new Error(`${path}: not an OpenEXR file`);
  const { attributes, end } = attributesOf(file);
  if (attributes.get("compression")[0] !== ZIP) throw new Error(`${path}: expected ZIP compression`);
  const window = attributes.get("dataWindow");
  const [left, top, right, bottom] = [0, 4, 8, 12].map((at) => window.readInt32LE(at));
  const [width, height] = [right - left + 1, bottom - top + 1];
  const names = channelsOf(attributes.get("channels"), path);
  const channels = new Map(names.map((name) => [name, new Float32Array(width * height)]));
  const blocks = Math.ceil(height / ROWS);
  for (let block = 0; block < blocks; block++) {
    const at = Number(file.readBigUInt64LE(end + 8 * block));
    const first = file.readInt32LE(at) - top;
    const rows = Math.min(ROWS, height - first);
    const expected = 4 * width * rows * names.length;
    const size = file.readInt32LE(at + 4);
    const data = file.subarray(at + 8, at + 8 + size);
    // Blocks are stored uncompressed if compression would make them larger.
    const bytes = size < expected ? unpacked(data) : data;
    let from = 0;
    for (let y = first; y < first + rows; y++)
      for (const name of names)
        for (let x = 0; x < width; x++, from += 4) channels.get(name)[y * width + x] = bytes.readFloatLE(from);
  }
  return { width, height, channels };
}
