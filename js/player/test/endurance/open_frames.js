// Counts the open VideoFrames of a thread, by the times at which they are created and closed. A frame that is transferred to
// another thread stays open there.

/** report(change): called with 1 for a created frame, -1 for a closed one. */
export function countOpenFrames(report) {
  const closed = new WeakSet();
  const { close, clone } = VideoFrame.prototype;
  VideoFrame.prototype.close = function () {
    // A transferred frame has no size.
    if (!closed.has(this) && this.codedWidth > 0) report(-1);
    closed.add(this);
    return close.call(this);
  };
  VideoFrame.prototype.clone = function () {
    report(1);
    return clone.call(this);
  };
  const Decoder = globalThis.VideoDecoder;
  globalThis.VideoDecoder = class extends Decoder {
    constructor({ output, error }) {
      super({
        output: (frame) => {
          report(1);
          output(frame);
        },
        error,
      });
    }
  };
}

const now = performance.now.bind(performance);
/** Milliseconds on a clock that all threads of a page share. */
export const moment = () => performance.timeOrigin + now();

/** The maximum number of frames open at a time. changes: [[moment, change]] of all threads. */
export function mostOpen(changes) {
  let [open, max] = [0, 0];
  // At equal moments closing counts first, because moments are rounded.
  for (const [, change] of [...changes].sort((a, b) => a[0] - b[0] || a[1] - b[1])) {
    open += change;
    max = Math.max(max, open);
  }
  return { max, left: open };
}
