// The wasm modules, embedded in this package and compiled once: bundlers and servers need not locate .wasm files. They are
// loaded in the caller's thread only and sent to the worker, because Vite cannot build workers with dynamic imports.

async function unpack({ base64 }) {
  const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

const compiled = new Map();

function compileOnce(name, load) {
  if (!compiled.has(name)) {
    const module = load()
      .then(unpack)
      .then((bytes) => WebAssembly.compile(bytes));
    // After a failure the next call tries again.
    module.catch(() => compiled.delete(name));
    compiled.set(name, module);
  }
  return compiled.get(name);
}

export const compileCore = () => compileOnce("core", () => import("./core.wasm.js"));
export const compileProjection = () => compileOnce("projection", () => import("./projection.wasm.js"));
export const compileBackground = () => compileOnce("background", () => import("./background.wasm.js"));

/** (func (drop (v128.const 0))): engines without SIMD reject it. */
const simdProbe = Uint8Array.of(
  ...[0, 97, 115, 109, 1, 0, 0, 0, 1, 4, 1, 96, 0, 0, 3, 2, 1, 0],
  ...[10, 23, 1, 21, 0, 253, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 26, 11],
);
const hasSimd = () => WebAssembly.validate(simdProbe);

// Bundlers need literal names.
const codecs = {
  draco: () => import("./draco.wasm.js"),
  fast: () => (hasSimd() ? import("./fast_simd.wasm.js") : import("./fast.wasm.js")),
  openexr: () => import("./openexr.wasm.js"),
};
export const compileCodec = (name) => compileOnce(name, codecs[name]);
