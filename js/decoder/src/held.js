// Times of a stream that play without the network.

export class Held {
  #source;
  #index;
  #reached = new Map(); // group -> {ranges, until, tracks}
  #span = null;

  constructor(source, index) {
    this.#source = source;
    this.#index = index;
  }

  /** Of group i all up to a time (ticks) stands in ranges, [{from, end}], for these tracks of video; null: for all. */
  reach(i, until, ranges, tracks) {
    this.#reached.set(i, { until, ranges, tracks });
  }
  /** Of one answer: a frame from start to end has come. */
  pass(start, end) {
    this.#span ??= { start, end };
    if (end > this.#span.end) this.#span.end = end;
  }

  /** selection: tracks that are played. [{start, end}] in ticks, in order. */
  times(selection) {
    const { groups } = this.#index;
    const source = this.#source;
    if (source.front !== undefined && !source.complete) return source.rewinds && this.#span ? [{ ...this.#span }] : [];
    const holds = (from, end) => source.holds?.(from, end) ?? true;
    const times = [];
    groups?.forEach(({ offset, size, start, end, frameCount }, i) => {
      const until = holds(offset, offset + size) ? end : this.#until(i, holds, selection);
      if (!frameCount || until === null) return;
      if (times.at(-1)?.end >= start) times.at(-1).end = until;
      else times.push({ start, end: until });
    });
    return times;
  }
  #until(i, holds, selection) {
    const { until, ranges, tracks } = this.#reached.get(i) ?? {};
    const serves = tracks === null || (tracks && selection?.every((track) => tracks.includes(track)));
    return serves && ranges.every(({ from, end }) => holds(from, end)) ? until : null;
  }
}
