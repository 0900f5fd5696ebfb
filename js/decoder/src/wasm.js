// Instances of the wasm modules, each with memory of its own.

import { FvvError } from "./errors.js";
import { DIAGNOSTIC_SIZE } from "./flat.js";

const PAGE = 65536;
/** What the modules declare: no instance can have more. */
const MEMORY_MAX = 2 ** 31;
const INITIAL_PAGES = 64;
const PROJECTION_MEMORY = 2 ** 26;

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
  const draco = new DracoCalls(core);
  const fvv = {
    read: (offset, out, size) => (read(offset, new Uint8Array(core.memory.buffer, out, size)) ? 1 : 0),
    number: (value, digits, out, size) => putNumber(core.memory, value, digits, out, size),
    draco_check: (...call) => draco.check(...call),
    draco_decode: (...call) => draco.decode(...call),
  };
  return Object.assign(core, await instantiate(module, memoryBytes, fvv));
}

/** The module of environments, with Draco as in the core. */
export async function createBackground(module, memoryBytes) {
  const background = { draco: null };
  const draco = new DracoCalls(background);
  const fvv = {
    number: (...call) => putNumber(background.memory, ...call),
    draco_check: (...call) => draco.check(...call),
    draco_decode: (...call) => draco.decode(...call),
  };
  return Object.assign(background, await instantiate(module, memoryBytes, fvv));
}

/** Projection alone, which needs no more memory than its points. */
export function createProjection(module) {
  return instantiate(module, PROJECTION_MEMORY, {});
}

export async function createDraco(module, memoryBytes) {
  const draco = {};
  const number = (...call) => putNumber(draco.memory, ...call);
  return Object.assign(draco, await instantiate(module, memoryBytes, { number }));
}

/** As %g of C does, or nearly: for messages. */
function putNumber(memory, value, digits, out, size) {
  const text = Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : String(value);
  const { written } = new TextEncoder().encodeInto(text, new Uint8Array(memory.buffer, out, size));
  return written;
}

const STATUS_MEMORY = -2;
const STATUS_STATE = -5;
const STATUS_INVALID = -102;
const ISSUE_DRACO_STREAM = 3009;

/** What the core imports of Draco. A trap spoils that instance: the next mesh gets another one. */
class DracoCalls {
  constructor(core) {
    this.core = core;
    this.input = 0;
    this.size = 0;
  }
  #copyOut(from, to, size) {
    const { core } = this;
    new Uint8Array(core.memory.buffer, to, size).set(new Uint8Array(core.draco.memory.buffer, from, size));
  }
  #guard(diagnostic, call) {
    const { core } = this;
    try {
      const status = core.draco ? call(core.draco.exports) : STATUS_STATE;
      if (status !== 0 && core.draco)
        this.#copyOut(core.draco.exports.fvvdraco_diagnostic(), diagnostic, DIAGNOSTIC_SIZE);
      return status;
    } catch {
      core.draco = null;
      this.input = 0;
      new DataView(core.memory.buffer, diagnostic).setUint32(4, ISSUE_DRACO_STREAM, true);
      return STATUS_INVALID;
    }
  }
  check(data, size, vertices, faces, texture, normals, diagnostic) {
    const { core } = this;
    return this.#guard(diagnostic, (draco) => {
      if (this.input) draco.fvvdraco_free(this.input);
      this.input = draco.fvvdraco_alloc(size);
      this.size = size;
      if (!this.input) return STATUS_MEMORY;
      new Uint8Array(core.draco.memory.buffer, this.input, size).set(new Uint8Array(core.memory.buffer, data, size));
      return draco.fvvdraco_check(this.input, size, vertices, faces, texture, normals);
    });
  }
  decode(vertices, faces, positions, indices, texture, normals, diagnostic) {
    return this.#guard(diagnostic, (draco) => {
      const status = draco.fvvdraco_decode(this.input, this.size, vertices, faces, texture ? 1 : 0, normals ? 1 : 0);
      if (status === 0) {
        this.#copyOut(draco.fvvdraco_array(0), positions, 12 * vertices);
        this.#copyOut(draco.fvvdraco_array(1), indices, 12 * faces);
        if (texture) this.#copyOut(draco.fvvdraco_array(2), texture, 8 * vertices);
        if (normals) this.#copyOut(draco.fvvdraco_array(3), normals, 8 * vertices);
      }
      draco.fvvdraco_release();
      return status;
    });
  }
}
