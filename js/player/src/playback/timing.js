// When frames are due: the clock of playback, the decision about the next frame, and the delay behind a live edge.

/** Positions of the stream at a constant rate from a time on, all in seconds. */
export class Course {
  constructor(time, position, rate) {
    Object.assign(this, { time, position, rate });
  }
  positionAt(time) {
    return this.position + (time - this.time) * this.rate;
  }
  timeOf(position) {
    return this.time + (position - this.position) / this.rate;
  }
}

/** The position in seconds of the stream. The clock only runs forward. */
export class Clock {
  #now;
  #position = 0;
  #rate = 1;
  #course = null;

  /** now(): milliseconds, as performance.now() has them. */
  constructor(now) {
    this.#now = now;
  }

  get running() {
    return this.#course !== null;
  }
  get position() {
    return this.#course ? this.#course.positionAt(this.#now() / 1000) : this.#position;
  }
  set position(seconds) {
    this.#position = seconds;
    if (this.running) this.#begin();
  }
  get rate() {
    return this.#rate;
  }
  /** Time that has already passed counts at the former rate. */
  set rate(rate) {
    if (rate === this.#rate) return;
    this.#position = this.position;
    this.#rate = rate;
    if (this.running) this.#begin();
  }

  start() {
    if (!this.running) this.#begin();
  }
  #begin() {
    this.#course = new Course(this.#now() / 1000, this.#position, this.#rate);
  }
  stop() {
    this.#position = this.position;
    this.#course = null;
  }
}

/** Milliseconds without a new frame after which a late frame is shown anyway. */
const MAX_BLANK = 250;
/** Real seconds that decoding may lag before groups are skipped. */
const LAG = 0.5;

/**
 * Decides what to do with the next frame, {seconds, duration}. position: of the clock. sinceShown: milliseconds. screen:
 * {delay, refresh} in milliseconds, from here to the screen and between its pictures: a frame is shown on the refresh that
 * is nearest to its time. Returns
 *   "wait"  it is not due        "show"  it is due
 *   "drop"  the frame after it is due already
 *   "lag"   decoding is too slow: skip groups, or set the clock back
 */
export function whatIsDue(frame, position, rate, sinceShown, screen) {
  const late = position - frame.seconds;
  const lateOnScreen = late + (screen.delay / 1000) * rate;
  if (lateOnScreen < -(screen.refresh / 2000) * rate) return "wait";
  if (late > LAG * rate && late > frame.duration) return "lag";
  if (lateOnScreen > frame.duration && sinceShown < MAX_BLANK) return "drop";
  return "show";
}

/** How a live stream is followed. */
export const LIVE = Object.freeze({
  /** The intended delay behind the edge in seconds, which hides small delays of the network. */
  delay: 0.25,
  /** The rate of playback at most, until it has caught up. */
  maxRate: 1.25,
  /** Seconds behind the edge after which playback jumps to it. */
  jumpAfter: 5,
});
const MIN_RATE = 0.95;
/** Frames may arrive in bursts, a group at once. Before the next burst the edge is as near as it gets: seconds in which there is one. */
const BURST = 6;
/** Seconds without an observation, as in a pause, after which nothing is known of bursts. */
const UNSEEN = 1;
/** Deviations from the delay in seconds: where a correction begins, and where it ends. */
const CORRECT_FROM = 0.15;
const CORRECT_TO = 0.05;
/** Change of the rate per second of deviation: it returns to 1 smoothly. */
const GAIN = 0.5;

/** The least of the values that were added in the last BURST seconds. */
class Lowest {
  #values = []; // [time, value], both rising
  #since = -Infinity;
  #last = -Infinity;

  add(time, value) {
    if (time - this.#last > UNSEEN) this.clear(time);
    this.#last = time;
    while (this.#values.length && this.#values.at(-1)[1] >= value) this.#values.pop();
    this.#values.push([time, value]);
    while (this.#values[0][0] < time - BURST) this.#values.shift();
  }
  clear(time) {
    this.#values = [];
    this.#since = time;
  }
  /** -Infinity: values were added for less than BURST. */
  get value() {
    return this.#last - this.#since < BURST ? -Infinity : this.#values[0][1];
  }
}

/**
 * How far playback is behind a live stream, and the rate that corrects it. The edge is known once a frame had to be waited
 * for; before that, any number of frames may be available. Later it moves on if frames that have arrived say so: the clock of the
 * publisher may be fast.
 */
export class LiveEdge {
  #ahead = -Infinity;
  #known = false;
  #correcting = false;
  #latest = -Infinity; // seconds of the frame that arrived last
  #former = null; // the edge of the stream on screen, while frames of a restarted stream already arrive
  #arrived = new Lowest(); // how far the frames that have arrived are ahead

  /** A frame has been taken. edge: seconds of the newest one that has arrived, or null. waited: as soon as the stream had it. now:
   * milliseconds. */
  observe({ seconds, edge, waited }, now) {
    if (seconds < this.#latest) this.#leave(now);
    this.#latest = seconds;
    const ahead = seconds - now / 1000;
    this.#arrived.add(now / 1000, Math.max(seconds, edge ?? seconds) - now / 1000);
    this.#ahead = waited ? ahead : Math.max(this.#ahead, ahead, this.#arrived.value);
    this.#known ||= waited;
  }
  /** Times go back: the stream has restarted. The frames on screen keep their former edge. */
  #leave(now) {
    this.#arrived.clear(now / 1000);
    this.#former ??= this.#ahead;
    this.#ahead = -Infinity;
    this.#known = this.#correcting = false;
  }
  /** The restarted stream is on screen. */
  enter() {
    this.#former = null;
  }
  /** Minimum number of seconds that position is behind the edge. */
  behind(position, now) {
    const ahead = this.#former ?? this.#ahead;
    return ahead === -Infinity ? 0 : Math.max(0, ahead + now / 1000 - position);
  }
  /** The factor for the rate. live: as LIVE. */
  rateFor(behind, { delay, maxRate }) {
    if (!this.#known) return maxRate;
    const late = behind - delay;
    if (Math.abs(late) > CORRECT_FROM) this.#correcting = true;
    if (Math.abs(late) < CORRECT_TO) this.#correcting = false;
    if (!this.#correcting) return 1;
    return late > 0 ? Math.min(maxRate, 1 + Math.max(GAIN * late, 0.02)) : MIN_RATE;
  }
}
