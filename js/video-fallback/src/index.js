// @fvv/video-fallback: libavcodec's decoders as a wasm module. The code that uses it is in @fvv/decoder, so that the decoder's
// worker needs only the compiled module of this package.

import { base64 } from "./video.wasm.js";

let compiled = null;

async function unpack() {
  const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(stream).arrayBuffer());
}

export function compile() {
  compiled ??= unpack().catch((error) => {
    compiled = null;
    throw error;
  });
  return compiled;
}
