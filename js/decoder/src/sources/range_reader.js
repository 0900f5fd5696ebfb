// The groups of a RangeSource, from anywhere in the file: whole, without the tracks that are not wanted, or in the rung that suits the
// network.

import { onAbort } from "../abort.js";
import { FvvError } from "../errors.js";
import { ByteRanges } from "./byte_ranges.js";
import { GroupPrefetcher, RangeFetcher } from "./group_prefetcher.js";
import { GroupReader } from "./group_reader.js";

const DAMAGED = ["damaged", "invalid", "truncated"];

export class RangeReader extends GroupReader {
  #ranges;
  #ladder = null; // what GroupPrefetcher has to know of rungs
  #prefetcher = null; // of a ladder

  /** wishes.frugal: a selection will be made before the first frame. */
  constructor(source, wishes) {
    const ranges = new ByteRanges(source);
    const available = { [Symbol.iterator]: () => this.#available() };
    super(source, wishes, { available, readsAnywhere: true });
    this.#ranges = ranges;
    source.frugal = wishes.frugal || wishes.selection() !== null;
  }
  *#available() {
    yield* this.#ranges;
    if (this.#prefetcher) yield* this.#prefetcher;
  }

  async open(session) {
    const problem = await super.open(session);
    await this.#findLadder();
    return problem;
  }
  get network() {
    const { throughput, buffer } = super.network;
    return { throughput, buffer: this.#prefetcher?.buffer ?? buffer };
  }
  get fetchesRungs() {
    return this.#prefetcher !== null;
  }
  renewSelection() {
    this.#prefetcher?.renew();
  }
  renewRung() {
    this.#prefetcher?.renew();
  }
  seek(place) {
    this.#ranges.clear();
    this.stop();
    return super.seek(place);
  }
  async *read(state, first) {
    for (let group = first; group !== null;)
      group = yield* this.#picks(state, group) ? this.#pick(state, group) : this.inOrder(state, group);
  }
  finish({ footer }) {
    const isLost = !footer && this.index.groups && this.session.indexState === 1;
    return isLost ? "the stream ends before its footer" : null;
  }
  arrived({ index, at, group }, { end }) {
    if (index < 0 || at === null) return;
    const { offset, size } = this.index.groups[index];
    const ranges = [{ from: offset, end: Math.min(at, offset + size) }];
    this.buffered.cover(index, end < group.end ? end : group.end, ranges, null);
  }
  stop() {
    this.#prefetcher?.stop();
  }

  /** A file says at its beginning whether it has a ladder. */
  async #findLadder() {
    const { source, session, index, choice } = this;
    const first = index.groups?.[0];
    if (!first || !source.selective || session.indexState !== 1) return;
    // The bytes after it are the first frames.
    if (!source.frugal) index.keep(0, await source.read(0, first.offset));
    if (!(await index.satisfied(() => session.play(0)))) return;
    this.#learn(session.configuration());
    if (choice.rungs.length < 2) return;
    source.frugal = true;
    // The table of the group and the bytes of its first picture come at the same time.
    const began = performance.now();
    const measured = (bytes) => choice.chooser.began(bytes, (performance.now() - began) / 1000);
    source.lead().then(measured, () => {}); // who reads them reports the error
    this.#lookAhead();
  }
  #lookAhead() {
    this.stop();
    const { groups } = this.index;
    const fetcher = new RangeFetcher(this.source, groups, this.#ladder);
    this.#prefetcher =
      this.choice.rungs.length > 1 ? new GroupPrefetcher(fetcher, groups, this.#ladder, this.wishes.taken) : null;
  }
  #learn(configuration) {
    if (!this.choice.learn(configuration)) return;
    const { rungs } = this.choice;
    const { numerator, denominator } = configuration.timeBase;
    const all = configuration.tracks.map(({ id }) => id);
    const notOf = ({ tracks }) => all.filter((id) => !tracks.includes(id));
    this.#ladder = {
      ...this.choice.asked((ticks) => (Number(ticks) * numerator) / denominator),
      rungs,
      leftOut: (rung) => [
        ...new Set([...notOf(rungs[rung]), ...this.#videosLeftOut(configuration), ...this.wishes.environments()]),
      ],
    };
  }
  begin(state, configuration) {
    if (configuration) this.#learn(configuration);
    if (!state.picking) [state.rung, state.reason] = [this.choice.local, "chosen"];
  }

  /** configuration: null: it is lost. */
  #videosLeftOut(configuration = this.session.configuration()) {
    const selection = this.wishes.selection();
    return (configuration?.videos ?? [])
      .map(({ track }) => track)
      .filter((track) => selection?.includes(track) === false);
  }
  /** Whether a group should be read without some of its tracks. */
  #picks(state, group) {
    const wanted = this.wishes.selection() !== null || this.#prefetcher !== null;
    return wanted && this.source.selective && this.session.indexState === 1 && !state.whole?.has(group);
  }
  async redirects(state, about) {
    if (await super.redirects(state, about)) return true;
    const { index } = state;
    if (index < 0 || !this.#picks(state, index)) return false;
    if (this.#prefetcher === null && !this.#videosLeftOut().length) return false;
    state.next = index;
    return true;
  }

  /** Reads a group without unwanted tracks. Returns the next group, or the same one if it has to be read in another way. */
  async *#pick(state, group) {
    const { index } = this;
    const { reads } = index;
    state.at = null;
    try {
      const ranges = yield* this.#prefetcher ? this.#pickRung(state, group) : this.#pickTracks(state, group);
      if (!ranges) return state.next;
      if (!state.ended) throw new FvvError({ code: "io", message: "a part of a group cannot be read" });
      const covered = [...this.#ranges.tableOf(index.groups, group), ...ranges];
      this.buffered.cover(group, index.groups[group].end, covered, state.tracks);
    } finally {
      state.picking = state.ended = false;
      index.forgetReads(reads);
    }
    if (group + 1 < index.groups.length) return group + 1;
    this.stop();
    // The rest was checked when the index was read.
    state.footer = true;
    return null;
  }
  /** Returns the ranges that were read; null: nothing was shown, and state.next is what to read. */
  async *#pickTracks(state, group) {
    const { session, index } = this;
    const abort = new AbortController();
    const unregister = onAbort(state.signal, () => abort.abort());
    this.source.leave();
    try {
      await this.#ranges.prepare(index.groups, group, state.signal);
      const begun = yield* this.#begin(state, group);
      // Environments are left out only where that is worth it.
      const videos = begun ? this.#videosLeftOut() : [];
      if (!videos.length) return this.#asWhole(state, group);
      session.leaveOut([...videos, ...this.wishes.environments()]);
      const picked = session.picked();
      for await (const _ of this.#ranges.fetch(picked, abort.signal)) {
        yield null;
        if (state.ended) break;
      }
      yield null;
      return picked;
    } finally {
      unregister();
      abort.abort();
    }
  }
  /** The same with a ladder: the group comes in the rung that was chosen when it was fetched. */
  async *#pickRung(state, group) {
    const [session, prefetcher, ladder] = [this.session, this.#prefetcher, this.#ladder];
    if (!prefetcher.running) prefetcher.start(group, state.signal);
    const pending = await prefetcher.take(group);
    state.next = null;
    if (!pending || state.signal?.aborted) return null;
    if (pending.error) throw pending.error;
    [state.rung, state.reason] = [pending.rung, pending.reason];
    if (!(yield* this.#begin(state, group))) {
      prefetcher.stop();
      return this.#asWhole(state, group);
    }
    if (ladder !== this.#ladder) {
      // Another configuration, with other tracks than those that were fetched.
      this.#lookAhead();
      state.next = group;
      return null;
    }
    session.leaveOut(pending.leftOut);
    for await (const _ of prefetcher.arrivals(pending)) {
      yield null;
      if (state.ended) break;
    }
    return pending.ranges;
  }
  #asWhole(state, group) {
    (state.whole ??= new Set()).add(group);
    state.next = group;
    return null;
  }

  /** false: the group is damaged, and all of its bytes have to be read for a report. */
  async *#begin(state, group) {
    const { session, index } = this;
    try {
      if (!(await index.satisfied(() => session.pick(group), state.signal))) return false;
    } catch (error) {
      if (!DAMAGED.includes(error.code)) throw error;
      this.forget(group);
      return false;
    }
    state.picking = state.fromIndex = true;
    if (session.next() !== "group") return false;
    const about = session.about();
    state.index = index.at(about.offset);
    yield { group: about };
    return true;
  }
}
