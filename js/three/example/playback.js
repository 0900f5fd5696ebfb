// Frames in their time: takes them from the decoder, shows the one that is due, begins anew at the end.

/** Behind by more than this, the clock waits for the decoder. */
const PATIENCE_SECONDS = 0.25;

export class Playback {
  #decoder;
  #show;
  #next = null; // a frame that is not due yet
  #taking = false;
  #wanted = null; // a frame number that is sought
  #began = 0; // clock in seconds at which time 0 of the stream would have been shown
  #ended = false;
  playing = false;

  /** show(frame): is called with a frame that is due, and may keep it until it returns. */
  constructor(decoder, show, fail) {
    Object.assign(this, { fail });
    this.#decoder = decoder;
    this.#show = show;
  }

  play(playing) {
    this.playing = playing;
    this.#began = null;
  }

  /** Shows a frame, by its number; the last that is asked for wins. */
  seek(number) {
    this.#wanted = number;
    this.#run();
  }

  async #run() {
    if (this.#taking) return;
    this.#taking = true;
    try {
      while (this.#wanted !== null) {
        const number = this.#wanted;
        this.#drop();
        this.#ended = false;
        await this.#decoder.seek({ frame: number });
        const frame = await this.#decoder.next();
        if (this.#wanted === number) this.#wanted = null;
        if (frame) this.#present(frame);
        this.#began = null;
      }
      if (!this.#next && !this.#ended) {
        this.#next = await this.#decoder.next();
        if (!this.#next) this.#ended = true;
      }
    } catch (error) {
      this.playing = false;
      this.fail(error);
    }
    this.#taking = false;
    if (this.#wanted !== null) this.#run();
  }

  #drop() {
    this.#next?.close();
    this.#next = null;
  }
  #present(frame) {
    this.#show(frame);
    frame.close();
  }

  /** Once for each picture of the screen. now: seconds. */
  tick(now) {
    if (!this.playing || this.#taking) return;
    if (this.#next) {
      const frame = this.#next;
      if (this.#began === null || now - this.#began - frame.seconds > PATIENCE_SECONDS)
        this.#began = now - frame.seconds;
      if (now - this.#began < frame.seconds) return;
      this.#next = null;
      this.#present(frame);
    } else if (this.#ended && this.#decoder.seekable) {
      return this.seek(0);
    }
    this.#run();
  }
}
