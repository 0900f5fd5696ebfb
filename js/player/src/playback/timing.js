// When frames are due: the clock of playback, the decision about the next frame, and the distance to a live edge.

export class Clock {
  #now;
  #position = 0;
  #rate = 1;
  #since = null;

  /** now(): milliseconds, as performance.now() has them. */
  constructor(now) {
    this.#now = now;
  }

  get running() {
    return this.#since !== null;
  }
  get position() {
    return this.running ? this.#position + ((this.#now() - this.#since) / 1000) * this.#rate : this.#position;
  }
  set position(seconds) {
    this.#position = seconds;
    if (this.running) this.#since = this.#now();
  }
  get rate() {
    return this.#rate;
  }
  /** What has passed so far passed at the former rate. */
  set rate(rate) {
    if (rate === this.#rate) return;
    this.position = this.position;
    this.#rate = rate;
  }

  start() {
    if (!this.running) this.#since = this.#now();
  }
  stop() {
    this.#position = this.position;
    this.#since = null;
  }
}

/** Seconds that a frame may come early: half a picture of a screen, else it comes a whole one late. */
const EARLY = 0.004;
/** Milliseconds after which a late frame is shown all the same: a slow picture beats none. */
const LONGEST_BLANK = 250;
/** Seconds, not of the stream, that decoding may lag before frames are leapt over. */
const LAG = 0.5;

/**
 * frame: {seconds, duration}, position: of the clock. sinceShown: milliseconds. Answers
 *   "wait"  it is not due        "show"  it is
 *   "drop"  the next one is due already
 *   "lag"   decoding does not keep up: leap, or set the clock back
 */
export function whatIsDue(frame, position, rate, sinceShown) {
  const late = position - frame.seconds;
  if (late < -EARLY * rate) return "wait";
  if (late > LAG * rate && late > frame.duration) return "lag";
  if (late > frame.duration && sinceShown < LONGEST_BLANK) return "drop";
  return "show";
}

/** Seconds behind the edge that playing keeps to, so that small delays of the network do not show. */
const LIVE_DELAY = 0.25;
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
