// Two streams of one capture made into one whose configuration changes, index and footer included.

import { crc32c } from "./damage.mjs";

const HEADER = 32;
const ENTRY = 56;

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

/** Configuration block and groups of a stream, each group with its entry in the index. */
function partsOf(stream) {
  const indexOffset = Number(stream.readBigUInt64LE(stream.length - 24));
  const entries = indexOffset + HEADER + 8;
  const groups = Array.from({ length: stream.readUInt32LE(indexOffset + HEADER) }, (_, i) => {
    const entry = Buffer.from(stream.subarray(entries + i * ENTRY, entries + (i + 1) * ENTRY));
    const [offset, size] = [0, 8].map((at) => Number(entry.readBigUInt64LE(at)));
    return { entry, bytes: stream.subarray(offset, offset + size) };
  });
  return { block: stream.subarray(24, Number(groups[0].entry.readBigUInt64LE(0))), groups };
}

/** The first groups of one stream and the others of another. */
export function joinStreams(first, second, count) {
  const [a, b] = [partsOf(first), partsOf(second)];
  const pieces = [first.subarray(0, 24)];
  const entries = [];
  let at = 24;
  const put = (bytes) => {
    pieces.push(bytes);
    at += bytes.length;
  };
  for (const { block, groups } of [
    { ...a, groups: a.groups.slice(0, count) },
    { ...b, groups: b.groups.slice(count) },
  ]) {
    const configuration = at;
    put(block);
    for (const { entry, bytes } of groups) {
      entry.writeBigUInt64LE(BigInt(at), 0);
      entry.writeBigUInt64LE(BigInt(configuration), 48);
      entries.push(entry);
      put(bytes);
    }
  }
  const head = Buffer.alloc(8);
  head.writeUInt32LE(entries.length);
  const index = Buffer.concat([head, ...entries]);
  const footer = Buffer.alloc(24);
  footer.writeBigUInt64LE(BigInt(at), 0);
  put(chunk("INDX", 0, 0, index));
  footer.writeBigUInt64LE(BigInt(at + HEADER + footer.length), 8);
  footer.writeUInt32LE(crc32c(index), 16);
  put(chunk("FOOT", 1, 1, footer));
  return Buffer.concat(pieces);
}
