// Statistics of playback: frames shown and dropped, and rates over the last seconds.

/** Milliseconds over which rates are averaged. */
const WINDOW = 2000;

class Rate {
  #events = [];
  add(now, amount) {
    this.#events.push([now, amount]);
    this.#forget(now);
  }
  #forget(now) {
    while (this.#events.length && now - this.#events[0][0] > WINDOW) this.#events.shift();
  }
  /** Per second. */
  at(now) {
    this.#forget(now);
    if (this.#events.length < 2) return 0;
    const span = Math.max(now - this.#events[0][0], 1);
    const amount = this.#events.slice(1).reduce((sum, [, one]) => sum + one, 0);
    return (1000 * amount) / span;
  }
}

export class Meter {
  #shown = new Rate();
  #bytes = new Rate();
  #read = null;
  framesShown = 0;
  framesDropped = 0;
  /** Smoothed milliseconds per frame: decoding of meshes, visibility and calibration; and showing. */
  decodeMs = 0;
  showMs = 0;
  memoryBytes = 0;
  queued = 0;
  bytesRead = null;

  shown(now, { decodeMs, showMs }) {
    this.framesShown++;
    this.#shown.add(now, 1);
    const weight = this.framesShown === 1 ? 1 : 0.1;
    this.decodeMs += weight * (decodeMs - this.decodeMs);
    this.showMs += weight * (showMs - this.showMs);
  }
  dropped(count = 1) {
    this.framesDropped += count;
  }
  /** Takes Decoder.stats. Returns whether bytes have arrived. */
  decoder(now, { bytesRead, memoryBytes, queued }) {
    const more = bytesRead !== null && bytesRead !== this.#read;
    if (bytesRead !== null && this.#read !== null && bytesRead >= this.#read)
      this.#bytes.add(now, bytesRead - this.#read);
    this.#read = bytesRead;
    Object.assign(this, { bytesRead, memoryBytes, queued });
    return more;
  }
  /** The next statistics are those of another decoder. */
  begin() {
    this.#read = null;
  }
  framesPerSecond(now) {
    return this.#shown.at(now);
  }
  /** Received bits per second. */
  bitrate(now) {
    return 8 * this.#bytes.at(now);
  }
}
