// Tells when what is waited for has not come for a while.

const STALLED_MS = 3000;

export class StallWatch {
  #stalled;
  #timer = null;

  constructor(stalled) {
    this.#stalled = stalled;
  }
  /** Something has come, or is waited for from now on. */
  begin() {
    this.end();
    this.#timer = setTimeout(this.#stalled, STALLED_MS);
    this.#timer.unref?.();
  }
  end() {
    clearTimeout(this.#timer);
  }
}
