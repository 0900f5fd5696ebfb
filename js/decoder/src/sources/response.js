// A file on a host without Range, or for which one request is wanted.

import { onAbort, unlessAborted } from "../abort.js";
import { SequentialSource } from "./types.js";

/** A single response with the whole file. Its bytes can be read again as long as the cache has all of them. */
export class ResponseSource extends SequentialSource {
  #network;
  #cache;
  #pieces;
  #piece = null; // promise of the next piece, which outlives a seek

  constructor(url, reply, network, { cache, rewinds }) {
    super();
    const { headers } = reply;
    const size = headers.get("content-encoding") ? 0 : Number(headers.get("content-length"));
    this.type = headers.get("content-type");
    this.#network = network;
    this.#cache = cache;
    this.rewinds = rewinds && cache.limit > 0 && size <= cache.limit;
    this.#pieces = network.body(url, reply);
  }
  /** Those before it were in vain. */
  get requests() {
    return 1;
  }
  get bytesRead() {
    return this.#network.bytesRead;
  }

  async *stream(from, signal) {
    const unregister = onAbort(signal, () => this.rewinds || this.#network.close());
    if (from < this.front) this.#cache.hits++;
    try {
      for (let at = from; ;) {
        if (at >= this.front && !this.rewinds) this.#cache.clear();
        const piece = at < this.front ? this.#cache.take(at, this.front) : await this.#next(signal);
        if (!piece) return;
        at += piece.length;
        yield piece;
      }
    } finally {
      unregister();
      if (!this.rewinds) this.#pieces.return().catch(() => {});
    }
  }
  async #next(signal) {
    this.#piece ??= this.#pieces.next();
    // Another seek may wait for it again.
    this.#piece.catch(() => {});
    const { done, value } = await unlessAborted(this.#piece, signal);
    this.#piece = null;
    this.complete = done;
    if (done) return null;
    if (this.rewinds) {
      this.#cache.put(this.front, value);
      this.rewinds = this.#cache.coveredUntil(0, 1) === 1;
    }
    this.front += value.length;
    return value;
  }

  kept(offset, out) {
    return this.#cache.copy(offset, out);
  }
  holds(from, end) {
    return this.rewinds && end <= this.front;
  }
  /** Damaged bytes are not kept, and without them the rest is useless. */
  forget() {
    this.rewinds = false;
  }
  close() {
    this.#network.close();
    this.#cache.clear();
  }
}
