// How long it takes until a frame that is shown now is on the screen, by measurement: its pictures are uploaded, the next
// animation frame draws it, and the one after that begins when it is there.

/** Number of measurements of which the median counts. */
const COUNT = 15;
/** Milliseconds: longer ones are pauses. */
const LONGEST = 150;
/** Milliseconds between pictures of most screens. */
const REFRESH = 1000 / 60;

class Median {
  #values;
  /** first: until there are measurements. */
  constructor(first) {
    this.#values = [first, first, first, first, first];
    this.value = first;
  }
  add(value) {
    if (value > LONGEST) return;
    this.#values.push(value);
    if (this.#values.length > COUNT) this.#values.shift();
    this.value = [...this.#values].sort((a, b) => a - b)[this.#values.length >> 1];
  }
}

export class ScreenDelay {
  #delay = new Median(2 * REFRESH);
  #refresh = new Median(REFRESH);
  #last = null; // the last animation frame, if it was followed by another one
  #uploaded = null; // when the frame that the next animation frame draws was taken
  #drawn = null; // the same of the frame that the last one has drawn

  /** Milliseconds: from taking a frame to the screen, and between pictures of the screen. */
  get value() {
    return { delay: this.#delay.value, refresh: this.#refresh.value };
  }

  /** The pictures of a frame that was taken at this time are uploaded. */
  uploaded(taken) {
    this.#uploaded = taken;
  }

  /** An animation frame of this time draws. continues: another one follows immediately. */
  draws(now, continues) {
    if (this.#last !== null) {
      this.#refresh.add(now - this.#last);
      if (this.#drawn !== null) this.#delay.add(now - this.#drawn);
    }
    this.#drawn = continues ? this.#uploaded : null;
    this.#uploaded = null;
    this.#last = continues ? now : null;
  }
}
