// Ranges of time, shaped like TimeRanges, and which of them can be played without waiting for the network.

export class Ranges {
  #pairs;

  /** pairs: [start, end] in seconds, in order. */
  constructor(pairs = []) {
    this.#pairs = pairs.filter(([start, end]) => end > start);
  }
  get length() {
    return this.#pairs.length;
  }
  start(i) {
    return this.#at(i)[0];
  }
  end(i) {
    return this.#at(i)[1];
  }
  #at(i) {
    if (!(i in this.#pairs)) throw new DOMException(`there is no range ${i} of ${this.length}`, "IndexSizeError");
    return this.#pairs[i];
  }
}

/** How far bytes reach that were read from a group on: seconds. groups: {start, end (seconds), bytes}. */
export function reachOf(groups, first, bytes) {
  let left = bytes;
  for (let i = first; i < groups.length; i++) {
    const { start, end, bytes: size } = groups[i];
    if (left < size) return start + (end - start) * Math.max(0, left / size);
    left -= size;
  }
  return groups.at(-1)?.end ?? 0;
}

export function groupAt(groups, seconds) {
  const i = groups.findLastIndex(({ start }) => start <= seconds + 1e-6);
  return Math.max(0, i);
}
