// @fvv/video-fallback: libavcodec's decoders as a wasm module, compiled for whoever asks. What drives it is in
// @fvv/decoder, so that its worker needs nothing of this package but the module.

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
