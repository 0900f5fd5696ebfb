// ByteRanges of a file that are fetched separately: which ones, and the bytes of each that have arrived.

import { GROUP_SIZE } from "../chunks.js";
import { CONCURRENT, ROUND_TRIP_BYTES } from "./network.js";

/** Chunks that are no farther apart are fetched together. Concurrent requests share a round trip. */
const NEAR = Math.floor(ROUND_TRIP_BYTES / CONCURRENT);
/** Outstanding bytes at which no further request is made: they would delay the bytes that are needed first. */
const WINDOW_FIRST = ROUND_TRIP_BYTES;
const WINDOW = 2 * ROUND_TRIP_BYTES;
/** A gap between two groups (a configuration block) up to this size is fetched with its neighbours. */
const BETWEEN = 1 << 16;
/** First size of a buffer, whatever size is announced. */
const ROOM = 1 << 16;

/** ranges: [{from, end}] in order. Returns the fewest ranges that cover them and bridge no gap larger than NEAR. */
function joinRanges(ranges) {
  const joined = [];
  for (const { from, end } of ranges) {
    const last = joined.at(-1);
    if (last && from - last.end <= NEAR) last.end = end;
    else joined.push({ from, end });
  }
  return joined;
}

/** The bytes from .. end - 1 of a source, as they arrive. */
class ByteRange {
  #room;
  #filled = 0;
  #over = false;
  #error = null;
  #waiting = null;

  constructor(source, { from, end }, signal) {
    Object.assign(this, { at: from, end });
    this.#room = new Uint8Array(Math.min(end - from, ROOM));
    this.#fetch(source.range(from, end, signal));
  }
  get bytes() {
    return this.#room.subarray(0, this.#filled);
  }
  /** The number of bytes that have not arrived. */
  get outstanding() {
    return this.#over ? 0 : this.end - this.at - this.#filled;
  }

  async #fetch(pieces) {
    try {
      for await (const piece of pieces) this.#put(piece);
    } catch (error) {
      this.#error = error;
    }
    this.#over = true;
    this.#waiting?.();
  }
  #put(piece) {
    const size = this.#filled + piece.length;
    if (size > this.#room.length) {
      const room = new Uint8Array(Math.max(size, 2 * this.#room.length));
      room.set(this.bytes);
      this.#room = room;
    }
    this.#room.set(piece, this.#filled);
    this.#filled = size;
    this.#waiting?.();
  }

  /** Waits for more than size bytes or the end; false: no more bytes follow. Throws the error that ended fetching. */
  async more(size) {
    while (this.#filled <= size && !this.#over) await new Promise((resolve) => (this.#waiting = resolve));
    if (this.#error) throw this.#error;
    return this.#filled > size;
  }
  async all() {
    while (await this.more(this.#filled));
  }
}

/** The ranges of the current group, and the table of the next one. Iterates over {at, bytes} that have arrived. */
export class ByteRanges {
  #source;
  #tables = new Map(); // group -> ByteRange: its GEND, and the GRUP of the next group if that is near
  #ranges = new Set();
  #keeps;
  /** keeps: bytes stay until clear, and not only until they were yielded. */
  constructor(source, { keeps = false } = {}) {
    this.#source = source;
    this.#keeps = keeps;
  }
  *[Symbol.iterator]() {
    yield* this.#tables.values();
    yield* this.#ranges;
  }
  clear() {
    this.#tables.clear();
    this.#ranges.clear();
  }

  /** The ranges of GRUP and GEND of group i. */
  tableOf(groups, i) {
    const { offset, size, endSize } = groups[i];
    return [
      { from: offset, end: offset + GROUP_SIZE },
      { from: offset + size - endSize, end: offset + size },
    ];
  }
  #table(groups, i, signal) {
    const [, { from, end }] = this.tableOf(groups, i);
    const next = groups[i + 1]?.offset ?? Infinity;
    const range = { from, end: next - end < BETWEEN ? next + GROUP_SIZE : end };
    if (!this.#tables.has(i)) this.#tables.set(i, new ByteRange(this.#source, range, signal));
    return this.#tables.get(i);
  }

  /** What others has fetched is there, too. */
  adopt(others) {
    for (const range of others) this.#ranges.add(range);
  }

  /** Fetches GRUP and GEND of group i, and begins to fetch those of the next group, unless that one is wanted alone. */
  async prepare(groups, i, signal, { alone = false } = {}) {
    this.#ranges.clear();
    for (const known of this.#tables.keys()) if (known < i - 1 || known > i) this.#tables.delete(known);
    const needed = [this.#table(groups, i, signal)];
    const [opening] = this.tableOf(groups, i);
    if (!(this.#tables.get(i - 1)?.end >= opening.end)) {
      needed.push(new ByteRange(this.#source, opening, signal));
      this.#ranges.add(needed.at(-1));
    }
    await Promise.all(needed.map((range) => range.all()));
    if (!alone && i + 1 < groups.length) this.#table(groups, i + 1, signal);
  }

  /** Fetches ranges, and yields how many more bytes have arrived in order. */
  async *fetch(ranges, signal) {
    const wanted = joinRanges(ranges);
    const requested = [];
    for (let i = 0; i < wanted.length; i++) {
      this.#ask(wanted, requested, i, signal);
      for (let size = 0; await requested[i].more(size);) {
        // Before the caller uses the bytes: more may arrive meanwhile.
        const former = size;
        size = requested[i].bytes.length;
        this.#ask(wanted, requested, i, signal);
        yield size - former;
      }
      if (!this.#keeps) this.#ranges.delete(requested[i]);
    }
  }
  /** Begins to fetch range i, and as many after it as the window allows. */
  #ask(wanted, requested, i, signal) {
    const window = i === 0 ? WINDOW_FIRST : WINDOW;
    let outstanding = requested.slice(i).reduce((sum, range) => sum + range.outstanding, 0);
    while (
      requested.length < Math.min(wanted.length, i + CONCURRENT) &&
      (requested.length === i || outstanding < window)
    ) {
      const range = new ByteRange(this.#source, wanted[requested.length], signal);
      outstanding += range.outstanding;
      requested.push(range);
      this.#ranges.add(range);
    }
  }
}
