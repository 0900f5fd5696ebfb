// Where bytes come from. A source has:
//   stream(from, signal)       async iterator of Uint8Array from an offset to the end
//   size, read(offset, size)   only where any place can be read
//   part(from, end, signal)    only where reading less is worth requests, as long as inParts says so: as stream, to
//                              byte end - 1; leave() before; frugal is set by who begins with that
//   inRuns, groups             see runs.js
//   front, rewinds, complete   of one answer: bytes that have gone by, whether they can all be read again (then stream
//                              begins anywhere up to front), and whether these are all
//   holds(from, end)           whether bytes need no network; where it is lacking, they never do
//   kept(offset, out)          copies bytes that a cache has to out, or answers false
//   divide(offsets)            tells where groups begin; forget(offset): a byte there is damaged; close()
// openSource makes one of a plain description that can be sent to a worker.

import { Live } from "./live.js";
import { Segments } from "./segments.js";
import { openUrl } from "./url.js";

const BLOCK = 1 << 20;

class Bytes {
  constructor(bytes) {
    this.bytes = bytes;
    this.size = bytes.length;
  }
  async read(offset, size) {
    return this.bytes.subarray(offset, offset + size);
  }
  async *stream(from) {
    for (let at = from; at < this.size; at += BLOCK) yield this.bytes.subarray(at, at + BLOCK);
  }
}

class File {
  constructor(blob) {
    this.blob = blob;
    this.size = blob.size;
  }
  async read(offset, size) {
    return new Uint8Array(await this.blob.slice(offset, offset + size).arrayBuffer());
  }
  async *stream(from) {
    for (let at = from; at < this.size; at += BLOCK) yield this.read(at, Math.min(BLOCK, this.size - at));
  }
}

/** Bytes as they come, once. pull(): the next piece or null. */
class Stream {
  constructor(pull) {
    this.pull = pull;
  }
  async *stream() {
    for (;;) {
      const piece = await this.pull();
      if (!piece) return;
      yield piece;
    }
  }
}

/**
 * description: {bytes}, {blob}, {url, init, seekable}, {segments: {url, init}}, {live: {url, ...}}, or {pull: true} with
 * a function pull. cache: for what comes from URLs, until it closes.
 */
export async function openSource(description, { pull, warn, cache }) {
  if (description.bytes) return new Bytes(description.bytes);
  if (description.blob) return new File(description.blob);
  if (description.live) return Live.open(description.live, warn);
  if (description.segments) return Segments.open(description.segments, cache);
  if (description.url) return openUrl(description, { warn, cache });
  return new Stream(pull);
}
