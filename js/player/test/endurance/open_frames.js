// Counts the VideoFrames of a thread that are open, by the moments at which they come to be and are closed. One that is
// handed over to another thread stays open there.

/** told(change): 1 for a frame more, -1 for one less. */
export function countOpenFrames(told) {
  const closed = new WeakSet();
  const { close, clone } = VideoFrame.prototype;
  VideoFrame.prototype.close = function () {
    // What was handed over has no size any more here.
    if (!closed.has(this) && this.codedWidth > 0) told(-1);
    closed.add(this);
    return close.call(this);
  };
  VideoFrame.prototype.clone = function () {
    told(1);
    return clone.call(this);
  };
  const Decoder = globalThis.VideoDecoder;
  globalThis.VideoDecoder = class extends Decoder {
    constructor({ output, error }) {
      super({
        output: (frame) => {
          told(1);
          output(frame);
        },
        error,
      });
    }
  };
}

const now = performance.now.bind(performance);
/** Milliseconds that all threads of a page share. */
export const moment = () => performance.timeOrigin + now();

/** The most that were open at a time. changes: [[moment, change]] of all threads. */
export function mostOpen(changes) {
  let [open, most] = [0, 0];
  // Of one moment what closes counts first: moments are rounded.
  for (const [, change] of [...changes].sort((a, b) => a[0] - b[0] || a[1] - b[1])) {
    open += change;
    most = Math.max(most, open);
  }
  return { most, left: open };
}
