// Parts of a file that are fetched on their own: which ones, and what has come of each.

import { ROUND_TRIP_BYTES } from "./url.js";

/** Requests under way at the same time; browsers have six of them with HTTP/1.1, whatever is asked for. */
const AHEAD = 6;
/** Chunks that are no farther apart are fetched together: requests that are under way together share their round trip. */
const NEAR = Math.floor(ROUND_TRIP_BYTES / AHEAD);
/** Bytes that are asked for and have not come, before another request is made: they delay what comes first. */
const WINDOW_FIRST = ROUND_TRIP_BYTES;
const WINDOW = 2 * ROUND_TRIP_BYTES;
/** Bytes from one group to the next, with a configuration between, that are fetched with what stands around them. */
const BETWEEN = 1 << 16;
/** GRUP with its header. */
const GROUP_SIZE = 56;
/** Room for what has come grows from here, whatever size is announced. */
const ROOM = 1 << 16;

/** ranges: [{from, end}] in order. The fewest that hold them all and bridge no larger gap than NEAR. */
function joinRanges(ranges) {
  const joined = [];
  for (const { from, end } of ranges) {
    const last = joined.at(-1);
    if (last && from - last.end <= NEAR) last.end = end;
    else joined.push({ from, end });
  }
  return joined;
}

/** Bytes at .. end - 1 of a source, as they come. */
class Part {
  #room;
  #filled = 0;
  #over = false;
  #error = null;
  #waiting = null;

  constructor(source, { from, end }, signal) {
    Object.assign(this, { at: from, end });
    this.#room = new Uint8Array(Math.min(end - from, ROOM));
    this.#fetch(source.part(from, end, signal));
  }
  get bytes() {
    return this.#room.subarray(0, this.#filled);
  }
  /** Bytes that have not come. */
  get lacking() {
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

  /** Waits for more than size bytes, or for the last ones; false: there are no more. Throws what ended fetching. */
  async more(size) {
    while (this.#filled <= size && !this.#over) await new Promise((resolve) => (this.#waiting = resolve));
    if (this.#error) throw this.#error;
    return this.#filled > size;
  }
  async all() {
    while (await this.more(this.#filled));
  }
}

/** What is fetched of one group at a time, and of the next one's table. Iterates over {at, bytes} that have come. */
export class Parts {
  #source;
  #tables = new Map(); // group -> Part: its GEND, and with it the GRUP of the next group when that is near
  #ranges = new Set();
  constructor(source) {
    this.#source = source;
  }
  *[Symbol.iterator]() {
    yield* this.#tables.values();
    yield* this.#ranges;
  }
  clear() {
    this.#tables.clear();
    this.#ranges.clear();
  }

  /** GRUP and GEND of group i. */
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
    if (!this.#tables.has(i)) this.#tables.set(i, new Part(this.#source, range, signal));
    return this.#tables.get(i);
  }

  /** Fetches GRUP and GEND of group i; those of the next one are on their way then. */
  async prepare(groups, i, signal) {
    this.#ranges.clear();
    for (const known of this.#tables.keys()) if (known < i - 1 || known > i) this.#tables.delete(known);
    const needed = [this.#table(groups, i, signal)];
    const [opening] = this.tableOf(groups, i);
    if (!(this.#tables.get(i - 1)?.end >= opening.end)) {
      needed.push(new Part(this.#source, opening, signal));
      this.#ranges.add(needed.at(-1));
    }
    await Promise.all(needed.map((part) => part.all()));
    if (i + 1 < groups.length) this.#table(groups, i + 1, signal);
  }

  /** Fetches ranges, and yields each time that more of them is there in their order. */
  async *fetch(ranges, signal) {
    const wanted = joinRanges(ranges);
    const parts = [];
    for (let i = 0; i < wanted.length; i++) {
      this.#ask(wanted, parts, i, signal);
      for (let size = 0; await parts[i].more(size);) {
        // Before what is there is made use of: more may come meanwhile.
        size = parts[i].bytes.length;
        this.#ask(wanted, parts, i, signal);
        yield;
      }
      this.#ranges.delete(parts[i]);
    }
  }
  /** Begins to fetch part i of those that are wanted, and as many behind it as the window lets through. */
  #ask(wanted, parts, i, signal) {
    const window = i === 0 ? WINDOW_FIRST : WINDOW;
    let lacking = parts.slice(i).reduce((sum, part) => sum + part.lacking, 0);
    while (parts.length < Math.min(wanted.length, i + AHEAD) && (parts.length === i || lacking < window)) {
      const part = new Part(this.#source, wanted[parts.length], signal);
      lacking += part.lacking;
      parts.push(part);
      this.#ranges.add(part);
    }
  }
}
