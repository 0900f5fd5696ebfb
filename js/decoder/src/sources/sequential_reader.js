// The groups of a SequentialSource: those that have arrived are its index, and can be sought in while all bytes are kept.

import { GroupReader } from "./group_reader.js";

export class SequentialReader extends GroupReader {
  #span = null; // {start, end} of the frames that have arrived

  get about() {
    const { source, index } = this;
    // The length is known at the end.
    const known = source.rewinds && source.complete && source.front === index.front;
    const { groups, frameCount = null } = known ? index : { groups: null };
    return { seekable: source.rewinds, frameCount, groups, rungs: source.rungs };
  }
  seek(place) {
    if (place) this.index.openKept();
    return super.seek(place);
  }
  finish() {
    if (this.source.complete && this.source.rewinds) this.index.openKept();
    return null;
  }
  arrived(_, { start, end }) {
    this.#span ??= { start, end };
    if (end > this.#span.end) this.#span.end = end;
  }
  bufferedTimes() {
    if (this.source.complete) return super.bufferedTimes();
    return this.source.rewinds && this.#span ? [{ ...this.#span }] : [];
  }
}
