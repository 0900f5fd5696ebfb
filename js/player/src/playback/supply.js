// The one frame that comes next, taken from the decoder ahead of its time. It keeps frames apart that were decoded
// before a seek, and closes whatever it does not hand over: few pictures may be open at once.

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
  /** The next frame, until someone takes it. */
  frame = null;
  ended = false;

  /** arrived(): there is a frame, or the end, or a seek is done. failed(error): nothing follows. */
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

  /** Milliseconds that the next frame has been waited for, or was when it came. */
  get waited() {
    return this.#taking ? this.#now() - this.#since : this.#waited;
  }

  /** Has the next frame brought, when it is not here yet. */
  want() {
    if (this.#taking || this.frame || this.ended || this.#closed || !this.settled) return;
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
      this.ended = true;
      this.#failed(trouble);
      return;
    }
    this.frame = frame;
    this.ended = frame === null;
    this.#arrived();
  }

  /** Hands the frame over: who takes it closes it. */
  shift() {
    const { frame } = this;
    this.frame = null;
    return frame;
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
    this.ended = true;
  }

  #drop() {
    this.frame?.close();
    this.frame = null;
    this.ended = false;
  }

  close() {
    this.#closed = true;
    this.#drop();
    this.#decoder.close();
  }
}
