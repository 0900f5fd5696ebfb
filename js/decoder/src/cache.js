// Bytes of a source that have come, for when they are read again. They are kept, and leave, by units, which are the
// groups of a stream: those that were read least recently leave first.

/** Small pieces are put together in blocks of up to this size: a host that sends many of them costs no more memory. */
const BLOCK = 1 << 16;

const endOf = ({ at, size }) => at + size;

/** room: where bytes from `at` on stand, size of them so far. */
function extentOf(at, piece, former) {
  if (piece.length >= BLOCK / 4 && piece.length === piece.buffer.byteLength)
    return { at, size: piece.length, room: piece };
  // Not a view of what came together with other units: that would stay with this one.
  const room = new Uint8Array(Math.max(piece.length, former ? Math.min(BLOCK, 2 * former.room.length) : 0));
  room.set(piece);
  return { at, size: piece.length, room };
}

export class Cache {
  #most;
  #borders = [];
  #units = new Map(); // number -> {extents in order, bytes}; the one that was used last stands at the end
  /** Memory that is taken, not only what is in it. */
  bytes = 0;
  /** Reads that it answered in place of a request, and their bytes. */
  hits = 0;
  bytesReused = 0;

  /** most(): bytes that it may take at the moment. */
  constructor(most) {
    this.#most = most;
  }

  /** borders: where units begin, in order. What stands in front of the first one is a unit, too. */
  divide(borders) {
    const extents = Array.from(this.#units.values()).flatMap((unit) => unit.extents);
    this.clear();
    this.#borders = borders;
    for (const { at, room, size } of extents) this.put(at, room.subarray(0, size));
  }
  get most() {
    return this.#most();
  }
  #unitOf(at) {
    return this.#borders.findLastIndex((border) => border <= at);
  }

  /** The bytes belong to the cache from now on. What it has already is not taken twice. */
  put(at, bytes) {
    if (!(this.#most() > 0)) return;
    for (let from = at; from < at + bytes.length;) {
      const number = this.#unitOf(from);
      const end = Math.min(at + bytes.length, this.#borders[number + 1] ?? Infinity);
      this.#fill(this.#use(number), from, bytes.subarray(from - at, end - at));
      from = end;
    }
    this.fit();
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
      const i = unit.extents.findLastIndex((extent) => extent.at <= from);
      const held = i < 0 ? from : endOf(unit.extents[i]);
      if (held > from) {
        from = held;
        continue;
      }
      const until = Math.min(end, unit.extents[i + 1]?.at ?? Infinity);
      this.#insert(unit, i, from, bytes.subarray(from - at, until - at));
      from = until;
    }
  }
  /** Behind extent i, or at its end. */
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

  /** Lets units go until what is left may stay. */
  fit() {
    const most = this.#most();
    for (const number of this.#units.keys()) {
      if (this.bytes <= most) return;
      this.#remove(number);
    }
  }
  #remove(number) {
    this.bytes -= this.#units.get(number)?.bytes ?? 0;
    this.#units.delete(number);
  }
  /** Lets the unit of a byte go. Answers where it ends. */
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
    return this.#units.get(this.#unitOf(at))?.extents.findLast((one) => one.at <= at && endOf(one) > at);
  }
  /** What stands together from a place on, no further than end; null: that byte is not here. To be read only. */
  take(at, end) {
    const extent = this.#find(at);
    if (!extent) return null;
    this.#use(this.#unitOf(at));
    const bytes = extent.room.subarray(at - extent.at, Math.min(extent.size, end - extent.at));
    this.bytesReused += bytes.length;
    return bytes;
  }
  /** How far from a place on all bytes are here, no further than end. */
  reach(at, end) {
    while (at < end) {
      const extent = this.#find(at);
      if (!extent) break;
      at = endOf(extent);
    }
    return Math.min(at, end);
  }
  /** What is lacking from a place on ends where at least so many bytes stand together again, or all up to end. */
  lack(at, end, least) {
    for (;;) {
      const from = this.#next(at);
      if (from >= end) return end;
      at = this.reach(from, end);
      if (at - from >= least || at === end) return from;
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

  /** Copies bytes that are all here to out; false: they are not. */
  copy(at, out) {
    const end = at + out.length;
    if (this.reach(at, end) < end) return false;
    for (let from = at; from < end;) {
      const extent = this.#find(from);
      const bytes = extent.room.subarray(from - extent.at, Math.min(extent.size, end - extent.at));
      out.set(bytes, from - at);
      from += bytes.length;
    }
    return true;
  }
}
