// A frame that stays on screen: requested again in the best rung that the network carries, and as long as pictures of it are
// missing, because decoders of video lose some on a busy machine.

/** Milliseconds until the first attempt. Each one waits twice as long as the one before it, up to the last value. */
const FIRST_MS = 250;
const LONGEST_MS = 8000;
/** Attempts for one frame and one wish. */
const ATTEMPTS = 8;

export class Resting {
  #better;
  #ask;
  #timer = null;
  #turn = 0; // a frame or a wish that an answer is for
  #attempts = 0;
  #asked = new Set(); // rungs

  /**
   * better(asked): resolves to {rung, lacks}: a rung that is better than that of the frame on screen and not among those that
   * were requested, or null; whether pictures are missing. ask(rung): requests the frame again; what comes is shown if it is better.
   */
  constructor({ better, ask }) {
    this.#better = better;
    this.#ask = ask;
  }

  /** Another frame is on screen, and stays there. */
  begin() {
    this.end();
    this.#wait();
  }
  /** Another rung is wanted: at once. */
  hurry() {
    this.end();
    this.#try();
  }
  /** The frame does not stay. */
  end() {
    clearTimeout(this.#timer);
    this.#turn++;
    this.#attempts = 0;
    this.#asked.clear();
  }

  #wait() {
    if (this.#attempts >= ATTEMPTS) return;
    const delay = Math.min(LONGEST_MS, FIRST_MS * 2 ** this.#attempts);
    this.#timer = setTimeout(() => this.#try(), delay);
    this.#timer.unref?.();
  }
  async #try() {
    this.#attempts++;
    const turn = this.#turn;
    const { rung, lacks } = await this.#better(this.#asked);
    if (turn !== this.#turn) return;
    if (rung !== null) this.#asked.add(rung);
    if (rung !== null || lacks) this.#ask(rung);
    this.#wait();
  }
}
