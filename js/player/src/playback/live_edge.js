// How far behind a live stream playing is, and how it comes back: a little faster, or a little slower. Where the edge
// is shows when a frame has to be waited for: before, more frames may lie ready than anyone knows.

/** Seconds behind the edge that playing keeps to, so that small delays of the network do not show. */
export const LIVE_DELAY = 0.25;
const FASTEST = 1.25;
const SLOWEST = 0.95;
/** Seconds off the delay at which the rate changes, and at which it is normal again. */
const OFF = 0.15;
const CLOSE = 0.05;
/** Rate a second: close to the edge it goes back to normal without a jolt. */
const GAIN = 0.5;

export class LiveEdge {
  #ahead = -Infinity;
  #known = false;
  #correcting = false;
  #latest = -Infinity; // seconds of the frame that came last
  #former = null; // the edge of the run that is on screen, while frames of the next one come already

  /** A frame came. waited: as soon as the stream had it. now: milliseconds. */
  observe(seconds, now, waited) {
    if (seconds < this.#latest) this.#leave();
    this.#latest = seconds;
    const ahead = seconds - now / 1000;
    this.#ahead = waited ? ahead : Math.max(this.#ahead, ahead);
    this.#known ||= waited;
  }
  /** Times go back: the stream begins anew. What is on screen falls behind the edge that it had. */
  #leave() {
    this.#former ??= this.#ahead;
    this.#ahead = -Infinity;
    this.#known = this.#correcting = false;
  }
  /** The run that came last is on screen. */
  enter() {
    this.#former = null;
  }
  /** Seconds that position is behind, at least. */
  behind(position, now) {
    const ahead = this.#former ?? this.#ahead;
    return ahead === -Infinity ? 0 : Math.max(0, ahead + now / 1000 - position);
  }
  /** By what to multiply the rate. */
  rateFor(behind) {
    if (!this.#known) return FASTEST;
    const late = behind - LIVE_DELAY;
    if (Math.abs(late) > OFF) this.#correcting = true;
    if (Math.abs(late) < CLOSE) this.#correcting = false;
    if (!this.#correcting) return 1;
    return late > 0 ? Math.min(FASTEST, 1 + Math.max(GAIN * late, 0.02)) : SLOWEST;
  }
}
