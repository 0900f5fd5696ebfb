// Instances of the wasm modules, each with memory of its own.

import { Codecs } from "./codecs.js";
import { FvvError } from "./errors.js";

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

/** read(offset, out): fills a Uint8Array with the source's bytes and answers whether it could. */
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

/** The module of environments, which borrows codecs as the core does. */
export const createBackground = (module, memoryBytes) => createCore(module, { memoryBytes });

/** Projection alone, which needs no more memory than its points. */
export function createProjection(module) {
  return instantiate(module, PROJECTION_MEMORY, {});
}

/** A module that codecs.js calls. */
export async function createCodec(module, memoryBytes) {
  const codec = {};
  const number = (...call) => putNumber(codec.memory, ...call);
  return Object.assign(codec, await instantiate(module, memoryBytes, { number }));
}

/** One decoder of video. expired(): whether the call that goes on has had its time. */
export function createVideo(module, memoryBytes, expired) {
  return instantiate(module, memoryBytes, { expired });
}

/** As %g of C does, or nearly: for messages. */
function putNumber(memory, value, digits, out, size) {
  const text = Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : String(value);
  const { written } = new TextEncoder().encodeInto(text, new Uint8Array(memory.buffer, out, size));
  return written;
}
