// WebGL contexts of all players of a page. A browser allows a page 16, or 8 on phones, and takes the oldest one without
// asking when there are more. Before that happens the player that has not drawn for longest gives its context back,
// those that are out of view first, and takes it again when it has to draw.

/** Leaves some to the page. */
const MOST = 12;
/** The browser took a context of one player while others kept theirs: its limit is lower. */
const FEWEST = 2;
/** Milliseconds after which it is known which ones were lost together, as with the whole device. */
const SETTLED_MS = 500;

/** holder: {visible, idle: whether it has not drawn for a while, giveBack()}. */
export class Contexts {
  #holders = new Set(); // the one that drew last is the last one
  #most;

  constructor(most = MOST) {
    this.#most = most;
  }
  get count() {
    return this.#holders.size;
  }

  /** Returns whether the holder may have a context now; another one may have to give back its own. */
  use(holder) {
    if (!this.#holders.delete(holder) && this.#holders.size >= this.#most) {
      const holders = [...this.#holders];
      const spare = holders.find(({ visible }) => !visible) ?? holders.find(({ idle }) => idle);
      if (!spare) return false;
      this.#holders.delete(spare);
      spare.giveBack();
    }
    this.#holders.add(holder);
    return true;
  }

  leave(holder) {
    this.#holders.delete(holder);
  }

  /** The browser has taken the context of a holder. */
  lost(holder) {
    this.#holders.delete(holder);
    setTimeout(() => {
      if (this.count >= FEWEST) this.#most = Math.min(this.#most, this.count);
    }, SETTLED_MS).unref?.();
  }
}

export const contexts = new Contexts();
