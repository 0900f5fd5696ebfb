// What others make of GLB files: `node gltf.mjs FILE...` prints a list, for each file what Khronos' validator reports,
// and the bytes of the views that EXT_meshopt_compression holds, by meshoptimizer's own decoder, in base64.

import { readFileSync } from "node:fs";

import validator from "gltf-validator";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";

/** The JSON of a GLB, and its chunk BIN. */
function opened(bytes) {
  const size = bytes.readUInt32LE(12);
  return { document: JSON.parse(bytes.toString("utf8", 20, 20 + size)), binary: bytes.subarray(28 + size) };
}

/** Bytes by the index of the view. */
function decompressed({ document, binary }) {
  const views = {};
  for (const [index, view] of document.bufferViews.entries()) {
    const packed = view.extensions?.EXT_meshopt_compression;
    if (!packed) continue;
    const out = new Uint8Array(packed.count * packed.byteStride);
    const source = binary.subarray(packed.byteOffset, packed.byteOffset + packed.byteLength);
    MeshoptDecoder.decodeGltfBuffer(out, packed.count, packed.byteStride, source, packed.mode, packed.filter);
    views[index] = Buffer.from(out).toString("base64");
  }
  return views;
}

await MeshoptDecoder.ready;
const report = [];
for (const file of process.argv.slice(2)) {
  const bytes = readFileSync(file);
  const { issues } = await validator.validateBytes(new Uint8Array(bytes));
  report.push({ file, issues: issues.messages, views: decompressed(opened(bytes)) });
}
console.log(JSON.stringify(report));
