// Where bytes come from. A source has:
//   stream(from, signal)       async iterator of Uint8Array from an offset to the end
//   size, read(offset, size)   only where any place can be read
//   part(from, end, signal)    only where reading less is worth requests, as long as inParts says so: as stream, to
//                              byte end - 1; leave() before; frugal is set by who begins with that
//   inRuns, groups             see runs.js
// open(description) makes one of a plain description that can be sent to a worker.

import { FvvError } from "./errors.js";
import { Live } from "./live.js";
import { Segments } from "./segments.js";

/** Enough for the index of a hundred groups. The first picture waits for these bytes. */
const SUFFIX = 1 << 13;
const BLOCK = 1 << 20;

class Bytes {
  constructor(bytes) {
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

class File {
  constructor(blob) {
    this.blob = blob;
    this.size = blob.size;
  }
  async read(offset, size) {
    return new Uint8Array(await this.blob.slice(offset, offset + size).arrayBuffer());
  }
  async *stream(from) {
    for (let at = from; at < this.size; at += BLOCK) yield this.read(at, Math.min(BLOCK, this.size - at));
  }
}

/** Bytes as they come, once. pull(): the next piece or null. */
class Stream {
  constructor(pull) {
    this.pull = pull;
  }
  async *stream() {
    for (;;) {
      const piece = await this.pull();
      if (!piece) return;
      yield piece;
    }
  }
}

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
  constructor(url, init, size, etag, suffix, warn) {
    Object.assign(this, { url, init, size, etag, suffix, warn, head: null, told: false });
    this.requests = 1;
    this.bytesRead = suffix.length;
  }
  /** A host that answers with everything is asked once. */
  get inParts() {
    return !this.told;
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
    for await (const piece of bodyOf(response)) {
      this.bytesRead += piece.length;
      const part = piece.subarray(Math.max(0, from - at), Math.max(0, end - at));
      at += piece.length;
      if (part.length) yield part;
      if (at >= end) return;
    }
  }
  async *part(from, end, signal) {
    const kept = this.size - this.suffix.length;
    const asked = Math.min(end, kept);
    let at = from;
    if (from < asked)
      for await (const piece of this.#wanted(await this.fetch(from, asked, signal), from, asked)) {
        at += piece.length;
        yield piece;
      }
    if (at < asked)
      throw new FvvError({ code: "io", message: `${this.url}: the answer ends ${asked - at} bytes too early` });
    if (end > kept) yield this.suffix.subarray(Math.max(0, from - kept), end - kept);
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
}

/** One answer with everything in it. */
class Download {
  constructor(response, abort) {
    Object.assign(this, { response, abort, bytesRead: 0, requests: 1 });
  }
  async *stream(from, signal) {
    signal?.addEventListener("abort", () => this.abort.abort());
    for await (const piece of bodyOf(this.response)) {
      this.bytesRead += piece.length;
      yield piece;
    }
  }
}

async function openUrl({ url, init = {}, seekable = true }, warn) {
  const abort = new AbortController();
  const whole = async () => {
    const response = await fetch(url, { ...init, signal: abort.signal });
    if (!response.ok) throw failed(url, response);
    return new Download(response, abort);
  };
  if (!seekable) return whole();
  const headers = { ...init.headers, Range: `bytes=-${SUFFIX}` };
  const response = await fetch(url, { ...init, headers, signal: abort.signal });
  if (response.status === 416) return whole();
  if (!response.ok) throw failed(url, response);
  const cannot = (why) => warn(noRange(url, why));
  if (response.status !== 206) {
    cannot(`the server answers ${response.status} to a request for a range`);
    return new Download(response, abort);
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
  return new Ranges(url, init, size, response.headers.get("etag"), suffix, warn);
}

/** description: {bytes}, {blob}, {url, init, seekable}, {segments: {url, init}}, {live: {url, ...}}, or {pull: true} with a function pull. */
export async function openSource(description, { pull, warn }) {
  if (description.bytes) return new Bytes(description.bytes);
  if (description.blob) return new File(description.blob);
  if (description.live) return Live.open(description.live, warn);
  if (description.segments) return Segments.open(description.segments);
  if (description.url) return openUrl(description, warn);
  return new Stream(pull);
}
