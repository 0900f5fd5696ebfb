// Where bytes come from: memory, files, streams and URLs. A source has:
//   stream(from, signal)       async iterator of Uint8Array from an offset to the end
//   size, read(offset, size)   only if it can be read at any offset
//   range(from, end, signal)   only if reading less is worth more requests, as long as inRanges is true: as stream, up to
//                              byte end - 1; frugal is set by the caller who begins with range. The first bytes were
//                              requested when the source was opened, lead() asks for more; they serve near ranges,
//                              too, until leave() ends this
//   front, rewinds, complete   of a single response: bytes that have arrived, whether they can all be read again (then
//                              stream begins anywhere up to front), and whether the response is complete
//   holds(from, end)           whether bytes need no network; without this method no bytes need it
//   kept(offset, out)          copies bytes of a cache to out, or returns false
//   type                       Content-Type of a response, or null
//   divide(offsets)            sets where groups begin; forget(offset): a byte there is damaged; close()
//   rungs, follow(choices, position), renew(), buffer   of a source that has each rung by itself: choices(seconds) returns ; renew(): another quality is wanted
//   rungOf(tracks), throughput of a source that changes the rung by itself: {rung, reason} of a configuration with these tracks
//   inSections, groups         a source in sections has inSections true. A section is a file header, a configuration
//                              block and then any groups (clause 6.4). Between pieces of bytes such a source yields
//     {header}                 a section begins; these are the bytes of its file header, the rest follows as bytes
//     {damage: error}          damage, before the loss that it causes
//     {lost: {error, from}}    data is missing up to the next group; from: ticks, or undefined
//     {restart: true}          another stream begins
//     {rung, reason}           the groups that follow are of this rung
//     {rungs}                  the rungs have changed
//                              With groups (as readGroups returns them) it can seek: stream(group) begins with that group.

import { FvvError } from "../errors.js";
import { Live } from "./live.js";
import { failed, request } from "./request.js";
import { Segments } from "./segments.js";

const BLOCK = 1 << 20;

class BufferSource {
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

class BlobSource {
  #blob;
  constructor(blob) {
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

/** Bytes in order, once. pull(): the next piece or null. */
class SequentialSource {
  #pull;
  constructor(pull) {
    this.#pull = pull;
  }
  async *stream() {
    for (;;) {
      const piece = await this.#pull();
      if (!piece) return;
      yield piece;
    }
  }
}

/** Enough for the index of a hundred groups. The first picture has to wait for these bytes. */
const SUFFIX = 1 << 13;
/** First bytes, requested at the same time: enough for the configuration of fifty cameras. */
const FRONT = 1 << 14;
/** The cost of a round trip of 40 ms at 8 Mbit/s: fewer bytes are fetched again rather than split over two requests. */
export const ROUND_TRIP_BYTES = 40000;

/** For requests for ranges. A browser that uses its cache handles requests for one URL one at a time, each with its own round trip. */
const AT_ONCE = { cache: "no-store" };

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

function noRange(url, why) {
  return FvvError.warning("no-range", `${url} is read from front to back: ${why}`);
}

/** The bytes from 0 on, as they come. Several readers may wait for the same ones. */
class Beginning {
  #bodies = []; // in order, each with the promise of its next piece
  #abort;
  #pieces = [];
  length = 0;

  constructor(abort) {
    this.#abort = abort;
  }
  get signal() {
    return this.#abort.signal;
  }
  stop() {
    this.#abort.abort();
  }
  /** The bytes after those that are requested already. */
  extend(body) {
    this.#bodies.push(this.#next({ body }));
  }
  #next(one) {
    one.piece = one.body.next();
    // Who waits for it reports the error.
    one.piece.catch(() => {});
    return one;
  }
  /** Waits for that many bytes; false: fewer were requested. */
  async has(size) {
    while (this.length < size) {
      const [one] = this.#bodies;
      if (!one) return false;
      const { piece } = one;
      const { done, value } = await piece;
      if (one.piece !== piece) continue; // another reader has taken it
      if (done) {
        one.piece = null;
        this.#bodies.shift();
      } else {
        this.#next(one);
        this.#pieces.push(value);
        this.length += value.length;
      }
    }
    return true;
  }
  /** Bytes from an offset on that have come, up to end at most. */
  take(at, end) {
    let first = 0;
    for (const piece of this.#pieces) {
      if (at < first + piece.length) return piece.subarray(at - first, end - first);
      first += piece.length;
    }
    return new Uint8Array(0);
  }
  async front(size) {
    await this.has(size);
    return new Uint8Array(await new Blob(this.#pieces).arrayBuffer()).subarray(0, size);
  }
  /** All of it, once: pieces are not kept. */
  async *all() {
    while (this.#pieces.length || (await this.has(this.length + 1))) yield this.#pieces.shift();
  }
}

/** A host that supports Range. The first bytes are requested together with the last ones. */
class RangeSource {
  #url;
  #init;
  #etag;
  #suffix;
  #warn;
  #cache;
  #head; // Beginning; null: it is over
  #asked; // up to here
  #ignoresRange = false;
  roundTrip = 0; // seconds, the least; 0: not known

  /** head: {response, abort}, the promise of a response to a request for the first FRONT bytes. */
  constructor(url, init, size, headers, suffix, head, { warn, cache, requests }) {
    this.#url = url;
    this.#init = init;
    this.#etag = headers.get("etag");
    this.type = headers.get("content-type");
    this.requests = requests;
    this.#suffix = suffix;
    this.#warn = warn;
    this.#cache = cache;
    this.size = size;
    this.bytesRead = suffix.length;
    this.#asked = Math.min(FRONT, this.#suffixAt);
    this.#head = new Beginning(head.abort);
    if (this.#asked > 0) this.#head.extend(this.#answered(head.response, 0, this.#asked));
    else this.leave();
  }
  /** From a host that returns the whole file a range is requested only once. */
  get inRanges() {
    return !this.#ignoresRange;
  }
  /** From here on the bytes are in suffix. */
  get #suffixAt() {
    return this.size - this.#suffix.length;
  }
  async #fetch(from, end, signal) {
    this.requests++;
    const headers = { ...this.#init.headers, Range: `bytes=${from}-${end - 1}` };
    const began = performance.now();
    const response = await request(this.#url, { ...this.#init, ...AT_ONCE, headers, signal });
    this.roundTrip = Math.min(this.roundTrip || Infinity, (performance.now() - began) / 1000);
    return this.#checked(response, from);
  }
  async *#answered(response, from, end) {
    yield* this.#wanted(this.#checked(await response, from), from, end);
  }
  /** Throws unless these are bytes of the same file from there on, or all of it. */
  #checked(response, from) {
    if (response.status !== 206 && response.status !== 200) throw failed(this.#url, response);
    const etag = response.headers.get("etag");
    const range = /^bytes (\d+)-\d+\/(\d+|\*)$/.exec(response.headers.get("content-range") ?? "");
    const total = response.status === 200 ? null : range && range[2] !== "*" ? Number(range[2]) : this.size;
    if (etag !== this.#etag || (total !== null && total !== this.size))
      throw new FvvError({
        code: "changed",
        message: `${this.#url} changed while it was read: ETag ${this.#etag}, now ${etag}`,
      });
    if (range && response.status === 206 && Number(range[1]) !== from)
      throw new FvvError({
        code: "io",
        message: `${this.#url}: expected a range from byte ${from}, found ${range[1]}`,
      });
    return response;
  }
  /** The requested bytes, also from a response with the whole file, in case the host stops supporting Range. */
  async *#wanted(response, from, end) {
    let at = response.status === 206 ? from : 0;
    if (response.status === 200 && !this.#ignoresRange) {
      this.#ignoresRange = true;
      this.#warn(noRange(this.#url, "the server no longer supports Range"));
    }
    // Such a response has to be read up to the requested bytes: all of it goes to the cache.
    const cacheable = Math.min(this.#suffixAt, response.status === 206 ? end : Infinity);
    for await (const piece of bodyOf(response)) {
      this.bytesRead += piece.length;
      this.#cache.put(at, piece.subarray(0, Math.max(0, cacheable - at)));
      const part = piece.subarray(Math.max(0, from - at), Math.max(0, end - at));
      at += piece.length;
      if (part.length) yield part;
      if (at >= end) return;
    }
  }
  async *range(from, end, signal) {
    const head = this.#head;
    let at = from;
    if (head && from - head.length <= ROUND_TRIP_BYTES) {
      const stop = () => this.leave();
      signal?.addEventListener("abort", stop, { once: true });
      try {
        if (from <= this.#asked) this.#ask(end);
        while (at < end && (await head.has(at + 1))) {
          const piece = head.take(at, end);
          at += piece.length;
          yield piece;
        }
      } catch {
        // What is missing is requested again.
        this.leave();
      } finally {
        signal?.removeEventListener("abort", stop);
      }
    }
    yield* this.#pieces(at, end, signal);
  }
  async *#pieces(from, end, signal) {
    let reused = false;
    for (let at = from; at < end;) {
      // The beginning of the suffix can change meanwhile.
      const asked = Math.min(end, this.#suffixAt);
      const kept = at < asked ? this.#cache.take(at, asked) : this.#suffix.subarray(at - asked, end - asked);
      if (kept) {
        if (!reused && at < asked) this.#cache.hits++;
        at += kept.length;
        yield kept;
      } else {
        const until = this.#cache.missingUntil(at, asked, ROUND_TRIP_BYTES);
        for await (const piece of this.#wanted(await this.#fetch(at, until, signal), at, until)) {
          at += piece.length;
          yield piece;
        }
        if (at < until)
          throw new FvvError({ code: "io", message: `${this.#url}: the response ends ${until - at} bytes too early` });
      }
      reused = kept !== null;
    }
  }
  /** Asks for the bytes from the last that were requested up to end, if there are more. */
  #ask(end) {
    const until = Math.min(end, this.size);
    if (this.#asked >= until) return;
    this.#head.extend(this.#pieces(this.#asked, until, this.#head.signal));
    this.#asked = until;
  }
  async read(offset, size) {
    if (offset === 0 && !this.frugal && this.#head) {
      // Bytes that are missing come together with what follows them.
      if (this.#asked < size) this.#ask(this.size);
      return this.#head.front(size);
    }
    const pieces = [];
    for await (const piece of this.range(offset, offset + size)) pieces.push(piece);
    return new Uint8Array(await new Blob(pieces).arrayBuffer());
  }
  /**
   * Begins to fetch as many bytes more as come during a round trip, for parts that are requested after it. Returns how many
   * came, when they are there.
   */
  async lead() {
    const head = this.#head;
    if (!head) return 0;
    const from = this.#asked;
    this.#ask(from + ROUND_TRIP_BYTES);
    const end = this.#asked;
    return (await head.has(end)) ? end - from : 0;
  }
  /** Ends what began at byte 0. */
  leave() {
    this.#head?.stop();
    this.#head = null;
  }
  async *stream(from, signal) {
    const head = this.#head;
    if (from > 0 || !head) {
      this.leave();
      yield* this.#pieces(from, this.size, signal);
      return;
    }
    this.#ask(this.size);
    this.#head = null;
    signal?.addEventListener("abort", () => head.stop());
    yield* head.all();
  }

  divide(offsets) {
    this.#cache.divide(offsets);
  }
  kept(offset, out) {
    return this.#cache.copy(offset, out);
  }
  holds(from, end) {
    const asked = Math.min(end, this.#suffixAt);
    return this.#cache.coveredUntil(from, asked) >= asked;
  }
  forget(offset) {
    if (this.#cache.drop(offset) > this.#suffixAt) this.#suffix = new Uint8Array(0);
  }
  close() {
    this.leave();
    this.#cache.clear();
  }
}

/** A single response with the whole file. Its bytes can be read again as long as the cache has all of them. */
class ResponseSource {
  #abort;
  #cache;
  #body;
  #piece = null; // promise of the next piece, which outlives a seek
  #wake = null;
  front = 0;
  complete = false;
  bytesRead = 0;
  requests = 1;

  constructor(response, abort, { cache, rewinds }) {
    const { headers } = response;
    const size = headers.get("content-encoding") ? 0 : Number(headers.get("content-length"));
    this.type = headers.get("content-type");
    this.#abort = abort;
    this.#cache = cache;
    this.rewinds = rewinds && cache.limit > 0 && size <= cache.limit;
    this.#body = response.body.getReader();
  }

  async *stream(from, signal) {
    const stop = () => {
      if (!this.rewinds) this.#abort.abort();
      this.#wake?.();
    };
    signal?.addEventListener("abort", stop);
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
    this.#abort.abort();
    this.#cache.clear();
  }
}

/** warn(error). cache: for received bytes. seekable false: a single request, and nothing is kept. */
async function openUrl({ url, init = {}, seekable = true }, { warn, cache }) {
  const abort = new AbortController();
  const head = { abort: new AbortController() };
  const whole = async () => {
    head.abort.abort();
    const response = await request(url, { ...init, signal: abort.signal });
    if (!response.ok) throw failed(url, response);
    return new ResponseSource(response, abort, { cache, rewinds: seekable });
  };
  if (!seekable) return whole();
  const ask = (range, { signal }) =>
    request(url, { ...init, ...AT_ONCE, headers: { ...init.headers, Range: range }, signal });
  const suffixAsked = ask(`bytes=-${SUFFIX}`, abort);
  head.response = ask(`bytes=0-${FRONT - 1}`, head.abort);
  head.response.catch(() => {}); // if nothing is read of it
  let response = await suffixAsked;
  if (response.status === 416) return whole();
  if (!response.ok) throw failed(url, response);
  const cannot = (why) => warn(noRange(url, why));
  if (response.status !== 206) {
    head.abort.abort();
    cannot(`the server responds ${response.status} to a request for a range`);
    return new ResponseSource(response, abort, { cache, rewinds: true });
  }
  const rangeOf = ({ headers }) => /^bytes (\d+)-(\d+)\/(\d+)$/.exec(headers.get("content-range") ?? "");
  let range = rangeOf(response);
  // Hosts such as Vite's dev server take the last bytes for the first ones, and now the size is known.
  const begin = range ? Number(range[3]) - SUFFIX : 0;
  const misread = range && begin > 0 && Number(range[1]) === 0;
  if (misread) {
    response.body.cancel().catch(() => {});
    response = await ask(`bytes=${begin}-${range[3] - 1}`, abort);
    if (!response.ok) throw failed(url, response);
    range = response.status === 206 ? rangeOf(response) : null;
  }
  const encoding = response.headers.get("content-encoding");
  const suffix = new Uint8Array(await response.arrayBuffer());
  const [first, last, size] = range ? range.slice(1).map(Number) : [];
  const why = !range
    ? "the response has no readable Content-Range (cross-origin hosts have to expose it)"
    : encoding && encoding !== "identity"
      ? `the response has Content-Encoding ${encoding}`
      : last + 1 !== size || last - first + 1 !== suffix.length
        ? `Content-Range ${range[0]} does not match the ${suffix.length} bytes received`
        : null;
  if (why) {
    cannot(why);
    return whole();
  }
  return new RangeSource(url, init, size, response.headers, suffix, head, { warn, cache, requests: misread ? 3 : 2 });
}

/**
 * description can be sent to a worker: {bytes}, {blob}, {url, init, seekable}, {segments: {url, init}},
 * {live: {url, ...}}, or {pull: true} with a function pull. cache: for bytes of URLs, until the source is closed.
 * quality: as for the decoder.
 */
export async function openSource(description, { pull, warn, cache, quality }) {
  if (description.bytes) return new BufferSource(description.bytes);
  if (description.blob) return new BlobSource(description.blob);
  if (description.live) return Live.open(description.live, { warn, quality });
  if (description.segments) return Segments.open(description.segments, cache);
  if (description.url) return openUrl(description, { warn, cache });
  return new SequentialSource(pull);
}
