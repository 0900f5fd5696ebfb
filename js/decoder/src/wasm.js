// The two wasm modules: bytes that travel inside this package, compiled once, and instances with memory of their own.
// Nothing here fetches anything, so that no bundler and no server has to be told where a .wasm lies.

import { FvvError } from "./errors.js";
import { DIAGNOSTIC_SIZE } from "./flat.js";

const PAGE = 65536;
/** What the modules declare: no instance can have more. */
const MEMORY_MAX = 2 ** 31;
const INITIAL_PAGES = 64;

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
export const compileDraco = () => compileOnce("draco", () => import("./draco.wasm.js"));

function newMemory(bytes) {
  const maximum = Math.min(Math.floor(Math.min(bytes, MEMORY_MAX) / PAGE), MEMORY_MAX / PAGE);
  if (!(maximum >= INITIAL_PAGES))
    throw new FvvError({ code: "argument", message: `limits.memory is below ${INITIAL_PAGES * PAGE} bytes` });
  return new WebAssembly.Memory({ initial: INITIAL_PAGES, maximum });
}

// What the C library of Emscripten asks for. None of it is reached: nothing prints, reads or exits.
const unused = new Proxy({}, { get: () => () => 0, has: () => true });

function imports(module, memory, fvv) {
  const given = { fvv, env: { memory, emscripten_notify_memory_growth() {} } };
  const all = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    all[from] ??= {};
    all[from][name] = given[from]?.[name] ?? unused[name];
  }
  return all;
}

async function instantiate(module, memoryBytes, fvv) {
  const memory = newMemory(memoryBytes);
  const { exports } = await WebAssembly.instantiate(module, imports(module, memory, fvv));
  exports._initialize?.();
  return { memory, exports };
}

/**
 * An instance of the core. read(offset, out): fills a Uint8Array with the source's bytes and answers whether it could.
 * draco: for Draco's meshes, or null as long as there is none.
 */
export async function createCore(module, { memoryBytes, read = () => false }) {
  const core = { draco: null };
  const fvv = {
    read: (offset, out, size) => (read(offset, new Uint8Array(core.memory.buffer, out, size)) ? 1 : 0),
    draco: (...call) => decodeDraco(core, ...call),
  };
  return Object.assign(core, await instantiate(module, memoryBytes, fvv));
}

export function createDraco(module, memoryBytes) {
  return instantiate(module, memoryBytes, {});
}

const STATUS_MEMORY = -2;
const STATUS_INVALID = -102;
const ISSUE_DRACO_STREAM = 3009;

/** fvv_draco_decode of the core: data goes over, arrays come back. */
function decodeDraco(core, data, size, vertices, faces, positions, indices, texture, normals, diagnostic) {
  const { draco } = core;
  if (!draco) return -5;
  try {
    const { exports } = draco;
    const input = exports.fvvdraco_alloc(size);
    if (!input) return STATUS_MEMORY;
    new Uint8Array(draco.memory.buffer, input, size).set(new Uint8Array(core.memory.buffer, data, size));
    const status = exports.fvvdraco_decode(input, size, vertices, faces, texture ? 1 : 0, normals ? 1 : 0);
    exports.fvvdraco_free(input);
    const copy = (from, to, bytes) =>
      new Uint8Array(core.memory.buffer, to, bytes).set(new Uint8Array(draco.memory.buffer, from, bytes));
    if (status === 0) {
      copy(exports.fvvdraco_array(0), positions, 12 * vertices);
      copy(exports.fvvdraco_array(1), indices, 12 * faces);
      if (texture) copy(exports.fvvdraco_array(2), texture, 8 * vertices);
      if (normals) copy(exports.fvvdraco_array(3), normals, 8 * vertices);
    } else {
      copy(exports.fvvdraco_diagnostic(), diagnostic, DIAGNOSTIC_SIZE);
    }
    exports.fvvdraco_release();
    return status;
  } catch {
    // A trap: this instance can't be trusted any more; the next mesh gets another one.
    core.draco = null;
    const view = new DataView(core.memory.buffer, diagnostic, DIAGNOSTIC_SIZE);
    view.setInt32(0, STATUS_INVALID, true);
    view.setUint32(4, ISSUE_DRACO_STREAM, true);
    return STATUS_INVALID;
  }
}
