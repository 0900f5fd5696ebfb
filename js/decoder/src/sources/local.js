// Sources without a network: memory, files, and streams that the caller provides.

import { onAbort, unlessAborted } from "../abort.js";
import { RangeSource, SequentialSource } from "./types.js";

const BLOCK = 1 << 20;

export class BufferSource extends RangeSource {
  constructor(bytes) {
    super();
    this.bytes = bytes;
    this.size = bytes.length;
  }
  async read(offset, size) {
    return this.bytes.subarray(offset, offset + size);
  }
  async *stream(from) {
    for (let at = from; at < this.size; at += BLOCK) yield this.bytes.subarray(at, at + BLOCK);
  }
}

export class BlobSource extends RangeSource {
  #blob;
  constructor(blob) {
    super();
    this.#blob = blob;
    this.size = blob.size;
  }
  async read(offset, size) {
    return new Uint8Array(await this.#blob.slice(offset, offset + size).arrayBuffer());
  }
  async *stream(from) {
    for (let at = from; at < this.size; at += BLOCK) yield this.read(at, Math.min(BLOCK, this.size - at));
  }
}

export class PulledSource extends SequentialSource {
  #pull;
  #closed = new AbortController();
  /** pull(): resolves to the next piece, or null. */
  constructor(pull, signal) {
    super();
    this.#pull = pull;
    onAbort(signal, () => this.close());
  }
  async *stream() {
    while (!this.complete) {
      const piece = await unlessAborted(this.#pull(), this.#closed.signal);
      if (piece) this.front += piece.length;
      else this.complete = true;
      if (piece) yield piece;
    }
  }
  close() {
    this.#closed.abort();
  }
}
