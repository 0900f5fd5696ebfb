// How many pixels are drawn per pixel of the page: as many as the screen has, up to two. While drawing is too slow, the surface
// is coloured at fewer pixels, and only then all of the picture has fewer.

const MOST = 2;
/** The resolution of the picture, and of the surface relative to that. */
const STEPS = [
  [1, 1],
  [1, 0.84],
  [1, 0.7],
  [1, 0.6],
  [1, 0.5],
  [1, 0.4],
  [0.75, 0.5],
  [0.55, 0.65],
  [0.4, 0.8],
];
/** Milliseconds between pictures that are too slow, and fast. */
const SLOW = 40;
const FAST = 21;
/** Numbers of pictures before a change, and the maximum milliseconds between consecutive pictures. */
const SLOW_COUNT = 4;
const FAST_COUNT = 90;
const MAX_INTERVAL = 3000;
/** Milliseconds above which the resolution is reduced by two steps. */
const VERY_SLOW = 120;

export class Resolution {
  #step = 0;
  #last = null;
  #mean = 16;
  #since = 0;
  /** "auto", or the most pixels for a pixel of the page. */
  pixelRatio = "auto";

  #scales(moving) {
    return moving && this.pixelRatio === "auto" ? STEPS[this.#step] : STEPS[0];
  }

  /** now: milliseconds of a picture of the screen. continues: another one follows immediately. */
  observe(now, continues) {
    const passed = this.#last === null ? Infinity : now - this.#last;
    this.#last = continues ? now : null;
    if (passed > MAX_INTERVAL) {
      this.#since = 0;
      return;
    }
    this.#mean += 0.25 * (passed - this.#mean);
    this.#since++;
    if (this.#mean > SLOW && this.#since >= SLOW_COUNT) this.#change(this.#mean > VERY_SLOW ? 2 : 1);
    else if (this.#mean < FAST && this.#since >= FAST_COUNT) this.#change(-1);
  }
  #change(by) {
    this.#step = Math.min(Math.max(this.#step + by, 0), STEPS.length - 1);
    this.#since = 0;
  }

  /** Of the picture. moving: during playback and movements. */
  ratio(devicePixelRatio, moving) {
    const ratio = Math.min(devicePixelRatio, this.pixelRatio === "auto" ? MOST : this.pixelRatio);
    return ratio * this.#scales(moving)[0];
  }
  /** Of the surface, relative to the picture. */
  surfaceScale(moving) {
    return this.#scales(moving)[1];
  }
}
