// Bytes of a source, kept for repeated reads. They are evicted in units, which are the groups of a stream: the least
// recently read unit first.

import { lastAtMost } from "../search.js";

/** Small pieces are joined in blocks of up to this size, so that many small pieces cost no more memory. */
const BLOCK = 1 << 16;

const startOf = ({ at }) => at;
const endOf = ({ at, size }) => at + size;

/** room: memory for bytes from `at` on, of which size are filled. */
function extentOf(at, piece, former) {
  if (piece.length >= BLOCK / 4 && piece.length === piece.buffer.byteLength)
    return { at, size: piece.length, room: piece };
  // Copied: a view would keep the bytes of other units alive.
  const room = new Uint8Array(Math.max(piece.length, former ? Math.min(BLOCK, 2 * former.room.length) : 0));
  room.set(piece);
  return { at, size: piece.length, room };
}

export class Cache {
  #limit;
  #borders = [];
  #units = new Map(); // number -> {extents in order, bytes}; the last one was used last
  /** Allocated memory, filled or not. */
  bytes = 0;
  /** Reads that were served without a request, and their bytes. */
  hits = 0;
  bytesReused = 0;

  /** limit(): the current limit in bytes. */
  constructor(limit) {
    this.#limit = limit;
  }

  /** borders: where units begin, in order. The bytes before the first border are a unit, too. */
  divide(borders) {
    const extents = Array.from(this.#units.values()).flatMap((unit) => unit.extents);
    this.clear();
    this.#borders = borders;
    for (const { at, room, size } of extents) this.put(at, room.subarray(0, size));
  }
  get limit() {
    return this.#limit();
  }
  #unitOf(at) {
    return lastAtMost(this.#borders, at);
  }

  /** Takes ownership of the bytes. Bytes that are in the cache already are not stored twice. */
  put(at, bytes) {
    if (!(this.#limit() > 0)) return;
    for (let from = at; from < at + bytes.length;) {
      const number = this.#unitOf(from);
      const end = Math.min(at + bytes.length, this.#borders[number + 1] ?? Infinity);
      this.#fill(this.#use(number), from, bytes.subarray(from - at, end - at));
      from = end;
    }
    this.evict();
  }
  #use(number) {
    const unit = this.#units.get(number) ?? { extents: [], bytes: 0 };
    this.#units.delete(number);
    this.#units.set(number, unit);
    return unit;
  }
  #fill(unit, at, bytes) {
    const end = at + bytes.length;
    for (let from = at; from < end;) {
      const i = lastAtMost(unit.extents, from, startOf);
      const stored = i < 0 ? from : endOf(unit.extents[i]);
      if (stored > from) {
        from = stored;
        continue;
      }
      const until = Math.min(end, unit.extents[i + 1]?.at ?? Infinity);
      this.#insert(unit, i, from, bytes.subarray(from - at, until - at));
      from = until;
    }
  }
  /** As a new extent after extent i, or in its free room. */
  #insert(unit, i, at, bytes) {
    const former = i >= 0 && endOf(unit.extents[i]) === at ? unit.extents[i] : null;
    const more = former ? Math.min(former.room.length - former.size, bytes.length) : 0;
    if (more > 0) {
      former.room.set(bytes.subarray(0, more), former.size);
      former.size += more;
    }
    if (more === bytes.length) return;
    const extent = extentOf(at + more, bytes.subarray(more), former);
    unit.extents.splice(i + 1, 0, extent);
    unit.bytes += extent.room.length;
    this.bytes += extent.room.length;
  }

  /** Evicts units until the limit holds. */
  evict() {
    const limit = this.#limit();
    for (const number of this.#units.keys()) {
      if (this.bytes <= limit) return;
      this.#remove(number);
    }
  }
  #remove(number) {
    this.bytes -= this.#units.get(number)?.bytes ?? 0;
    this.#units.delete(number);
  }
  /** Removes the unit of a byte. Returns where the unit ends. */
  drop(at) {
    const number = this.#unitOf(at);
    this.#remove(number);
    return this.#borders[number + 1] ?? Infinity;
  }
  clear() {
    this.#units.clear();
    this.bytes = 0;
  }

  #find(at) {
    const { extents } = this.#units.get(this.#unitOf(at)) ?? { extents: [] };
    const extent = extents[lastAtMost(extents, at, startOf)];
    return extent && endOf(extent) > at ? extent : undefined;
  }
  /** The contiguous bytes from an offset on, up to end at most; null: that byte is not here. Read-only. */
  take(at, end) {
    const extent = this.#find(at);
    if (!extent) return null;
    this.#use(this.#unitOf(at));
    const bytes = extent.room.subarray(at - extent.at, Math.min(extent.size, end - extent.at));
    this.bytesReused += bytes.length;
    return bytes;
  }
  /** The offset up to which all bytes from `at` on are here, end at most. */
  coveredUntil(at, end) {
    while (at < end) {
      const extent = this.#find(at);
      if (!extent) break;
      at = endOf(extent);
    }
    return Math.min(at, end);
  }
  /** The end of a gap at `at`: where at least `minimum` contiguous bytes follow, or all bytes up to end. */
  missingUntil(at, end, minimum) {
    for (;;) {
      const from = this.#next(at);
      if (from >= end) return end;
      at = this.coveredUntil(from, end);
      if (at - from >= minimum || at === end) return from;
    }
  }
  #next(at) {
    let next = Infinity;
    for (const { extents } of this.#units.values()) {
      const extent = extents.find((one) => endOf(one) > at);
      if (extent) next = Math.min(next, Math.max(at, extent.at));
    }
    return next;
  }

  /** Copies bytes to out; false: not all of them are here. */
  copy(at, out) {
    const end = at + out.length;
    if (this.coveredUntil(at, end) < end) return false;
    for (let from = at; from < end;) {
      const extent = this.#find(from);
      const bytes = extent.room.subarray(from - extent.at, Math.min(extent.size, end - extent.at));
      out.set(bytes, from - at);
      from += bytes.length;
    }
    return true;
  }
}
