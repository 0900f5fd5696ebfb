// Promises of play() that are neither kept nor broken yet.

export class PendingPlays {
  #pending = [];

  add() {
    const promise = new Promise((resolve, reject) => this.#pending.push({ resolve, reject }));
    // Nobody has to wait for it.
    promise.catch(() => {});
    return promise;
  }
  keep() {
    for (const { resolve } of this.#pending.splice(0)) resolve();
  }
  break(name, message) {
    for (const { reject } of this.#pending.splice(0)) reject(new DOMException(message, name));
  }
}
