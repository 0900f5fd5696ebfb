// Groups of a source and where frames stand in them, by the index that the core reads, or makes of what is there.

import { FvvError } from "./errors.js";

/** So many reads and bytes to find the index; a file that needs more is read from front to back. */
const READS = 64;
const BYTES = 2 ** 26;
const READ_LEAST = 1 << 14;

export class GroupIndex {
  #reads = []; // {at, bytes} that were fetched for it
  #missing = null;
  /** Bytes of one answer that it was made of. */
  front = null;
  /** null: the source does not tell. Of one answer: those that have gone by. */
  groups = null;
  frameCount;

  /** parts: iterates over {at, bytes} that are there besides. */
  constructor(source, parts) {
    Object.assign(this, { source, parts, session: null });
  }

  /** What the core reads, out of what is there; else what is missing is noted. */
  answer(offset, out) {
    for (const { at, bytes } of [...this.#reads, ...this.parts])
      if (offset >= at && offset + out.length <= at + bytes.length) {
        out.set(bytes.subarray(offset - at, offset - at + out.length));
        return true;
      }
    if (this.source.kept?.(offset, out)) return true;
    this.#missing = { offset, size: out.length };
    return false;
  }

  /** Calls step until it has what it reads; false: that would be too much. */
  async satisfied(step) {
    let total = 0;
    for (let reads = 0; !step(); reads++) {
      const { offset, size } = this.#missing;
      total += size;
      if (reads >= READS || total > BYTES || !this.source.read) return false;
      const wanted = Math.min(Math.max(size, READ_LEAST), this.source.size - offset);
      const bytes = await this.source.read(offset, wanted);
      if (bytes.length < size) throw new FvvError({ code: "io", message: `${size} bytes at ${offset} can't be read` });
      this.#reads.push({ at: offset, bytes });
    }
    return true;
  }
  /** What look finds, or null. What is not there may only not have been read. */
  async find(look) {
    let found;
    const step = () => {
      this.#missing = null;
      found = look();
      return found || !this.#missing;
    };
    return (await this.satisfied(step)) ? found : null;
  }
  /** Number of reads; forgetReads lets go what came behind that. */
  get reads() {
    return this.#reads.length;
  }
  forgetReads(count) {
    this.#reads.length = count;
  }

  /** Answers what is wrong with the index, or null. */
  async open() {
    const { source, session } = this;
    if (source.groups) this.#number(source.groups);
    if (source.size === undefined) return null;
    if (source.bytes) this.#reads.push({ at: 0, bytes: source.bytes });
    if (!(await this.satisfied(() => session.open(source.size))))
      return "there is no index: the file is read from front to back";
    this.#number(session.groups());
    return session.indexState === 2 ? "there is no good index: it was rebuilt from all bytes" : null;
  }

  /** Of one answer: the groups that have gone by, which can all be read again. The session plays nothing meanwhile. */
  openKept() {
    const { source, session } = this;
    if (this.front === source.front) return;
    try {
      if (!session.open(source.front)) throw new FvvError({ code: "io", message: "what has gone by is not kept any more" }); // prettier-ignore
      this.#number(session.groups());
    } catch (error) {
      if (!["damaged", "invalid", "truncated"].includes(error.code)) throw error;
      // Too little has come.
      this.#number([]);
    }
    this.front = source.front;
  }

  #number(groups) {
    this.groups = groups;
    let first = 0;
    for (const group of groups) {
      group.firstFrame = first;
      first += group.frameCount;
    }
    this.frameCount = first;
    this.source.divide?.(groups.map(({ offset }) => offset));
  }

  /** Group and the frames in it to pass over, skip, for {frame}; for {time} (ticks) the frame that is shown then: the
   * last one that is not later than until. */
  locate({ frame, time }) {
    const { groups } = this;
    const holds = (group) =>
      group.frameCount && (frame === undefined ? group.start <= time : group.firstFrame <= frame);
    let i = groups.findLastIndex(holds);
    if (i < 0) i = Math.max(0, groups.findIndex((group) => group.frameCount)); // prettier-ignore
    return frame === undefined ? { group: i, until: time } : { group: i, skip: frame - (groups[i]?.firstFrame ?? 0) };
  }
}
