// Streams made of others: damaged, hostile, or joined.

import { crc32c } from "../dist/chunks.js";

/** About count streams with single flipped bits, cuts, and missing ranges, all over the file. */
export function* damaged(bytes, count) {
  const n = Math.floor(count / 3);
  for (let i = 0; i < n; i++) {
    const at = Math.floor((bytes.length * i) / n);
    const flipped = bytes.slice();
    flipped[at] ^= 1 << (i % 8);
    yield flipped;
    yield bytes.slice(0, at);
    const end = Math.min(bytes.length, at + 1 + ((i * 37) % 200));
    yield new Uint8Array([...bytes.subarray(0, at), ...bytes.subarray(end)]);
  }
}

/** The stream with another payload, and good CRCs, in its first chunk of a type. */
export function replaceFirst(type, bytes, change) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const code = new DataView(new TextEncoder().encode(type).buffer).getUint32(0, true);
  let at = 24;
  while (view.getUint32(at, true) !== code) at += 32 + 8 * Math.ceil(view.getUint32(at + 16, true) / 8);
  const size = view.getUint32(at + 16, true);
  const payload = change(bytes.slice(at + 32, at + 32 + size));
  const header = bytes.slice(at, at + 32);
  const fields = new DataView(header.buffer);
  fields.setUint32(16, payload.length, true);
  fields.setUint32(24, crc32c(payload), true);
  fields.setUint32(28, crc32c(header.subarray(0, 28)), true);
  const padded = new Uint8Array(8 * Math.ceil(payload.length / 8));
  padded.set(payload);
  return new Uint8Array([
    ...bytes.subarray(0, at),
    ...header,
    ...padded,
    ...bytes.subarray(at + 32 + 8 * Math.ceil(size / 8)),
  ]);
}

/** The first group without its GEND, which would no longer match, with an unknown chunk after each mesh. */
export function withUnknown(bytes) {
  const type = (header) => String.fromCharCode(...header.subarray(0, 4));
  const sized = (at) => 32 + 8 * Math.ceil(new DataView(bytes.buffer, bytes.byteOffset + at).getUint32(16, true) / 8);
  const chunks = [];
  for (let at = 24; type(bytes.subarray(at)) !== "GEND"; at += sized(at)) {
    const chunk = bytes.slice(at, at + sized(at));
    chunks.push(chunk);
    if (type(chunk) !== "MESH") continue;
    const unknown = chunk.slice(0, 32); // of the same time and track, without a payload
    unknown.set(new TextEncoder().encode("note"));
    unknown.fill(0, 4, 5).fill(0, 16, 32);
    chunks.push(unknown);
  }
  chunks.forEach((chunk, i) => {
    const counts = type(chunk) !== "SCEN" && type(chunk) !== "GRUP";
    if (counts) chunk[5] = chunks[i - 1][5] + 1;
    new DataView(chunk.buffer).setUint32(28, crc32c(chunk.subarray(0, 28)), true);
  });
  return new Uint8Array([...bytes.subarray(0, 24), ...chunks.flatMap((chunk) => [...chunk])]);
}

export const replaceMesh = (bytes, change) => replaceFirst("MESH", bytes, change);

const HEADER = 32;
const BLOCK = 16; // of INDX: a configuration block
const ENTRY = 52;

function chunk(type, flags, counter, payload) {
  const bytes = Buffer.alloc(HEADER + 8 * Math.ceil(payload.length / 8));
  bytes.write(type, "latin1");
  bytes[4] = flags;
  bytes[5] = counter;
  bytes.writeBigUInt64LE(BigInt(payload.length), 16);
  bytes.writeUInt32LE(crc32c(payload), 24);
  bytes.writeUInt32LE(crc32c(bytes.subarray(0, 28)), 28);
  payload.copy(bytes, HEADER);
  return bytes;
}

/** The configuration of a stream, followed by count groups without frames, as its first group is one; without index and footer. */
export function withEmptyGroups(stream, count) {
  const bytes = Buffer.from(stream);
  const first = bytes.indexOf("GRUP", 0, "latin1");
  const group = bytes.subarray(first, first + 2 * (HEADER + 24));
  const out = Buffer.alloc(first + count * group.length);
  bytes.copy(out, 0, 0, first);
  for (let i = 0, at = first; i < count; i++, at += group.length) {
    group.copy(out, at);
    const [begin, end] = [
      out.subarray(at, at + group.length / 2),
      out.subarray(at + group.length / 2, at + group.length),
    ];
    for (const one of [begin, end]) one.writeUInt32LE(i, HEADER);
    // Each lasts a tick: the time of a header, and start and end of GRUP.
    begin.writeBigUInt64LE(BigInt(i), 8);
    begin.writeBigUInt64LE(BigInt(i), HEADER + 8);
    begin.writeBigUInt64LE(BigInt(i + 1), HEADER + 16);
    end.writeBigUInt64LE(BigInt(i + 1), 8);
    for (const one of [begin, end]) {
      if (one === end) one.writeUInt32LE(crc32c(begin.subarray(0, 28)), HEADER + 8);
      one.writeUInt32LE(crc32c(one.subarray(HEADER, HEADER + 24)), 24);
      one.writeUInt32LE(crc32c(one.subarray(0, 28)), 28);
    }
  }
  return out;
}

/** Configuration block, its digest, and groups of a stream, each group with its entry in the index. */
function partsOf(stream) {
  const indexOffset = Number(stream.readBigUInt64LE(stream.length - 24));
  const [groupCount, blockCount] = [0, 4].map((at) => stream.readUInt32LE(indexOffset + HEADER + at));
  const blocks = indexOffset + HEADER + 8;
  const entries = blocks + blockCount * BLOCK;
  const groups = Array.from({ length: groupCount }, (_, i) => {
    const entry = Buffer.from(stream.subarray(entries + i * ENTRY, entries + (i + 1) * ENTRY));
    const [offset, size] = [0, 8].map((at) => Number(entry.readBigUInt64LE(at)));
    return { entry, bytes: stream.subarray(offset, offset + size) };
  });
  const block = stream.subarray(24, Number(groups[0].entry.readBigUInt64LE(0)));
  return { block, digest: stream.readUInt32LE(blocks + 12), groups };
}

/** The first count groups of one stream, followed by the rest of another one of the same capture: a configuration that
 * changes, with index and footer. */
export function joinStreams(first, second, count) {
  const [a, b] = [partsOf(first), partsOf(second)];
  const pieces = [first.subarray(0, 24)];
  const blocks = [];
  const entries = [];
  let at = 24;
  const put = (bytes) => {
    pieces.push(bytes);
    at += bytes.length;
  };
  for (const { block, digest, groups } of [
    { ...a, groups: a.groups.slice(0, count) },
    { ...b, groups: b.groups.slice(count) },
  ]) {
    const listed = Buffer.alloc(BLOCK);
    listed.writeBigUInt64LE(BigInt(at));
    listed.writeUInt32LE(block.length, 8);
    listed.writeUInt32LE(digest, 12);
    blocks.push(listed);
    put(block);
    for (const { entry, bytes } of groups) {
      entry.writeBigUInt64LE(BigInt(at), 0);
      entry.writeUInt32LE(blocks.length - 1, 48);
      entries.push(entry);
      put(bytes);
    }
  }
  const head = Buffer.alloc(8);
  head.writeUInt32LE(entries.length);
  head.writeUInt32LE(blocks.length, 4);
  const index = Buffer.concat([head, ...blocks, ...entries]);
  const footer = Buffer.alloc(24);
  footer.writeBigUInt64LE(BigInt(at), 0);
  put(chunk("INDX", 0, 0, index));
  footer.writeBigUInt64LE(BigInt(at + HEADER + footer.length), 8);
  footer.writeUInt32LE(crc32c(index), 16);
  put(chunk("FOOT", 1, 1, footer));
  return Buffer.concat(pieces);
}
