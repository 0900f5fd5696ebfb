// The next frames, taken from the decoder ahead of their time. Drops frames that were decoded before a seek, and closes
// every frame that it does not return: few pictures may be open at once.

/** Frames in this thread: those that are in hand, and the one that is shown. */
const MOST = 2;

export class Supply {
  #decoder;
  #arrived;
  #failed;
  #now;
  #since = 0;
  #waited = 0;
  #taking = null;
  #asked = 0;
  #settled = 0;
  #closed = false;
  #frames = [];
  #finished = false;
  /** Whether the frame that was handed over is still open. */
  showing = false;

  /** arrived(frame): there is a frame, or, with null, the end. failed(error): nothing follows. */
  constructor(decoder, arrived, failed, now) {
    this.#decoder = decoder;
    this.#arrived = arrived;
    this.#failed = failed;
    this.#now = now;
  }

  /** Whether what comes belongs to the place that was sought last. */
  get settled() {
    return this.#settled === this.#asked;
  }

  /** The next frame, until someone takes it. */
  get frame() {
    return this.#frames[0] ?? null;
  }
  get held() {
    return this.#frames.length + (this.showing ? 1 : 0);
  }
  get ended() {
    return this.#finished && !this.#frames.length;
  }
  /** Milliseconds that the next frame has been waited for, or was when it came. */
  get waited() {
    return this.#taking ? this.#now() - this.#since : this.#waited;
  }

  /** Has the next frame brought, when there is room for it. */
  want() {
    if (this.#taking || this.held >= MOST || this.#finished || this.#closed || !this.settled) return;
    this.#since = this.#now();
    this.#taking = this.#take();
  }

  async #take() {
    let frame = null;
    let trouble = null;
    try {
      frame = await this.#decoder.next();
    } catch (error) {
      trouble = error;
    }
    this.#waited = this.waited;
    this.#taking = null;
    // The worker answers in order: what comes before it has answered the seek is of the former place.
    if (this.#closed || !this.settled) {
      frame?.close();
      return;
    }
    if (trouble) {
      this.#finished = true;
      this.#failed(trouble);
      return;
    }
    if (frame) this.#frames.push(frame);
    else this.#finished = true;
    this.#arrived(frame);
  }

  /** Hands the frame over: who takes it closes it. */
  shift() {
    return this.#frames.shift();
  }

  /** place: as Decoder.seek takes it. */
  async seek(place) {
    const mine = ++this.#asked;
    this.#drop();
    try {
      // Without a worker, a frame of the former place can come after the answer to the seek.
      if (!this.#decoder.inWorker) await this.#taking;
      await this.#decoder.seek(place);
    } catch (error) {
      if (this.#closed || mine !== this.#asked) return;
      this.#settled = mine;
      this.#failed(error);
      return;
    }
    if (this.#closed || mine !== this.#asked) return;
    this.#settled = mine;
    this.#since = this.#now();
    this.want();
  }

  /** Nothing comes any more: the last frame is on screen already. */
  finish() {
    this.#drop();
    this.#finished = true;
  }

  #drop() {
    for (const frame of this.#frames.splice(0)) frame.close();
    this.#finished = false;
  }

  close() {
    this.#closed = true;
    this.#drop();
    this.#decoder.close();
  }
}
