// Playback: takes frames from the decoder, shows the one that is due, and starts again at the end.

/** If frames are later than this, the clock waits for the decoder. */
const MAX_LATE_SECONDS = 0.25;

export class Playback {
  #decoder;
  #show;
  #fail;
  #next = null; // a frame that is not due yet
  #busy = false;
  #wanted = null; // number of the frame that is sought
  #began = null; // clock time in seconds at which time 0 of the stream would have been shown
  #ended = false;
  playing = false;

  /** show(frame): called with a frame that is due; the frame is closed when the returned promise is resolved. */
  constructor(decoder, show, fail) {
    this.#decoder = decoder;
    this.#show = show;
    this.#fail = fail;
  }

  play(playing) {
    this.playing = playing;
    this.#began = null;
  }

  /** Shows a frame by its number; the last call wins. */
  seek(number) {
    this.#wanted = number;
    this.#advance();
  }

  /** due: a frame to show. Only one call is active at a time; frames are closed when they have been shown. */
  async #advance(due = null) {
    if (this.#busy) return;
    this.#busy = true;
    try {
      if (due) await this.#present(due);
      while (this.#wanted !== null) await this.#find(this.#wanted);
      if (!this.#next && !this.#ended) {
        this.#next = await this.#decoder.next();
        this.#ended = this.#next === null;
      }
    } catch (error) {
      this.playing = false;
      this.#fail(error);
    }
    this.#busy = false;
    if (this.#wanted !== null) this.#advance();
  }

  async #find(number) {
    this.#next?.close();
    this.#next = null;
    this.#ended = false;
    await this.#decoder.seek({ frame: number });
    const frame = await this.#decoder.next();
    if (this.#wanted === number) this.#wanted = null;
    if (frame) await this.#present(frame);
    this.#began = null;
  }

  async #present(frame) {
    await this.#show(frame);
    frame.close();
  }

  /** Called for each picture of the screen. now: seconds. */
  tick(now) {
    if (!this.playing || this.#busy) return;
    const frame = this.#next;
    if (!frame) return this.#ended && this.#decoder.seekable ? this.seek(0) : this.#advance();
    if (this.#began === null || now - this.#began - frame.seconds > MAX_LATE_SECONDS) this.#began = now - frame.seconds;
    if (now - this.#began < frame.seconds) return;
    this.#next = null;
    this.#advance(frame);
  }
}
