// The first frame of a stream with a ladder comes in the lowest rung, before the network was measured. It stays covered until it
// has come in the best rung that the network carries, or until its time is up.

/** Milliseconds from the beginning, and at least from the first frame, for which it may stay covered. */
const BUDGET_MS = 1000;
const LEAST_MS = 300;
/** Milliseconds between questions while little is known of the network: the first bytes are few, so that it seems slow. */
const ASK_MS = 40;

export class Opening {
  #better;
  #ask;
  #done;
  #asked = new Set(); // rungs
  #began = performance.now();
  #limit; // timer
  #timer = null;
  isOver = false;

  /**
   * better, ask: as Resting takes them. done(): called once, when the frame may be seen. spent: milliseconds since the source was
   * set.
   */
  constructor({ better, ask, done, spent }) {
    this.#better = better;
    this.#ask = ask;
    this.#done = done;
    this.#limit = setTimeout(() => this.end(), Math.max(LEAST_MS, BUDGET_MS - spent));
    this.#limit.unref?.();
    this.#try();
  }

  async #try() {
    const { rung, known } = await this.#better(this.#asked);
    if (this.isOver) return;
    if (rung !== null) {
      this.#asked.add(rung);
      this.#ask(rung);
    } else if (known && (this.#asked.size || performance.now() - this.#began >= LEAST_MS)) this.end();
    else this.#timer = setTimeout(() => this.#try(), ASK_MS);
  }
  /** The frame has come again. What was measured meanwhile may allow a still better rung. */
  came() {
    if (!this.isOver) this.#try();
  }
  end() {
    if (this.isOver) return;
    this.isOver = true;
    clearTimeout(this.#limit);
    clearTimeout(this.#timer);
    this.#done();
  }
}
