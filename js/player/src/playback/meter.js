// Figures of playing: what was shown and dropped, and rates over the last seconds.

/** Milliseconds that rates are taken over. */
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
  /** A second. */
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
  /** Milliseconds of the frame that was shown last: meshes, visibility and calibration; and all of showing. */
  decodeMs = 0;
  showMs = 0;
  memoryBytes = 0;
  queued = 0;
  bytesRead = null;

  shown(now, { decodeMs, showMs }) {
    this.framesShown++;
    this.#shown.add(now, 1);
    // Smoothed: figures that jump with every frame can't be read.
    const share = this.framesShown === 1 ? 1 : 0.1;
    this.decodeMs += share * (decodeMs - this.decodeMs);
    this.showMs += share * (showMs - this.showMs);
  }
  dropped(count = 1) {
    this.framesDropped += count;
  }
  /** Of Decoder.stats. Answers whether bytes have come. */
  decoder(now, { bytesRead, memoryBytes, queued }) {
    const more = bytesRead !== null && bytesRead !== this.#read;
    if (bytesRead !== null && this.#read !== null && bytesRead >= this.#read)
      this.#bytes.add(now, bytesRead - this.#read);
    this.#read = bytesRead;
    Object.assign(this, { bytesRead, memoryBytes, queued });
    return more;
  }
  /** The next figures are those of another decoder. */
  begin() {
    this.#read = null;
  }
  framesPerSecond(now) {
    return this.#shown.at(now);
  }
  /** Bits a second that came. */
  bitrate(now) {
    return 8 * this.#bytes.at(now);
  }
}
