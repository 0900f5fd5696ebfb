// Instances of the wasm modules, each with memory of its own, and the calls of one instance into another.

import { FvvError } from "./errors.js";
import { DIAGNOSTIC_SIZE } from "./wasm_structs.js";

const PAGE = 65536;
/** The maximum that the modules declare. */
const MEMORY_MAX = 2 ** 31;
const INITIAL_PAGES = 64;
const PROJECTION_MEMORY = 2 ** 26;

function newMemory(bytes) {
  const maximum = Math.min(Math.floor(Math.min(bytes, MEMORY_MAX) / PAGE), MEMORY_MAX / PAGE);
  if (!(maximum >= INITIAL_PAGES))
    throw new FvvError({ code: "argument", message: `limits.memory is below ${INITIAL_PAGES * PAGE} bytes` });
  return new WebAssembly.Memory({ initial: INITIAL_PAGES, maximum });
}

// Imports of Emscripten's C library. None of them is called: nothing prints, reads or exits.
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

/** read(offset, out): fills a Uint8Array with bytes of the source and returns whether it could. */
export async function createCore(module, { memoryBytes, read = () => false }) {
  const core = {};
  core.codecs = new Codecs(core);
  const fvv = {
    ...core.codecs.imports,
    read: (offset, out, size) => (read(offset, new Uint8Array(core.memory.buffer, out, size)) ? 1 : 0),
    number: (...call) => putNumber(core.memory, ...call),
  };
  return Object.assign(core, await instantiate(module, memoryBytes, fvv));
}

/** The module of environments, which calls codecs as the core does. */
export const createEnvironment = (module, memoryBytes) => createCore(module, { memoryBytes });

/** Projection alone: it needs memory for its points only. */
export function createProjection(module) {
  return instantiate(module, PROJECTION_MEMORY, {});
}

/** A module that Codecs calls. */
export async function createCodec(module, memoryBytes, name) {
  const codec = {};
  const number = (...call) => putNumber(codec.memory, ...call);
  Object.assign(codec, await instantiate(module, memoryBytes, { number }));
  if (name === "draco") warmUp(codec);
  return codec;
}

/** A torus with a hole, as Draco's encoder codes it at level 9 with valence edgebreaker: the tools of large meshes. */
export const sample = {
  vertices: 42,
  faces: 82,
  base64:
    "RFJBQ08CAgEBAAACKlIAUQUDMAcfBQFKBwEBEAYBAgUDrQoDqSqtCgNzkq0GAAMDrSpVFQNUeou/CwECBAfRBTE6A+gdhxYBAgUH" +
    "6QIxOukCBIz+/IIjAQEBAUABAAAB/wAAAQAFAwAAAQQBAQEFIdkXMQ25DgUBkQMfhI0CBQGEhIQvhIkBKjDzDgUBVQASSolGJsoP" +
    "VQpBa5623iKtS6SYsB9gR7fj5jqz5ijN6td/gQ/eAzr0RhZRBSvyLtWAIasGgcZHgw6FCOADAD2BAAAAAGkAAAA=",
};

/** Engines that compile a function when it is first called do so now, and not while the first frame is awaited. */
function warmUp({ memory, exports }) {
  const bytes = Uint8Array.from(atob(sample.base64), (c) => c.charCodeAt(0));
  const input = exports.fvvcodec_alloc(bytes.length);
  new Uint8Array(memory.buffer, input, bytes.length).set(bytes);
  const size = [input, bytes.length, sample.vertices, sample.faces, 0, 0];
  if (exports.fvvcodec_check(...size) === 0) exports.fvvcodec_decode(...size);
  exports.fvvcodec_release();
  exports.fvvcodec_free(input);
}

/** A decoder of video. expired(): whether the current call has exceeded its time limit. */
export function createVideo(module, memoryBytes, expired) {
  return instantiate(module, memoryBytes, { expired });
}

/** Approximately %g of C, for messages. */
function putNumber(memory, value, digits, out, size) {
  const text = Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : String(value);
  const { written } = new TextEncoder().encodeInto(text, new Uint8Array(memory.buffer, out, size));
  return written;
}

/** Bit n of fvvjs_codecs stands for the nth codec. issue: reported for bytes on which the instance traps. */
const known = [
  { name: "draco", issue: 3009 },
  { name: "fast", issue: 3025 },
  { name: "openexr", issue: 4206 },
];

const STATUS_MEMORY = -2;
const STATUS_STATE = -5;
const STATUS_INVALID = -102;

/**
 * The codecs that the core and the module of environments import (wasm/codec_imports.c). Each of them has an instance
 * with memory of its own, and bytes are copied between the memories.
 */
class Codecs {
  #core;
  #loaded = new Map();
  #prepared = new Set();

  /** core: the instance whose memory is copied from and to. */
  constructor(core) {
    this.#core = core;
  }
  /** Whether a codec has to be loaded. bits: as of fvvjs_codecs. */
  lacks(bits) {
    return known.some(({ name }, n) => bits & (1 << n) && !this.#loaded.has(name));
  }
  /** load(name): loads that module, so that create has it; if this fails, create loads it again and reports the error. */
  prepare(bits, load) {
    for (const [n, { name }] of known.entries())
      if (bits & (1 << n) && !this.#prepared.has(name)) {
        this.#prepared.add(name);
        (async () => load(name))().catch(() => {});
      }
  }
  /** create(name): returns an instance of that module. */
  async load(bits, create) {
    for (const [n, { name }] of known.entries())
      if (bits & (1 << n) && !this.#loaded.has(name)) this.#loaded.set(name, await create(name));
  }
  get memoryBytes() {
    return [...this.#loaded.values()].reduce((sum, { memory }) => sum + memory.buffer.byteLength, 0);
  }

  /** The functions that wasm imports. */
  get imports() {
    const check = (name, [data, size, ...more], diagnostic) =>
      this.#call(name, diagnostic, (codec) => {
        if (!this.#put(codec, data, size)) return STATUS_MEMORY;
        return codec.exports.fvvcodec_check(codec.input, size, ...more);
      });
    return {
      draco_check: (data, size, vertices, faces, texture, normals, diagnostic) =>
        check("draco", [data, size, vertices, faces, texture, normals], diagnostic),
      draco_decode: (vertices, faces, positions, indices, texture, normals, diagnostic) =>
        this.#call("draco", diagnostic, (codec) =>
          this.#decode(codec, vertices, faces, [positions, indices, texture, normals]),
        ),
      fast_decode: (data, size, vertices, faces, positions, indices, texture, normals, diagnostic) =>
        this.#call("fast", diagnostic, (codec) => {
          if (!this.#put(codec, data, size)) return STATUS_MEMORY;
          return this.#decode(codec, vertices, faces, [positions, indices, texture, normals]);
        }),
      openexr_check: (data, size, width, height, diagnostic) =>
        check("openexr", [data, size, width, height], diagnostic),
    };
  }

  /** A trap leaves the instance in an unknown state: the next frame gets another one. */
  #call(name, diagnostic, call) {
    const codec = this.#loaded.get(name);
    if (!codec) return STATUS_STATE;
    try {
      const status = call(codec);
      if (status !== 0) this.#copyOut(codec, codec.exports.fvvcodec_why(), diagnostic, DIAGNOSTIC_SIZE);
      return status;
    } catch {
      this.#loaded.delete(name);
      const { issue } = known.find((one) => one.name === name);
      new DataView(this.#core.memory.buffer, diagnostic).setUint32(4, issue, true);
      return STATUS_INVALID;
    }
  }
  #copyOut(codec, from, to, size) {
    new Uint8Array(this.#core.memory.buffer, to, size).set(new Uint8Array(codec.memory.buffer, from, size));
  }
  /** Copies the input into the codec's memory, where it stays until the next one. */
  #put(codec, data, size) {
    if (codec.input) codec.exports.fvvcodec_free(codec.input);
    codec.input = codec.exports.fvvcodec_alloc(size);
    codec.size = size;
    if (!codec.input) return false;
    new Uint8Array(codec.memory.buffer, codec.input, size).set(new Uint8Array(this.#core.memory.buffer, data, size));
    return true;
  }
  #decode(codec, vertices, faces, [positions, indices, texture, normals]) {
    const { exports, input, size } = codec;
    const status = exports.fvvcodec_decode(input, size, vertices, faces, texture ? 1 : 0, normals ? 1 : 0);
    if (status === 0) {
      this.#copyOut(codec, exports.fvvcodec_array(0), positions, 12 * vertices);
      this.#copyOut(codec, exports.fvvcodec_array(1), indices, 12 * faces);
      if (texture) this.#copyOut(codec, exports.fvvcodec_array(2), texture, 8 * vertices);
      if (normals) this.#copyOut(codec, exports.fvvcodec_array(3), normals, 8 * vertices);
    }
    exports.fvvcodec_release();
    return status;
  }
}
