// Time of a simulation: timers, animation frames, performance.now() and Date.now() of this thread, in Node or in a page. It jumps to
// the next timer whenever nothing else is under way. Half an hour of waiting takes as long as what happens in it.

const names = "setTimeout clearTimeout setInterval clearInterval requestAnimationFrame cancelAnimationFrame".split(" ");
const real = Object.fromEntries(names.map((name) => [name, globalThis[name]]));
const realNow = performance.now.bind(performance);
const realDate = Date.now;

/** Turns of the event loop without a timer's end: promises and threads of WebAssembly have gone on meanwhile. */
const TURNS = 4;
/** Milliseconds between two pictures of the screen. */
const REFRESH = 40;

/** A turn of the event loop. Browsers have no setImmediate, and their timers wait. */
function turns() {
  if (globalThis.setImmediate) return () => new Promise((resolve) => setImmediate(resolve));
  const { port1, port2 } = new MessageChannel();
  return () =>
    new Promise((resolve) => {
      port1.onmessage = resolve;
      port2.postMessage(null);
    });
}

export class Clock {
  #timers = new Map(); // id -> {at, act}
  #next = 1;
  #running = true;
  #busy = 0;
  #isAtWork;
  #epoch = realDate();
  now = 0;

  /** isAtWork(milliseconds of this machine): while it returns true, time stands still. */
  constructor({ isAtWork = () => false } = {}) {
    this.#isAtWork = isAtWork;
    const after = (milliseconds, act) => {
      const id = this.#next++;
      this.#timers.set(id, { at: this.now + Math.max(0, Number(milliseconds) || 0), act });
      return id;
    };
    const forget = (id) => void this.#timers.delete(id);
    globalThis.setTimeout = (act, milliseconds, ...values) => after(milliseconds, () => act(...values));
    globalThis.setInterval = (act, milliseconds, ...values) => {
      const id = after(milliseconds, () => act(...values));
      this.#timers.get(id).every = Math.max(1, Number(milliseconds) || 0);
      return id;
    };
    globalThis.clearTimeout = globalThis.clearInterval = forget;
    if (real.requestAnimationFrame) {
      const next = () => REFRESH - (this.now % REFRESH);
      globalThis.requestAnimationFrame = (act) => after(next(), () => act(this.now));
      globalThis.cancelAnimationFrame = forget;
    }
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
    const turn = turns();
    while (this.#running) {
      for (let i = 0; i < TURNS; i++) await turn();
      if (this.#busy || this.#isAtWork(realNow())) continue;
      let first = null;
      for (const [id, timer] of this.#timers) if (!first || timer.at < first.timer.at) first = { id, timer };
      if (!first) continue;
      const { id, timer } = first;
      this.now = Math.max(this.now, timer.at);
      if (timer.every) timer.at += timer.every;
      else this.#timers.delete(id);
      timer.act();
    }
  }
  end() {
    this.#running = false;
    for (const name of names) if (real[name]) globalThis[name] = real[name];
    performance.now = realNow;
    Date.now = realDate;
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
