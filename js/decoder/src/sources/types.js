// What a source is. There are three types: bytes in order, bytes at any offset, and sections of a stream. Each has a reader of groups,
// which is what playback uses. All members have a value for every source, so that no reader has to ask whether there is one.

import { RangeReader } from "./range_reader.js";
import { SectionReader } from "./section_reader.js";
import { SequentialReader } from "./sequential_reader.js";

class Source {
  /** Content-Type of a response; null: none. */
  type = null;
  /** Groups as session.groups returns them, if they are known before anything is read. */
  groups = null;
  /** Received from the network, and requests; null: it needs none. */
  get bytesRead() {
    return null;
  }
  get requests() {
    return null;
  }
  /** Rungs that come each by itself, as rungsOf returns them; null: all rungs are in one stream. */
  get rungs() {
    return null;
  }
  /** Bits per second, and seconds that have arrived and are not played; null: not known. */
  get throughput() {
    return null;
  }
  get buffer() {
    return null;
  }
  /** The time in ticks of the newest frame of a live stream that has arrived; null: not known. */
  get edge() {
    return null;
  }

  /** Copies bytes that need no network to out, or returns false. */
  kept() {
    return false;
  }
  /** Whether bytes need no network. */
  holds() {
    return true;
  }
  /** Sets where groups begin, as offsets. */
  divide() {}
  /** A byte is damaged: it is fetched again when it is needed again. */
  forget() {}
  /** Everything that waits for the source settles. */
  close() {}
}

/** Bytes in order. stream(from, signal): async iterator of Uint8Array from there to the end; from: up to front, if it rewinds. */
export class SequentialSource extends Source {
  /** Bytes that have arrived. */
  front = 0;
  /** Whether all of them can be read again. */
  rewinds = false;
  /** Whether nothing follows. */
  complete = false;

  /** wishes: as of GroupReader. */
  reader(wishes) {
    return new SequentialReader(this, wishes);
  }
}

/**
 * Bytes at any offset. read(offset, size, signal): resolves to Uint8Array. stream(from, signal): as above, from anywhere. range(from, end,
 * signal): as stream, up to byte end - 1; only if selective.
 */
export class RangeSource extends Source {
  size = 0;
  /** All of the bytes, if they are in memory. */
  bytes = null;
  /** Set by the caller who begins with range. */
  frugal = false;
  /** Seconds of a round trip, the least; 0: not known. */
  roundTrip = 0;

  /** Whether reading less is worth more requests. */
  get selective() {
    return false;
  }
  /** What was requested when the source was opened serves near ranges, until this ends it. */
  leave() {}

  /** wishes: as of GroupReader. */
  reader(wishes) {
    return new RangeReader(this, wishes);
  }
}

/**
 * A section is a file header, a configuration block and then any groups (clause 6.4). stream(group, signal): async iterator of
 * Uint8Array, and between those of
 *   {header}                 a section begins; these are the bytes of its file header, the rest follows as bytes
 *   {damage: error}          damage, before the loss that it causes
 *   {lost: {error, from}}    data is missing up to the next group; from: ticks, or undefined
 *   {restart: true}          another stream begins
 *   {rung, reason}           the groups that follow are of this rung
 *   {rungs}                  the rungs have changed
 * With groups it begins with that one.
 */
export class SectionSource extends Source {
  /** The payload of the environment of a track, {track, data}; null: it comes with the groups, or there is none. */
  async environment() {
    return null;
  }
  /** choices(seconds): what GroupPrefetcher asks of rungs; position(): as there. */
  follow() {}
  /** Another rung is wanted. */
  renew() {}
  /** Of a source that changes the rung by itself: {rung, reason} of a configuration with these tracks; null: of others. */
  rungOf() {
    return null;
  }

  /** wishes: as of GroupReader. */
  reader(wishes) {
    return new SectionReader(this, wishes);
  }
}
