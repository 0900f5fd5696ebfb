// What the core and the module of environments borrow of other modules (wasm/codec_imports.c). Each of those has an
// instance with memory of its own, and bytes are copied to and fro.

import { DIAGNOSTIC_SIZE } from "./flat.js";

/** Bit n of what wasm asks for is the nth. issue: what is said of bytes that an instance does not survive. */
const known = [
  { name: "draco", issue: 3009 },
  { name: "fast", issue: 3025 },
  { name: "openexr", issue: 4206 },
];

const STATUS_MEMORY = -2;
const STATUS_STATE = -5;
const STATUS_INVALID = -102;

export class Codecs {
  #loaded = new Map();

  /** core: whose memory is copied from and to. */
  constructor(core) {
    this.core = core;
  }
  /** Whether load has something to do. bits: as of fvvjs_codecs. */
  lacks(bits) {
    return known.some(({ name }, n) => bits & (1 << n) && !this.#loaded.has(name));
  }
  /** create(name): an instance of that module. */
  async load(bits, create) {
    for (const [n, { name }] of known.entries())
      if (bits & (1 << n) && !this.#loaded.has(name)) this.#loaded.set(name, await create(name));
  }
  get memoryBytes() {
    return [...this.#loaded.values()].reduce((sum, { memory }) => sum + memory.buffer.byteLength, 0);
  }

  /** What wasm imports. */
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

  /** A trap spoils the instance: the next frame gets another one. */
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
      new DataView(this.core.memory.buffer, diagnostic).setUint32(4, issue, true);
      return STATUS_INVALID;
    }
  }
  #copyOut(codec, from, to, size) {
    new Uint8Array(this.core.memory.buffer, to, size).set(new Uint8Array(codec.memory.buffer, from, size));
  }
  /** The codec's own copy of what it is to read, which it keeps until the next one. */
  #put(codec, data, size) {
    if (codec.input) codec.exports.fvvcodec_free(codec.input);
    codec.input = codec.exports.fvvcodec_alloc(size);
    codec.size = size;
    if (!codec.input) return false;
    new Uint8Array(codec.memory.buffer, codec.input, size).set(new Uint8Array(this.core.memory.buffer, data, size));
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
