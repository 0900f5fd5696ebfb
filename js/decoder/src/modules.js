// The wasm modules, embedded in this package and compiled once: bundlers and servers need not locate .wasm files. They are
// loaded in the caller's thread only and sent to the worker, because Vite cannot build workers with dynamic imports.

/** Uint8Array.from would take ten times as long, and Response loads Node's implementation of fetch. */
async function unpack({ base64 }) {
  const text = atob(base64);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < packed.length; i++) packed[i] = text.charCodeAt(i);
  // A gzip file ends with the size of its content.
  const bytes = new Uint8Array(new DataView(packed.buffer).getUint32(packed.length - 4, true));
  const { readable, writable } = new DecompressionStream("gzip");
  const writer = writable.getWriter();
  writer.write(packed).catch(() => {});
  writer.close().catch(() => {});
  const reader = readable.getReader();
  for (let at = 0; ;) {
    const { done, value } = await reader.read();
    if (done) return bytes;
    bytes.set(value, at);
    at += value.length;
  }
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
export const compileEnvironment = () => compileOnce("environment", () => import("./environment.wasm.js"));

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
