// A file on a host that supports Range, and its first bytes, which are requested together with the last ones.

import { onAbort, unlessAborted } from "../abort.js";
import { FvvError } from "../errors.js";
import { joined } from "../joined.js";
import { asTransient, failed, isTransient, ROUND_TRIP_BYTES, sameVersion, versionOf } from "./network.js";
import { RangeSource } from "./types.js";

/** First bytes: enough for the configuration of fifty cameras. */
export const FRONT = 1 << 14;

export function noRange(url, why) {
  return FvvError.warning("no-range", `${url} is read from front to back: ${why}`);
}

/** A browser that uses its cache handles requests for one URL one at a time, each with its own round trip. */
export function askForRange(network, url, range, { signal, outage } = {}) {
  return network.request(url, { cache: "no-store", headers: { Range: range }, signal, outage });
}

/** The last bytes of a stream: FOOT with its header, which has the digest of the index. */
const FOOTER = 56;
/** ETags that are remembered as those of one file. */
const KNOWN_MAX = 64;

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
    return joined(this.#pieces).subarray(0, size);
  }
  /** All of it, once: pieces are not kept. */
  async *all() {
    while (this.#pieces.length || (await this.has(this.length + 1))) yield this.#pieces.shift();
  }
}

/** A host that supports Range. The first bytes are requested together with the last ones. */
export class HostSource extends RangeSource {
  #url;
  #network;
  #versions; // headers that name the version of the file, as different nodes send them
  #proof = null; // promise of whether the host still has this file, while its footer is fetched
  #suffix;
  #warn;
  #cache;
  #head; // Beginning; null: it is over
  #asked; // up to here
  #ignoresRange = false;

  /** head: {reply, abort}, the promise of a reply to a request for the first FRONT bytes. suffix: the last bytes. */
  constructor(url, { network, size, headers, suffix, head, warn, cache }) {
    super();
    this.#url = url;
    this.#network = network;
    this.#versions = [versionOf(headers)];
    this.type = headers.get("content-type");
    this.#suffix = suffix;
    this.#warn = warn;
    this.#cache = cache;
    this.size = size;
    this.#asked = Math.min(FRONT, this.#suffixAt);
    this.#head = new Beginning(head.abort);
    if (this.#asked > 0) this.#head.extend(this.#answered(head.reply, 0, this.#asked));
    else this.leave();
  }
  /** From a host that returns the whole file a range is requested only once. */
  get selective() {
    return !this.#ignoresRange;
  }
  get requests() {
    return this.#network.requests;
  }
  get bytesRead() {
    return this.#network.bytesRead;
  }
  /** From here on the bytes are in suffix. */
  get #suffixAt() {
    return this.size - this.#suffix.length;
  }
  async #fetch(from, end, how) {
    const began = performance.now();
    const reply = await askForRange(this.#network, this.#url, `bytes=${from}-${end - 1}`, how);
    this.roundTrip = Math.min(this.roundTrip || Infinity, (performance.now() - began) / 1000);
    return await this.#checked(reply, from);
  }
  async *#answered(reply, from, end) {
    let at = from;
    try {
      for await (const piece of this.#wanted(await this.#checked(await reply, from), from, end)) {
        at += piece.length;
        yield piece;
      }
    } catch (error) {
      if (!isTransient(error)) throw error;
    }
    // A response may be shorter than the range, or break off.
    yield* this.#pieces(at, end, this.#head?.signal);
  }
  /** As #check; the body of what is refused is dropped. */
  async #checked(reply, from) {
    try {
      return await this.#check(reply, from);
    } catch (error) {
      reply.drop();
      throw error;
    }
  }
  /** Whether the host has the same footer, and so the same index and groups, under another ETag. */
  async #isSameFile() {
    if (this.#suffix.length < FOOTER) return false;
    const known = this.#suffix.subarray(-FOOTER);
    const reply = await askForRange(this.#network, this.#url, `bytes=${this.size - FOOTER}-${this.size - 1}`);
    const range = /^bytes (\d+)-\d+\/(\d+)$/.exec(reply.headers.get("content-range") ?? "");
    if (reply.status !== 206 || Number(range?.[1]) !== this.size - FOOTER || Number(range?.[2]) !== this.size) {
      reply.drop();
      return false;
    }
    const found = await reply.bytes();
    return found.length === FOOTER && found.every((byte, i) => byte === known[i]);
  }
  async #isKnown(version) {
    if (this.#versions.some((known) => sameVersion(version, known))) return true;
    this.#proof ??= this.#isSameFile().finally(() => (this.#proof = null));
    if (!(await this.#proof)) return false;
    if (this.#versions.length < KNOWN_MAX) this.#versions.push(version);
    return true;
  }
  /** Throws unless these are bytes of the same file from there on, or all of it. */
  async #check(reply, from) {
    if (reply.status === 416)
      throw new FvvError({ code: "changed", message: `${this.#url} changed while it was read: it is shorter now` });
    if (reply.status !== 206 && reply.status !== 200) throw failed(this.#url, reply);
    const encoding = reply.headers.get("content-encoding");
    if (reply.status === 206 && encoding && encoding !== "identity")
      throw new FvvError({
        code: "io",
        message: `${this.#url}: expected bytes of the file, found a range with Content-Encoding ${encoding}: switch compression off for this type`,
      });
    const version = versionOf(reply.headers);
    const range = /^bytes (\d+)-\d+\/(\d+|\*)$/.exec(reply.headers.get("content-range") ?? "");
    const total = reply.status === 200 ? null : range && range[2] !== "*" ? Number(range[2]) : this.size;
    if ((total !== null && total !== this.size) || !(await this.#isKnown(version)))
      throw new FvvError({
        code: "changed",
        message: `${this.#url} changed while it was read: ETag ${this.#versions[0].etag}, now ${version.etag}`,
      });
    if (range && reply.status === 206 && Number(range[1]) !== from)
      throw new FvvError({
        code: "io",
        message: `${this.#url}: expected a range from byte ${from}, found ${range[1]}`,
      });
    return reply;
  }
  /** The requested bytes, also from a response with the whole file, in case the host stops supporting Range. */
  async *#wanted(reply, from, end) {
    let at = reply.status === 206 ? from : 0;
    if (reply.status === 200 && !this.#ignoresRange) {
      this.#ignoresRange = true;
      this.#warn(noRange(this.#url, "the server no longer supports Range"));
    }
    // Such a response has to be read up to the requested bytes: all of it goes to the cache.
    const cacheable = Math.min(this.#suffixAt, reply.status === 206 ? end : Infinity);
    for await (const piece of reply.pieces()) {
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
      const unregister = onAbort(signal, () => this.leave());
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
        unregister();
      }
    }
    yield* this.#pieces(at, end, signal);
  }
  async *#pieces(from, end, signal) {
    let reused = false;
    const outage = this.#network.outage(this.#url, signal);
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
        const first = at;
        try {
          for await (const piece of this.#wanted(await this.#fetch(at, until, { signal, outage }), at, until)) {
            at += piece.length;
            outage.progress();
            yield piece;
          }
        } catch (error) {
          await outage.wait(error);
          continue;
        }
        // A host may send less than the range, but something.
        if (at === first)
          await outage.wait(
            asTransient(
              new FvvError({ code: "io", message: `${this.#url}: the response has no bytes of ${until - at}` }),
            ),
          );
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
  async read(offset, size, signal) {
    if (offset === 0 && !this.frugal && this.#head) {
      // Bytes that are missing come together with what follows them.
      if (this.#asked < size) this.#ask(this.size);
      return unlessAborted(this.#head.front(size), signal);
    }
    const pieces = [];
    for await (const piece of this.range(offset, offset + size, signal)) pieces.push(piece);
    return joined(pieces);
  }
  /**
   * Begins to fetch as many bytes more as come during a round trip, for ranges that are requested after it. Returns how many
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
    const unregister = onAbort(signal, () => head.stop());
    try {
      yield* head.all();
    } finally {
      unregister();
      head.stop();
    }
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
    this.#network.close();
    this.#cache.clear();
  }
}
