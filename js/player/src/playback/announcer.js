// Events as media elements have them: told when whoever caused them is done, and not any more once they are forgotten.

export class Announcer extends EventTarget {
  #turn = 0;

  announce(...types) {
    const turn = this.#turn;
    queueMicrotask(() => {
      if (turn === this.#turn) for (const type of types) this.dispatchEvent(new Event(type));
    });
  }
  /** What has not been told yet is not told. */
  forget() {
    this.#turn++;
  }
}
