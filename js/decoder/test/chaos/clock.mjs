// Time of a simulation: timers, performance.now() and Date.now() of this thread, which jump to the next timer whenever nothing else
// is under way. Half an hour of waiting takes as long as what happens in it.

const real = {
  setTimeout,
  clearTimeout,
  setInterval,
  clearInterval,
  now: performance.now.bind(performance),
  date: Date.now,
};
/** Turns of the event loop without a timer's end: promises and threads of WebAssembly have gone on meanwhile. */
const TURNS = 4;

export class Clock {
  #timers = new Map(); // id -> {at, act}
  #next = 1;
  #running = true;
  #busy = 0;
  #epoch = real.date();
  now = 0;

  constructor() {
    globalThis.setTimeout = (act, milliseconds = 0, ...values) => {
      const id = this.#next++;
      this.#timers.set(id, { at: this.now + Math.max(0, Number(milliseconds) || 0), act: () => act(...values) });
      return id;
    };
    globalThis.clearTimeout = (id) => this.#timers.delete(id);
    performance.now = () => this.now;
    Date.now = () => this.#epoch + this.now;
    this.#run();
  }
  /** Time stands still until the promise has settled: for work of this machine, not of the network. */
  async during(promise) {
    this.#busy++;
    try {
      return await promise;
    } finally {
      this.#busy--;
    }
  }
  wait(milliseconds) {
    return new Promise((resolve) => setTimeout(resolve, milliseconds));
  }
  async #run() {
    while (this.#running) {
      for (let turn = 0; turn < TURNS; turn++) await new Promise((resolve) => setImmediate(resolve));
      if (this.#busy) continue;
      let first = null;
      for (const [id, timer] of this.#timers) if (!first || timer.at < first.at) first = { id, ...timer };
      if (!first) continue;
      this.#timers.delete(first.id);
      this.now = Math.max(this.now, first.at);
      first.act();
    }
  }
  end() {
    this.#running = false;
    Object.assign(globalThis, { setTimeout: real.setTimeout, clearTimeout: real.clearTimeout });
    performance.now = real.now;
    Date.now = real.date;
  }
}

/** Numbers from 0 to 1 that a seed decides. */
export function randomOf(seed) {
  let state = Math.imul(seed, 2654435761) + 1;
  const random = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
  const between = (low, high) => low + (high - low) * random();
  const pick = (list) => list[Math.floor(random() * list.length)];
  return { random, between, pick };
}
