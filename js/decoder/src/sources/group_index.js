// The groups of a source: where their frames are, and which times can be played without the network.

import { unlessAborted } from "../abort.js";
import { FvvError } from "../errors.js";
import { lastAtMost } from "../search.js";

/** Limits for finding the index; a file that needs more reads or bytes is read from front to back. */
const READS_MAX = 64;
const BYTES_MAX = 2 ** 28;
const READ_MIN = 1 << 14;

/** The index that the core reads, or rebuilds from the bytes that are available. */
export class GroupIndex {
  #source;
  #available;
  #readsAnywhere;
  #reads = []; // {at, bytes} fetched for the index
  #missing = null;
  #bySequence = null; // sequence number -> group, the first of those that have it
  /** Of a single response: the bytes that the index was made from. */
  front = null;
  /** null: not known. Of a single response: the groups that have arrived. */
  groups = null;
  frameCount;
  /** Set by its owner. */
  session = null;

  /** available: iterates over further {at, bytes} that have been fetched. readsAnywhere: whether source is a RangeSource. */
  constructor(source, { available = [], readsAnywhere = false } = {}) {
    this.#source = source;
    this.#available = available;
    this.#readsAnywhere = readsAnywhere;
  }

  /** Serves a read of the core from available bytes; returns false and notes the read if it cannot. */
  readInto(offset, out) {
    for (const { at, bytes } of [...this.#reads, ...this.#available])
      if (offset >= at && offset + out.length <= at + bytes.length) {
        out.set(bytes.subarray(offset - at, offset - at + out.length));
        return true;
      }
    if (this.#source.kept(offset, out)) return true;
    this.#missing = { offset, size: out.length };
    return false;
  }

  /** Calls step, and fetches what it lacks, until it succeeds; false: the limits are reached. */
  async satisfied(step, signal) {
    let total = 0;
    for (let reads = 0; !step(); reads++) {
      const { offset, size } = this.#missing;
      total += size;
      if (reads >= READS_MAX || total > BYTES_MAX || !this.#readsAnywhere) return false;
      const wanted = Math.min(Math.max(size, this.#restOfBlock(offset) ?? READ_MIN), this.#source.size - offset);
      const bytes = await unlessAborted(this.#source.read(offset, wanted, signal), signal);
      if (bytes.length < size) throw new FvvError({ code: "io", message: `${size} bytes at ${offset} can't be read` });
      this.#reads.push({ at: offset, bytes });
    }
    return true;
  }
  /** From offset to the end of the configuration block that it lies in; undefined: in none. */
  #restOfBlock(offset) {
    const { groups } = this;
    const last = lastAtMost(groups ?? [], offset, (group) => group.configurationOffset);
    const { configurationOffset, configurationSize } = groups?.[last] ?? {};
    const rest = configurationOffset + configurationSize - offset;
    return rest > 0 ? rest : undefined;
  }
  /** The result of look, or null; bytes that look lacks are fetched first. */
  async find(look, signal) {
    let found;
    const step = () => {
      this.#missing = null;
      found = look();
      return found || !this.#missing;
    };
    return (await this.satisfied(step, signal)) ? found : null;
  }
  /** Bytes that were read already. */
  keep(at, bytes) {
    this.#reads.push({ at, bytes });
  }
  /** Number of reads; forgetReads(count) drops those after the first count. */
  get reads() {
    return this.#reads.length;
  }
  forgetReads(count) {
    this.#reads.length = count;
  }

  /** Returns a description of what is wrong with the index, or null. */
  async open() {
    const source = this.#source;
    const { session } = this;
    if (source.groups) this.#number(source.groups);
    if (!this.#readsAnywhere) return null;
    if (source.bytes) this.#reads.push({ at: 0, bytes: source.bytes });
    if (!(await this.satisfied(() => session.open(source.size))))
      return "no index was found: the file is read from front to back";
    this.#number(session.groups());
    return session.indexState === 2 ? "the index is missing or damaged: it was rebuilt from all bytes" : null;
  }

  /** Of a single response: the groups that have arrived, which can all be read again. Nothing is played meanwhile. */
  openKept() {
    const source = this.#source;
    const { session } = this;
    if (this.front === source.front) return;
    try {
      if (!session.open(source.front))
        throw new FvvError({ code: "io", message: "bytes that have been played are no longer kept" });
      this.#number(session.groups());
    } catch (error) {
      if (!["damaged", "invalid", "truncated"].includes(error.code)) throw error;
      // Too few bytes have arrived.
      this.#number([]);
    }
    this.front = source.front;
  }

  #number(groups) {
    this.groups = groups;
    this.#bySequence = null;
    let first = 0;
    for (const group of groups) {
      group.firstFrame = first;
      first += group.frameCount;
    }
    this.frameCount = first;
    this.#source.divide(groups.map(({ offset }) => offset));
  }

  /** The group that begins at an offset; -1: none. */
  at(offset) {
    const i = lastAtMost(this.groups ?? [], offset, (group) => group.offset);
    return this.groups?.[i]?.offset === offset ? i : -1;
  }
  /** The group with a sequence number; -1: none. */
  numbered(sequence) {
    const groups = this.groups ?? [];
    this.#bySequence ??= new Map(groups.map((group, i) => [group.sequence, i]).reverse());
    return this.#bySequence.get(sequence) ?? -1;
  }

  /** For {frame}: its group, and skip, the number of frames before it in the group. For {time} in ticks: the group, and
   * until, the time that the wanted frame is not later than. */
  locate({ frame, time }) {
    const { groups } = this;
    const holds = (group) =>
      group.frameCount && (frame === undefined ? group.start <= time : group.firstFrame <= frame);
    let i = groups.findLastIndex(holds);
    if (i < 0)
      i = Math.max(
        0,
        groups.findIndex((group) => group.frameCount),
      );
    return frame === undefined ? { group: i, until: time } : { group: i, skip: frame - (groups[i]?.firstFrame ?? 0) };
  }
}
