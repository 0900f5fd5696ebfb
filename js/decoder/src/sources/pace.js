// How soon a host has responded lately. One that was quick and is silent now has lost the request, or has gone: it is asked again
// long before a time-out.

import { delay } from "../abort.js";

/** Responses, and gaps in bodies, that are remembered. */
const KEPT = 16;
/** A host may take this many times as long as it took lately. */
const FACTOR = 4;

/** The longest of the last few. */
class Longest {
  #recent = [];

  add(milliseconds) {
    this.#recent.push(milliseconds);
    if (this.#recent.length > KEPT) this.#recent.shift();
  }
  /** 0: none is known. */
  get value() {
    return Math.max(0, ...this.#recent);
  }
}

export class Pace {
  #quickMs;
  #responses = new Longest();
  #gaps = new Longest();
  #heard = -Infinity;
  #known = false;

  constructor(quickMs) {
    this.#quickMs = quickMs;
  }
  /** The first byte of a response has come, or a connection is open. */
  responded(milliseconds) {
    this.#known = true;
    this.#responses.add(milliseconds);
    this.#heard = performance.now();
  }
  /** More bytes have come. */
  went(milliseconds) {
    this.#gaps.add(milliseconds);
    this.#heard = performance.now();
  }
  /** Nothing came for so long, and no more is waited for: it may be that the network is as slow. */
  stalled(milliseconds) {
    this.#gaps.add(milliseconds);
  }

  /** Resolves when nothing has come since then, to any request, for longer than the host took lately; or when the signal is aborted. */
  async silence(since, signal) {
    while (!signal.aborted) {
      const longest = Math.max(this.#responses.value, this.#gaps.value);
      const limit = Math.max(this.#quickMs, FACTOR * longest);
      const left = this.#known ? Math.max(since, this.#heard) + limit - performance.now() : limit;
      if (left <= 0) return;
      await delay(left, signal);
    }
  }
}
