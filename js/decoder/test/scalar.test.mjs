// Engines without SIMD use other code for fast meshes, with bit-identical results.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";
import { gunzipSync } from "node:zlib";

import { createDecoder } from "../dist/index.js";
import { frameHashes, makeClips, nativeFrames } from "./native.mjs";

const { clips, done } = makeClips("fast");
after(done);

test("an engine without SIMD decodes fast meshes to the same bits", async () => {
  const { compile } = WebAssembly;
  const sizes = [];
  WebAssembly.validate = () => false;
  WebAssembly.compile = (bytes) => {
    sizes.push(bytes.byteLength);
    return compile(bytes);
  };
  const decoder = await createDecoder({ source: new Uint8Array(readFileSync(clips.fast)) });
  const frames = [];
  for await (const frame of decoder) frames.push(frameHashes(frame));
  decoder.close();
  assert.deepEqual(frames, nativeFrames(clips.fast));
  const { base64 } = await import("../dist/fast.wasm.js");
  const size = gunzipSync(Buffer.from(base64, "base64")).length;
  assert.ok(sizes.includes(size), "the module without SIMD was not used");
});
