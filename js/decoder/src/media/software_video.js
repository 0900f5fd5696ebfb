// Video by decoders in wasm where WebCodecs has none: the module of @fvv/video-fallback, which the caller provides.
// Each track has an instance of its own. An instance that traps or takes too long is dropped, and the next key picture
// gets another one. Damaged samples yield no picture.

import { createPicture, planesOf } from "./planar_picture.js";
import { createVideo } from "../wasm.js";

/** Version of the functions in video-fallback/wasm/decoder.c. */
const ABI = 1;
/** Time limit for a sample: many times what the largest picture takes. Only hostile samples reach it. */
const SAMPLE_MS = 4000;
/** Instances that a track may lose in succession. Each costs time and memory. */
const LOST_MAX = 4;

const text = new TextDecoder();

/** RangeError: the JavaScript stack overflowed inside wasm. */
const isTrap = (error) => error instanceof WebAssembly.RuntimeError || error instanceof RangeError;

class Instance {
  static async create(module, { memoryBytes, sampleMs }) {
    const instance = new Instance();
    Object.assign(instance, { sampleMs, deadline: Infinity });
    const expired = () => (performance.now() > instance.deadline ? 1 : 0);
    Object.assign(instance, await createVideo(module, memoryBytes, expired));
    const abi = instance.exports.fvvvideo_abi?.();
    if (abi !== ABI) throw new Error(`the fallback has version ${abi}, expected ${ABI}`);
    return instance;
  }
  #message() {
    const bytes = new Uint8Array(this.memory.buffer, this.exports.fvvvideo_message());
    return text.decode(bytes.slice(0, bytes.indexOf(0)));
  }
  #put(bytes) {
    const address = this.exports.fvvvideo_input(bytes.length);
    if (!address) throw new Error(`no memory for ${bytes.length} bytes`);
    new Uint8Array(this.memory.buffer, address, bytes.length).set(bytes);
  }
  /** Throws an Error if it cannot decode such video. */
  open({ codec, record, width, height, bitDepth }) {
    const code = Array.from(codec).reduce((sum, c, i) => sum + c.charCodeAt(0) * 2 ** (8 * i), 0);
    this.#put(record);
    if (!this.exports.fvvvideo_open(code, width, height, bitDepth)) throw new Error(this.#message());
  }
  /** Throws an Error for a damaged sample, or an error for which isTrap is true: the instance is lost. */
  decode(data, restart) {
    this.#put(data);
    this.deadline = performance.now() + this.sampleMs;
    if (!this.exports.fvvvideo_decode(restart ? 1 : 0)) throw new Error(this.#message());
  }
  /** Its planes without padding between rows, one after the other. */
  planes({ width, height, bitDepth }) {
    const { memory, exports } = this;
    const bytes = bitDepth > 8 ? 2 : 1;
    const planes = planesOf(width, height);
    const out = new Uint8Array(planes.reduce((sum, plane) => sum + plane.width * plane.height * bytes, 0));
    let at = 0;
    planes.forEach((plane, i) => {
      const start = exports.fvvvideo_plane(i);
      const stride = exports.fvvvideo_stride(i);
      const row = plane.width * bytes;
      for (let y = 0; y < plane.height; y++, at += row)
        out.set(new Uint8Array(memory.buffer, start + y * stride, row), at);
    });
    return out;
  }
}

class SoftwareTrack {
  #video;
  #layout;
  #instance;
  #needsKey = true;
  #lost = 0;
  #closed = false;
  #before = Promise.resolve();
  constructor(video, layout, instance) {
    this.#video = video;
    this.#layout = layout;
    this.#instance = instance;
  }
  /** In the order of the calls, also while a new instance is created. */
  submit(sample, timestamp) {
    const picture = this.#before.then(() => this.#decode(sample, timestamp));
    this.#before = picture.catch(() => {});
    return picture;
  }
  async #decode(sample, timestamp) {
    if (this.#closed || (this.#needsKey && !sample.key) || this.#lost > LOST_MAX) return null;
    try {
      this.#instance ??= await this.#video.take(this.#layout);
      this.#instance.decode(sample.data, this.#needsKey);
      const data = this.#instance.planes(this.#layout);
      this.#needsKey = false;
      this.#lost = 0;
      const { width, height, bitDepth, colour } = this.#layout;
      const format = bitDepth > 8 ? "I420P10" : "I420";
      return createPicture({ format, width, height, timestamp, colour, data });
    } catch (error) {
      this.#needsKey = true;
      this.#video.corrupt(this.#explain(error, timestamp), this.#layout);
      return null;
    }
  }
  #explain(error, timestamp) {
    const sample = `the sample of ${timestamp} us`;
    if (!isTrap(error)) return new Error(`${sample}: ${error.message}`);
    const { sampleMs, deadline } = this.#instance;
    const late = performance.now() > deadline;
    this.#instance = null;
    const end = ++this.#lost > LOST_MAX ? ", like others before: no more pictures of this track" : "";
    const why = late ? `takes more than ${sampleMs} ms` : `makes its decoder trap (${error.message})`;
    return new Error(`${sample} ${why}${end}`);
  }
  async flush() {
    await this.#before;
    this.#needsKey = true;
  }
  close() {
    this.#closed = true;
    if (this.#instance) this.#video.give(this.#instance);
    this.#instance = null;
  }
}

export class SoftwareVideo {
  #load;
  #bounds;
  #idle = [];
  /** load(): returns the compiled module. corrupt(error, layout): called for a sample without a picture. */
  constructor({ load, memoryBytes, sampleMs = SAMPLE_MS, corrupt }) {
    this.#load = load;
    this.#bounds = { memoryBytes, sampleMs };
    this.corrupt = corrupt;
  }
  /** Returns a track, or throws an Error. */
  async open(layout) {
    return new SoftwareTrack(this, layout, await this.take(layout));
  }
  /** Seeking opens all tracks again: their instances are reused. */
  async take(layout) {
    const instance = this.#idle.pop() ?? (await Instance.create(await this.#load(), this.#bounds));
    try {
      instance.open(layout);
      return instance;
    } catch (error) {
      if (!isTrap(error)) this.give(instance);
      throw error;
    }
  }
  give(instance) {
    this.#idle.push(instance);
  }
}
