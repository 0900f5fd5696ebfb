// Where playing is, in seconds of the stream, by a clock that only goes forward. It knows no frames.

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
