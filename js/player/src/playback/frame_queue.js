// The next frames, taken from the decoder ahead of their time. Drops frames that were decoded before a seek, and closes
// every frame that it does not return: few pictures may be open at once.

/** Maximum number of open frames in this thread, including the one being shown. */
const MAX_OPEN = 2;

export class FrameQueue {
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
  /** Whether the frame that was returned by shift is still open. */
  showing = false;

  /** arrived(frame): a frame, or null at the end. failed(error): no further frames follow. */
  constructor(decoder, arrived, failed, now) {
    this.#decoder = decoder;
    this.#arrived = arrived;
    this.#failed = failed;
    this.#now = now;
  }

  /** Whether arriving frames belong to the last seek. */
  get settled() {
    return this.#settled === this.#asked;
  }

  /** The next frame, until shift takes it. */
  get frame() {
    return this.#frames[0] ?? null;
  }
  get openFrames() {
    return this.#frames.length + (this.showing ? 1 : 0);
  }
  get ended() {
    return this.#finished && !this.#frames.length;
  }
  /** Milliseconds that the next frame has been awaited, or was awaited until it arrived. */
  get waited() {
    return this.#taking ? this.#now() - this.#since : this.#waited;
  }

  /** Requests the next frame if there is room for it. */
  fill() {
    if (this.#taking || this.openFrames >= MAX_OPEN || this.#finished || this.#closed || !this.settled) return;
    this.#since = this.#now();
    this.#taking = this.#take();
  }

  async #take() {
    let frame = null;
    let failure = null;
    try {
      frame = await this.#decoder.next();
    } catch (error) {
      failure = error;
    }
    this.#waited = this.waited;
    this.#taking = null;
    // The worker responds in order: frames before the response to the seek belong to the former place.
    if (this.#closed || !this.settled) {
      frame?.close();
      return;
    }
    if (failure) {
      this.#finished = true;
      this.#failed(failure);
      return;
    }
    if (frame) this.#frames.push(frame);
    else this.#finished = true;
    this.#arrived(frame);
  }

  /** Returns the next frame; the caller closes it. */
  shift() {
    return this.#frames.shift();
  }

  /** place: as Decoder.seek takes it. */
  async seek(place) {
    const request = ++this.#asked;
    this.#drop();
    try {
      // Without a worker, a frame of the former place can arrive after the response to the seek.
      if (!this.#decoder.inWorker) await this.#taking;
      await this.#decoder.seek(place);
    } catch (error) {
      if (this.#closed || request !== this.#asked) return;
      this.#settled = request;
      this.#failed(error);
      return;
    }
    if (this.#closed || request !== this.#asked) return;
    this.#settled = request;
    this.#since = this.#now();
    this.fill();
  }

  /** No further frames: the last one is on screen. */
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
