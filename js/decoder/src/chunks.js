// Facts of the container (clauses 2.3, 3 and 4) that sources need before libfvv sees the bytes.

export const FILE_HEADER_SIZE = 24;
const SIGNATURE = [0x89, 0x46, 0x56, 0x56];

const CHUNK_HEADER_SIZE = 32;
/** GRUP with its header. */
export const GROUP_SIZE = 56;
/** Types of chunks, as little-endian numbers. */
export const GROUP = 0x50555247; // "GRUP"
export const SCENE = 0x4e454353; // "SCEN"
const PAYLOAD_SIZE_OFFSET = 16;

export function beginsWithFileHeader(bytes) {
  return bytes.length >= FILE_HEADER_SIZE && SIGNATURE.every((byte, i) => bytes[i] === byte);
}

const viewOf = (bytes) => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

/** The type of the chunk that the bytes begin with; 0 if they are too short. */
export function chunkType(bytes) {
  return bytes.length < 4 ? 0 : viewOf(bytes).getUint32(0, true);
}

/** The payload of the chunk that the bytes begin with; null if it is not complete. */
export function chunkPayload(bytes) {
  if (bytes.length < CHUNK_HEADER_SIZE) return null;
  const end = CHUNK_HEADER_SIZE + Number(viewOf(bytes).getBigUint64(PAYLOAD_SIZE_OFFSET, true));
  return end <= bytes.length ? bytes.subarray(CHUNK_HEADER_SIZE, end) : null;
}

const table = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let i = 0; i < 8; i++) n = n & 1 ? (n >>> 1) ^ 0x82f63b78 : n >>> 1;
  return n;
});

/** CRC-32C of a whole file; libfvv checks the CRCs inside it. */
export function crc32c(bytes) {
  let crc = ~0;
  for (let i = 0; i < bytes.length; i++) crc = (crc >>> 8) ^ table[(crc ^ bytes[i]) & 255];
  return ~crc >>> 0;
}
