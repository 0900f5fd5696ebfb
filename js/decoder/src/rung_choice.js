// Which rung of a stream is wanted, and what decides about it: the caller, how large pictures are shown, and the network.

import { Chooser, rungsOf } from "./ladder.js";

/** Times its duration that a part of the stream may take to arrive for one frame of it that stays on screen. */
const PATIENCE = 2;

export class RungChoice {
  #named;
  #key = null; // of the rungs, as text
  /** "auto", or a rung. */
  wanted;
  /** The rung of the next group alone, or null. */
  once = null;
  /** Pixels on the screen for a pixel of the cameras' pictures; null: not known. Rungs with more pixels are not chosen. */
  shownScale = null;
  chooser = new Chooser();
  /** Of the configuration that is played. */
  rungs = [];

  /** named(): rungs that the source names because each comes by itself, or null. */
  constructor(wanted, named) {
    this.wanted = wanted;
    this.#named = named;
  }

  /** Returns whether the configuration has other rungs than the one before. */
  learn(configuration) {
    const rungs = rungsOf(configuration);
    const key = JSON.stringify(rungs);
    if (key === this.#key) return false;
    this.#key = key;
    this.rungs = rungs;
    return true;
  }
  get all() {
    return this.#named() ?? this.rungs;
  }
  /** What GroupPrefetcher asks. seconds(ticks). */
  asked(seconds) {
    const wish = () => {
      const { once } = this;
      this.once = null;
      return once ?? (this.wanted === "auto" ? null : this.wanted);
    };
    return { chooser: this.chooser, wish, best: () => this.#bestShown(), seconds };
  }
  /** The smallest rung that has a pixel for each pixel of the screen, and of those of its size the best. */
  #bestShown() {
    const shown = this.shownScale;
    if (shown === null) return 0;
    const smallest = this.all.findLast(({ scale }) => scale === null || scale >= shown);
    return smallest ? this.all.findIndex(({ scale }) => scale === smallest.scale) : 0;
  }
  /**
   * The rung that is worth fetching for a frame that stays on screen: the one that is wanted, else the best that is shown and
   * that the network carries; it need not be as fast as playback, unless that follows. fetched: whether rungs are fetched one by
   * one. null: no ladder, or nothing was measured.
   */
  lasting(fetched, plays) {
    const rungs = this.all;
    if (rungs.length < 2) return null;
    if (!fetched || this.wanted !== "auto") return Math.min(this.wanted === "auto" ? 0 : this.wanted, rungs.length - 1);
    const carried = this.chooser.carries(rungs.map(({ bitRate }) => bitRate / (plays ? 1 : PATIENCE)));
    return carried === null ? null : Math.max(this.#bestShown(), carried);
  }
  /** Of a source that is read in order; null: there is no ladder. */
  get local() {
    if (this.rungs.length < 2) return null;
    return this.wanted === "auto" ? 0 : Math.min(this.wanted, this.rungs.length - 1);
  }
}
