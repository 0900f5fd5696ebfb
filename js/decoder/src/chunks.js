// Facts of the container (clauses 2.3, 3 and 4) that sources need before libfvv sees the bytes.

export const FILE_HEADER_SIZE = 24;
const SIGNATURE = [0x89, 0x46, 0x56, 0x56];

export const CHUNK_HEADER_SIZE = 32;
/** GRUP with its header. */
export const GROUP_SIZE = 56;
/** Types of chunks, as little-endian numbers. */
export const GROUP = 0x50555247; // "GRUP"
export const SCENE = 0x4e454353; // "SCEN"
const MESH = 0x4853454d; // "MESH"
const VIDEO = 0x544b5056; // "VPKT"
const TIME_OFFSET = 8;
const PAYLOAD_SIZE_OFFSET = 16;

export function beginsWithFileHeader(bytes) {
  return bytes.length >= FILE_HEADER_SIZE && SIGNATURE.every((byte, i) => bytes[i] === byte);
}

const viewOf = (bytes) => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

/** The type of the chunk that the bytes begin with; 0 if they are too short. */
export function chunkType(bytes) {
  return bytes.length < 4 ? 0 : viewOf(bytes).getUint32(0, true);
}

/** The time in ticks of the mesh or the picture that the bytes begin with; null: another chunk. */
export function frameTime(bytes) {
  if (bytes.length < CHUNK_HEADER_SIZE || ![MESH, VIDEO].includes(chunkType(bytes))) return null;
  return viewOf(bytes).getBigInt64(TIME_OFFSET, true);
}

/** The payload of the chunk that the bytes begin with; null if it is not complete. */
export function chunkPayload(bytes) {
  if (bytes.length < CHUNK_HEADER_SIZE) return null;
  const end = CHUNK_HEADER_SIZE + Number(viewOf(bytes).getBigUint64(PAYLOAD_SIZE_OFFSET, true));
  return end <= bytes.length ? bytes.subarray(CHUNK_HEADER_SIZE, end) : null;
}

const GEND_SIZE = 24;
const GEND_ROW_SIZE = 8;
/** A row of GEND names the track here. */
const GEND_TRACK = 4;

/**
 * The chunks that the payload of GEND lists (clause 6.3), [{track, from, end}] in bytes of the stream; offset: of the group.
 * Only to fetch them: libfvv checks the table before it uses it. What is no table gives what can be read of it.
 */
export function tableOfGroup(payload, offset) {
  const view = viewOf(payload);
  const chunks = [];
  if (payload.length < GEND_SIZE) return chunks;
  const rows = view.getUint32(16, true);
  let at = GEND_SIZE + GEND_ROW_SIZE * rows;
  const number = () => {
    let value = 0;
    for (let factor = 1; at < payload.length; factor *= 128) {
      const byte = payload[at++];
      value += (byte & 127) * factor;
      if (byte < 128) break;
    }
    return value;
  };
  for (let from = offset + GROUP_SIZE; at < payload.length;) {
    const [row, size] = [number(), number()];
    number(); // its time
    if (row >= rows || !(size < 2 ** 48)) break;
    const end = from + CHUNK_HEADER_SIZE + 8 * Math.ceil(size / 8);
    chunks.push({ track: view.getUint16(GEND_SIZE + GEND_ROW_SIZE * row + GEND_TRACK, true), from, end });
    from = end;
  }
  return chunks;
}

const table = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let i = 0; i < 8; i++) n = n & 1 ? (n >>> 1) ^ 0x82f63b78 : n >>> 1;
  return n;
});

/** CRC-32C of a whole file; libfvv checks the CRCs inside it. before: that of the bytes before these. */
export function crc32c(bytes, before = 0) {
  let crc = ~before;
  for (let i = 0; i < bytes.length; i++) crc = (crc >>> 8) ^ table[(crc ^ bytes[i]) & 255];
  return ~crc >>> 0;
}
