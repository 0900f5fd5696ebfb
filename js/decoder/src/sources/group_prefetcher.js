// Groups of a stream with a ladder, fetched ahead of playback: each in the rung that suits the network by then.

import { CHUNK_HEADER_SIZE, tableOfGroup } from "../chunks.js";
import { FvvError } from "../errors.js";
import { onAbort } from "../abort.js";
import { ByteRanges } from "./byte_ranges.js";
import { CONCURRENT } from "./network.js";

/** Bytes that are held for groups that are not played yet. */
const BYTES_MAX = 32 * 2 ** 20;

const now = () => performance.now() / 1000;

/** Something that others wait for. */
class Signal {
  #waiting = [];
  raise() {
    for (const resolve of this.#waiting.splice(0)) resolve();
  }
  wait() {
    return new Promise((resolve) => this.#waiting.push(resolve));
  }
}

/** Chunks of a file, in ranges. A fetcher has plans(i, signal), what to fetch of a group in each rung with its size in bytes, and
 * fetch(plan, signal), which yields the numbers of bytes that have come and leaves them where the plan says. */
export class RangeFetcher {
  #source;
  #groups;
  #leftOut;
  #rungs;

  /** leftOut(rung): tracks that are not fetched. */
  constructor(source, groups, { rungs, leftOut }) {
    this.#source = source;
    this.#groups = groups;
    this.#rungs = rungs;
    this.#leftOut = leftOut;
  }
  get bytesRead() {
    return this.#source.bytesRead;
  }
  /** Seconds that all requests so far take if only their round trips count. */
  get latency() {
    const { roundTrip, requests } = this.#source;
    return (roundTrip * requests) / CONCURRENT;
  }

  async plans(i, signal) {
    const { offset, size, endSize } = this.#groups[i];
    const tables = new ByteRanges(this.#source, { keeps: true });
    await tables.prepare(this.#groups, i, signal, { alone: true });
    const [, { from }] = tables.tableOf(this.#groups, i);
    const end = [...tables].find(({ at, bytes }) => at <= from && at + bytes.length >= offset + size);
    const table = tableOfGroup(end.bytes.subarray(from - end.at + CHUNK_HEADER_SIZE, from - end.at + endSize), offset);
    return this.#rungs.map(({ rung }) => {
      const leftOut = this.#leftOut(rung);
      const ranges = table.filter(({ track }) => !leftOut.includes(track)).map(({ from, end }) => ({ from, end }));
      const bytes = ranges.reduce((sum, { from, end }) => sum + end - from, 0);
      const byteRanges = new ByteRanges(this.#source, { keeps: true });
      byteRanges.adopt(tables);
      return { rung, leftOut, ranges, byteRanges, size: bytes };
    });
  }
  async *fetch({ byteRanges, ranges }, signal) {
    yield* byteRanges.fetch(ranges, signal);
    // The response of the beginning is worth its bytes for the first group only.
    this.#source.leave();
  }
}

/** A group in one rung, as it arrives. It ends in any case: whole, by an error, or because it is no longer wanted. */
class PendingGroup {
  done = false;
  error = null;
  changed = new Signal();
  #abort = new AbortController();

  constructor(plan) {
    Object.assign(this, plan);
  }
  get signal() {
    return this.#abort.signal;
  }
  end(error = null) {
    if (this.done) return;
    this.done = true;
    this.error = error;
    this.changed.raise();
  }
  /** It is no longer wanted: who waits for it gets the error. */
  drop() {
    this.#abort.abort();
    this.end(new FvvError({ code: "state", message: "the group is no longer fetched" }));
  }
}

export class GroupPrefetcher {
  #fetcher;
  #groups;
  #ladder;
  #position;
  #pending = new Map(); // group -> PendingGroup
  #changed = new Signal(); // when a group is planned, or playback moves on
  #playing = -1;
  #abort = null;
  #unregister = () => {};

  /**
   * ladder: {chooser, wish(), best(), seconds(ticks)}. position(): ticks up to which frames were taken, or null.
   */
  constructor(fetcher, groups, ladder, position) {
    this.#fetcher = fetcher;
    this.#groups = groups;
    this.#ladder = ladder;
    this.#position = position;
  }
  *[Symbol.iterator]() {
    for (const { byteRanges } of this.#pending.values()) if (byteRanges) yield* byteRanges;
  }

  /** Begins to fetch from a group on. */
  start(first, signal) {
    this.stop();
    this.#playing = first;
    this.#abort = new AbortController();
    this.#unregister = onAbort(signal, () => this.stop());
    if (this.#abort) this.#run(first, this.#abort.signal);
  }
  /** Every pending group ends, and so does waiting for one. */
  stop() {
    this.#unregister();
    this.#abort?.abort();
    this.#abort = null;
    for (const pending of this.#pending.values()) pending.drop();
    this.#pending.clear();
    this.#changed.raise();
  }
  get running() {
    return this.#abort !== null;
  }
  /** Groups after the one that is played are fetched again: another rung is wanted. */
  renew() {
    if (!this.#abort || this.#pending.size <= 1) return;
    const first = this.#playing + 1;
    for (const [group, pending] of this.#pending) if (group >= first) this.#drop(group, pending);
    this.#abort.abort();
    this.#abort = new AbortController();
    this.#run(first, this.#abort.signal);
    this.#changed.raise();
  }
  #drop(group, pending) {
    pending.drop();
    this.#pending.delete(group);
  }

  /** The group that is played next, once its rung is chosen; groups before it are forgotten. null: stopped. */
  async take(group) {
    this.#playing = group;
    for (const [known, pending] of this.#pending) if (known < group) this.#drop(known, pending);
    this.#changed.raise();
    while (this.#abort && !this.#pending.has(group)) await this.#changed.wait();
    return this.#pending.get(group) ?? null;
  }
  /** Yields whenever more bytes of a group have arrived in order. */
  async *arrivals(pending) {
    while (!pending.done) {
      const more = pending.changed.wait();
      yield;
      await more;
    }
    if (pending.error) throw pending.error;
    yield;
  }

  /** Seconds of playback that have arrived and were not taken. */
  get buffer() {
    let end = null;
    for (let i = this.#playing; this.#pending.get(i)?.done; i++) end = this.#groups[i].end;
    if (end === null) return 0;
    const from = this.#position() ?? this.#groups[this.#playing].start;
    return Math.max(0, this.#ladder.seconds(end - from));
  }
  get #bytes() {
    return Array.from(this.#pending.values()).reduce((sum, { size }) => sum + size, 0);
  }

  async #run(first, signal) {
    for (let i = first; i < this.#groups.length && !signal.aborted; i++) {
      const isFull = () => i > this.#playing && (this.buffer >= this.#ladder.chooser.target || this.#bytes > BYTES_MAX);
      // Without new groups playback goes on, so that this is looked at again at each of them.
      while (isFull() && !signal.aborted) await this.#changed.wait();
      if (!signal.aborted) await this.#fetch(i, signal);
    }
  }

  /** In the chosen rung, or once more in the lowest if that would be too late. */
  async #fetch(i, signal) {
    try {
      const plans = await this.#fetcher.plans(i, signal);
      if (signal.aborted) return;
      const sizes = plans.map(({ size }) => 8 * size);
      const seconds = this.#ladder.seconds(this.#groups[i].end - this.#groups[i].start);
      const { chooser } = this.#ladder;
      const wish = this.#ladder.wish();
      const { rung, reason } =
        wish !== null
          ? { rung: Math.min(wish, plans.length - 1), reason: "chosen" }
          : chooser.choose({ bits: sizes, seconds, buffer: this.buffer, best: this.#ladder.best() });
      const last = plans.length - 1;
      const finished = await this.#load(i, { ...plans[rung], reason }, signal, (missing, throughput) => {
        if (wish !== null || rung === last || i <= this.#playing) return false;
        return chooser.abandons({ missing, lowest: sizes[last], buffer: this.buffer, throughput });
      });
      if (!finished) await this.#load(i, { ...plans[last], reason: "late" }, signal, () => false);
    } catch (error) {
      if (signal.aborted) return;
      // Who plays the group reports the error.
      const failed = new PendingGroup({ rung: 0, size: 0 });
      failed.end(error);
      this.#pending.set(i, failed);
      this.#changed.raise();
    }
  }

  /** false: it was abandoned, as late(missing bits, throughput) said. */
  async #load(i, plan, signal, late) {
    // Stopped while it was planned: the group may be another run's by now.
    if (signal.aborted) return true;
    const pending = new PendingGroup(plan);
    const unregister = onAbort(signal, () => pending.drop());
    this.#pending.set(i, pending);
    this.#changed.raise();
    const began = now();
    const before = this.#fetcher.bytesRead;
    const latency = this.#fetcher.latency;
    const { chooser } = this.#ladder;
    const measured = (bytes, seconds) => chooser.measured(bytes, seconds, this.#fetcher.latency - latency);
    try {
      let arrived = 0;
      for await (const bytes of this.#fetcher.fetch(pending, pending.signal)) {
        pending.changed.raise();
        arrived += bytes;
        const [network, seconds] = [this.#fetcher.bytesRead - before, now() - began];
        // What has come so far says more of a network that breaks down than what was measured before.
        const throughput = seconds > 0.3 ? (8 * network) / seconds : chooser.throughput;
        if (late(8 * Math.max(0, plan.size - arrived), throughput)) {
          measured(network, seconds);
          this.#drop(i, pending);
          return false;
        }
      }
      measured(this.#fetcher.bytesRead - before, now() - began);
      pending.end();
    } catch (error) {
      pending.end(error);
    } finally {
      unregister();
    }
    return true;
  }
}
