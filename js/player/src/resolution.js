// How many pixels are drawn for one of the page: as many as the screen has, up to two, and fewer while the pictures would
// come too slowly.

export const QUALITIES = ["auto", "high", "medium", "low"];
const MOST = 2;
const FIXED = { high: 2, medium: 1, low: 0.5 };
const STEPS = [1, 0.84, 0.7, 0.6, 0.5, 0.4];
/** Milliseconds from one picture to the next that are too many, and those that are few. */
const SLOW = 40;
const FAST = 21;
/** Pictures that decide, and the most milliseconds between two that belong together. */
const SLOW_COUNT = 4;
const FAST_COUNT = 90;
const APART = 3000;
/** Milliseconds from which on it goes down by leaps. */
const CRAWL = 120;

export class Resolution {
  #step = 0;
  #last = null;
  #mean = 16;
  #since = 0;
  quality = "auto";

  /** Of the pixels that the screen has. */
  get scale() {
    return this.quality === "auto" ? STEPS[this.#step] : 1;
  }

  /** now: milliseconds of a picture of the screen. goesOn: another one follows at once. */
  observe(now, goesOn) {
    const passed = this.#last === null ? Infinity : now - this.#last;
    this.#last = goesOn ? now : null;
    if (passed > APART) {
      this.#since = 0;
      return;
    }
    this.#mean += 0.25 * (passed - this.#mean);
    this.#since++;
    if (this.#mean > SLOW && this.#since >= SLOW_COUNT) this.#go(this.#mean > CRAWL ? 2 : 1);
    else if (this.#mean < FAST && this.#since >= FAST_COUNT) this.#go(-1);
  }
  #go(by) {
    this.#step = Math.min(Math.max(this.#step + by, 0), STEPS.length - 1);
    this.#since = 0;
  }

  /** hurried: while something moves. */
  ratio(devicePixelRatio, hurried) {
    const ratio = Math.min(devicePixelRatio, FIXED[this.quality] ?? MOST);
    return hurried ? ratio * this.scale : ratio;
  }
}
