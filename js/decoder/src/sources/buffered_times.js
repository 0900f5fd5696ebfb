// The times of a stream that can be played without the network.

export class BufferedTimes {
  #source;
  #index;
  #covered = new Map(); // group -> {ranges, until, tracks}

  constructor(source, index) {
    this.#source = source;
    this.#index = index;
  }

  /** Group i up to a time (ticks) needs the bytes in ranges, [{from, end}], for these tracks of video; null: for all. */
  cover(i, until, ranges, tracks) {
    this.#covered.set(i, { until, ranges, tracks });
  }

  /** selection: tracks that are played. Returns [{start, end}] in ticks, in order. */
  times(selection) {
    const holds = (from, end) => this.#source.holds(from, end);
    const times = [];
    this.#index.groups?.forEach(({ offset, size, start, end, frameCount }, i) => {
      const until = holds(offset, offset + size) ? end : this.#until(i, holds, selection);
      if (!frameCount || until === null) return;
      if (times.at(-1)?.end >= start) times.at(-1).end = until;
      else times.push({ start, end: until });
    });
    return times;
  }
  #until(i, holds, selection) {
    const { until, ranges, tracks } = this.#covered.get(i) ?? {};
    const serves = tracks === null || (tracks && selection?.every((track) => tracks.includes(track)));
    return serves && ranges.every(({ from, end }) => holds(from, end)) ? until : null;
  }
}
