// Keys that move while they are held: arrows and letters, the same places on every keyboard. A short touch moves a
// little; holding goes on.

const TURN = Math.PI / 2; // radians a second
const TOUCH = 0.07; // radians
const PAN = 0.8; // heights of the picture a second
const DOLLY = 1;
/** Sizes of the scene a second. */
const FLY = 0.7;
const FASTER = 3;
/** Milliseconds until it is held. */
const HOLD = 160;

const ARROWS = {
  ArrowLeft: { theta: -1, panX: 1, lookTheta: 1 },
  ArrowRight: { theta: 1, panX: -1, lookTheta: -1 },
  ArrowUp: { phi: -1, panY: 1, lookPhi: -1 },
  ArrowDown: { phi: 1, panY: -1, lookPhi: 1 },
};
const FLIGHT = {
  KeyW: ["forward", 1],
  KeyS: ["forward", -1],
  KeyA: ["right", -1],
  KeyD: ["right", 1],
  KeyE: ["up", 1],
  KeyQ: ["up", -1],
};
const NEARER = { "+": -1, "=": -1, "-": 1, _: 1 };

export class HeldKeys {
  #navigator;
  #held = new Map();
  flying = false;

  constructor(navigator) {
    this.#navigator = navigator;
  }

  /** What a key asks for: {name: of the drift, amount: a second, touch: at once}; null: nothing. */
  #meaning({ code, key, shiftKey }) {
    const arrow = ARROWS[code];
    if (arrow) {
      const names = shiftKey ? ["panX", "panY"] : this.flying ? ["lookTheta", "lookPhi"] : ["theta", "phi"];
      const name = names.find((one) => one in arrow);
      const [rate, touch] = shiftKey ? [PAN, 0.04] : [TURN, TOUCH];
      return { name, amount: arrow[name] * rate, touch: arrow[name] * touch };
    }
    if (key in NEARER) return { name: "dolly", amount: NEARER[key] * DOLLY, touch: NEARER[key] * 0.08 };
    const [name, sign] = FLIGHT[code] ?? [];
    if (!name) return null;
    const size = this.#navigator.extent.radius * sign;
    return { name, amount: FLY * size * (shiftKey ? FASTER : 1), touch: 0.04 * size };
  }

  /** Whether the key was one of these. */
  press(event) {
    const meaning = this.#meaning(event);
    if (!meaning) return false;
    if (event.repeat && this.#held.has(event.code)) return true;
    this.release(event);
    const { name, amount, touch } = meaning;
    this.#navigator.nudge(name, touch);
    const held = { name, amount, drifting: false };
    held.timer = setTimeout(() => this.#drift(held), HOLD);
    this.#held.set(event.code, held);
    return true;
  }
  #drift(held) {
    held.drifting = true;
    this.#navigator.drift[held.name] += held.amount;
    this.#navigator.nudge(held.name, 0);
  }
  release({ code }) {
    const held = this.#held.get(code);
    if (!held) return;
    clearTimeout(held.timer);
    this.#held.delete(code);
    if (held.drifting) this.#navigator.drift[held.name] -= held.amount;
    if (!this.#held.size) this.releaseAll();
  }
  /** The focus is elsewhere: nobody will tell that keys are let go. */
  releaseAll() {
    for (const { timer } of this.#held.values()) clearTimeout(timer);
    this.#held.clear();
    for (const name of Object.keys(this.#navigator.drift)) this.#navigator.drift[name] = 0;
  }
}
