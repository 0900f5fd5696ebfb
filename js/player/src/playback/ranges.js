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
  /** Seconds from a time on without a gap. */
  ahead(seconds) {
    const range = this.#pairs.find(([start, end]) => start <= seconds && end > seconds);
    return range ? range[1] - seconds : 0;
  }
  #at(i) {
    if (!(i in this.#pairs)) throw new DOMException(`there is no range ${i} of ${this.length}`, "IndexSizeError");
    return this.#pairs[i];
  }
}

/** Frames that follow each other don't end to the last bit where the next one begins. */
const TOUCH = 1e-6;

/** Pairs of seconds in any order, as few as possible that cover the same. */
export function union(pairs) {
  const joined = [];
  for (const [start, end] of pairs.filter((pair) => pair[1] > pair[0]).sort((a, b) => a[0] - b[0])) {
    const last = joined.at(-1);
    if (last && start <= last[1] + TOUCH) last[1] = Math.max(last[1], end);
    else joined.push([start, end]);
  }
  return joined;
}

export function groupAt(groups, seconds) {
  const i = groups.findLastIndex(({ start }) => start <= seconds + 1e-6);
  return Math.max(0, i);
}
