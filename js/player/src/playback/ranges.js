// Ranges of time with the interface of TimeRanges.

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
  /** Number of seconds from a time on without a gap. */
  ahead(seconds) {
    const range = this.#pairs.find(([start, end]) => start <= seconds && end > seconds);
    return range ? range[1] - seconds : 0;
  }
  #at(i) {
    if (!(i in this.#pairs)) throw new DOMException(`no range ${i} of ${this.length}`, "IndexSizeError");
    return this.#pairs[i];
  }
}

/** Tolerance in seconds: the end of a frame does not exactly equal the beginning of the next one. */
const TOLERANCE = 1e-6;

/** The union of pairs of seconds in any order, as sorted disjoint pairs. */
export function union(pairs) {
  const joined = [];
  for (const [start, end] of pairs.filter((pair) => pair[1] > pair[0]).sort((a, b) => a[0] - b[0])) {
    const last = joined.at(-1);
    if (last && start <= last[1] + TOLERANCE) last[1] = Math.max(last[1], end);
    else joined.push([start, end]);
  }
  return joined;
}

/** The number of the group that is shown at a time. */
export function groupAt(groups, seconds) {
  const i = groups.findLastIndex(({ start }) => start <= seconds + TOLERANCE);
  return Math.max(0, i);
}
