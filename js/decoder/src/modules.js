// The wasm modules: bytes that travel inside this package, compiled once. No .wasm has to be found by bundlers or
// servers. Only the thread of the caller loads them and hands them on: Vite makes no workers that import what comes later.

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
    // A failure is told to whoever asked, and can be tried again.
    module.catch(() => compiled.delete(name));
    compiled.set(name, module);
  }
  return compiled.get(name);
}

export const compileCore = () => compileOnce("core", () => import("./core.wasm.js"));
export const compileProjection = () => compileOnce("projection", () => import("./projection.wasm.js"));
export const compileBackground = () => compileOnce("background", () => import("./background.wasm.js"));

// Bundlers have to see each name.
const codecs = {
  draco: () => import("./draco.wasm.js"),
  fast: () => import("./fast.wasm.js"),
  openexr: () => import("./openexr.wasm.js"),
};
export const compileCodec = (name) => compileOnce(name, codecs[name]);
