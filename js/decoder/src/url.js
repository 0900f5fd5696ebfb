// What is fetched from a URL: by Range where the host keeps to it, else in one answer. What has come stays in a cache.

import { FvvError } from "./errors.js";

/** Enough for the index of a hundred groups. The first picture waits for these bytes. */
const SUFFIX = 1 << 13;
/** What a round trip of 40 ms costs at 8 Mbit/s: fewer bytes are fetched once more rather than with another request. */
export const ROUND_TRIP_BYTES = 40000;

async function* bodyOf(response) {
  const reader = response.body.getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      yield value;
    }
  } finally {
    reader.cancel().catch(() => {});
  }
}

function failed(url, response) {
  return new FvvError({ code: "io", message: `${url}: HTTP status ${response.status}` });
}

function noRange(url, why) {
  const message = `${url} is read from front to back: ${why}`;
  return new FvvError({ code: "no-range", severity: "warning", fatal: false, message });
}

/** A host that keeps to Range. What is asked for first begins at byte 0 and goes on into what is played. */
class Ranges {
  constructor(url, init, size, etag, suffix, { warn, cache }) {
    Object.assign(this, { url, init, size, etag, suffix, warn, cache, head: null, told: false });
    this.requests = 1;
    this.bytesRead = suffix.length;
  }
  /** A host that answers with everything is asked once. */
  get inParts() {
    return !this.told;
  }
  /** From here on bytes are those that came first. */
  get #suffixAt() {
    return this.size - this.suffix.length;
  }
  async fetch(from, end, signal) {
    this.requests++;
    const headers = { ...this.init.headers, Range: `bytes=${from}-${end - 1}` };
    const response = await fetch(this.url, { ...this.init, headers, signal });
    if (response.status !== 206 && response.status !== 200) throw failed(this.url, response);
    const etag = response.headers.get("etag");
    const range = /^bytes (\d+)-\d+\/(\d+|\*)$/.exec(response.headers.get("content-range") ?? "");
    const total = response.status === 200 ? null : range && range[2] !== "*" ? Number(range[2]) : this.size;
    if (etag !== this.etag || (total !== null && total !== this.size))
      throw new FvvError({
        code: "changed",
        message: `${this.url} changed while it was read: ETag ${this.etag}, now ${etag}`,
      });
    if (range && response.status === 206 && Number(range[1]) !== from)
      throw new FvvError({ code: "io", message: `${this.url}: asked for byte ${from}, got ${range[1]}` });
    return response;
  }
  /** What was asked for, also out of an answer with everything, as hosts give that stop to keep to Range. */
  async *#wanted(response, from, end) {
    let at = response.status === 206 ? from : 0;
    if (response.status === 200 && !this.told) {
      this.told = true;
      this.warn(noRange(this.url, "the server does not keep to Range any more"));
    }
    // All of such an answer has to be read up to where it is wanted: it may all be of use.
    const good = Math.min(this.#suffixAt, response.status === 206 ? end : Infinity);
    for await (const piece of bodyOf(response)) {
      this.bytesRead += piece.length;
      this.cache.put(at, piece.subarray(0, Math.max(0, good - at)));
      const part = piece.subarray(Math.max(0, from - at), Math.max(0, end - at));
      at += piece.length;
      if (part.length) yield part;
      if (at >= end) return;
    }
  }
  async *part(from, end, signal) {
    let reused = false;
    for (let at = from; at < end;) {
      // Where the suffix begins can change meanwhile.
      const asked = Math.min(end, this.#suffixAt);
      const kept = at < asked ? this.cache.take(at, asked) : this.suffix.subarray(at - asked, end - asked);
      if (kept) {
        if (!reused && at < asked) this.cache.hits++;
        at += kept.length;
        yield kept;
      } else {
        const until = this.cache.lack(at, asked, ROUND_TRIP_BYTES);
        for await (const piece of this.#wanted(await this.fetch(at, until, signal), at, until)) {
          at += piece.length;
          yield piece;
        }
        if (at < until)
          throw new FvvError({ code: "io", message: `${this.url}: the answer ends ${until - at} bytes too early` });
      }
      reused = kept !== null;
    }
  }
  /** The first bytes, at least size; the answer that they come with is kept open for stream. */
  async beginning(size) {
    const abort = new AbortController();
    this.head ??= { abort, body: this.part(0, this.size, abort.signal), pieces: [], length: 0 };
    const { head } = this;
    while (head.length < size) {
      const { done, value } = await head.body.next();
      if (done) break;
      head.pieces.push(value);
      head.length += value.length;
    }
    return new Uint8Array(await new Blob(head.pieces).arrayBuffer());
  }
  async read(offset, size) {
    if (offset === 0 && !this.frugal) return (await this.beginning(size)).subarray(0, size);
    const pieces = [];
    for await (const piece of this.part(offset, offset + size)) pieces.push(piece);
    return new Uint8Array(await new Blob(pieces).arrayBuffer());
  }
  /** What was asked for with the beginning is not wanted any more. */
  leave() {
    this.head?.abort.abort();
    this.head = null;
  }
  async *stream(from, signal) {
    const { head } = this;
    if (from > 0) this.leave();
    this.head = null;
    if (!head || from > 0) {
      yield* this.part(from, this.size, signal);
      return;
    }
    signal?.addEventListener("abort", () => head.abort.abort());
    yield* head.pieces;
    yield* head.body;
  }

  divide(offsets) {
    this.cache.divide(offsets);
  }
  kept(offset, out) {
    return this.cache.copy(offset, out);
  }
  holds(from, end) {
    const asked = Math.min(end, this.#suffixAt);
    return this.cache.reach(from, asked) >= asked;
  }
  forget(offset) {
    if (this.cache.drop(offset) > this.#suffixAt) this.suffix = new Uint8Array(0);
  }
  close() {
    this.leave();
    this.cache.clear();
  }
}

/** One answer with everything in it. What has gone by can be read again as long as the cache has all of it. */
class Download {
  #body;
  #piece = null; // that is waited for, also over a seek
  #wake = null;
  front = 0;
  complete = false;
  bytesRead = 0;
  requests = 1;

  constructor(response, abort, { cache, rewinds }) {
    const { headers } = response;
    const size = headers.get("content-encoding") ? 0 : Number(headers.get("content-length"));
    Object.assign(this, { abort, cache, rewinds: rewinds && cache.most > 0 && size <= cache.most });
    this.#body = response.body.getReader();
  }

  async *stream(from, signal) {
    const stop = () => {
      if (!this.rewinds) this.abort.abort();
      this.#wake?.();
    };
    signal?.addEventListener("abort", stop);
    if (from < this.front) this.cache.hits++;
    try {
      for (let at = from; ;) {
        if (at >= this.front && !this.rewinds) this.cache.clear();
        const piece = at < this.front ? this.cache.take(at, this.front) : await this.#next(signal);
        if (!piece) return;
        at += piece.length;
        yield piece;
      }
    } finally {
      signal?.removeEventListener("abort", stop);
      if (!this.rewinds) this.#body.cancel().catch(() => {});
    }
  }
  async #next(signal) {
    this.#piece ??= this.#body.read();
    await new Promise((resolve, reject) => {
      this.#wake = resolve;
      this.#piece.then(resolve, reject);
    });
    signal?.throwIfAborted();
    const { done, value } = await this.#piece;
    this.#piece = null;
    this.complete = done;
    if (done) return null;
    this.bytesRead += value.length;
    if (this.rewinds) {
      this.cache.put(this.front, value);
      this.rewinds = this.cache.reach(0, 1) === 1;
    }
    this.front += value.length;
    return value;
  }

  kept(offset, out) {
    return this.cache.copy(offset, out);
  }
  holds(from, end) {
    return this.rewinds && end <= this.front;
  }
  /** What is damaged is not kept, and without it the rest is of no use. */
  forget() {
    this.rewinds = false;
  }
  close() {
    this.abort.abort();
    this.cache.clear();
  }
}

/** warn(error). cache: for what comes. seekable false: nothing but one answer is asked for, and nothing is kept. */
export async function openUrl({ url, init = {}, seekable = true }, { warn, cache }) {
  const abort = new AbortController();
  const whole = async () => {
    const response = await fetch(url, { ...init, signal: abort.signal });
    if (!response.ok) throw failed(url, response);
    return new Download(response, abort, { cache, rewinds: seekable });
  };
  if (!seekable) return whole();
  const headers = { ...init.headers, Range: `bytes=-${SUFFIX}` };
  const response = await fetch(url, { ...init, headers, signal: abort.signal });
  if (response.status === 416) return whole();
  if (!response.ok) throw failed(url, response);
  const cannot = (why) => warn(noRange(url, why));
  if (response.status !== 206) {
    cannot(`the server answers ${response.status} to a request for a range`);
    return new Download(response, abort, { cache, rewinds: true });
  }
  const range = /^bytes (\d+)-(\d+)\/(\d+)$/.exec(response.headers.get("content-range") ?? "");
  const encoding = response.headers.get("content-encoding");
  const suffix = new Uint8Array(await response.arrayBuffer());
  const [first, last, size] = range ? range.slice(1).map(Number) : [];
  const why = !range
    ? "the answer has no Content-Range that can be read (cross-origin hosts have to expose it)"
    : encoding && encoding !== "identity"
      ? `it comes with Content-Encoding ${encoding}`
      : last + 1 !== size || last - first + 1 !== suffix.length
        ? `Content-Range ${range[0]} does not fit ${suffix.length} bytes of the end`
        : null;
  if (why) {
    cannot(why);
    return whole();
  }
  return new Ranges(url, init, size, response.headers.get("etag"), suffix, { warn, cache });
}
