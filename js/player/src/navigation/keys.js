// Keys and what they do: commands, and movements that last while a key is pressed.

/** keys: of KeyboardEvent.key, in small letters. */
export const COMMANDS = [
  { keys: [" ", "k"], shown: ["Space", "K"], says: "Play or pause", command: "togglePlay" },
  { keys: [",", "."], shown: [",", "."], says: "Frame back, frame forward", command: "step", values: [-1, 1] },
  { keys: ["j", "l"], shown: ["J", "L"], says: "5 seconds back, forward", command: "skip", values: [-5, 5] },
  {
    keys: ["home", "end"],
    shown: ["Home", "End"],
    says: "To the beginning, to the end",
    command: "jump",
    values: [0, 1],
  },
  { keys: ["<", ">"], shown: ["<", ">"], says: "Slower, faster", command: "changeSpeed", values: [-1, 1] },
  {
    keys: ["i", "o"],
    shown: ["I", "O"],
    says: "Loop from here, up to here",
    command: "markLoop",
    values: ["from", "to"],
  },
  { keys: ["u"], shown: ["U"], says: "No loop", command: "clearLoop" },
  { keys: ["g"], shown: ["G"], says: "Go live", command: "goLive" },
  { keys: ["[", "]"], shown: ["[", "]"], says: "Camera before, next camera", command: "nextCamera", values: [-1, 1] },
  {
    keys: [..."123456789"],
    shown: ["1–9"],
    says: "Look through a camera",
    command: "snapTo",
    values: [...Array(9).keys()],
  },
  { keys: ["0", "r"], shown: ["0", "R"], says: "Whole scene", command: "goHome" },
  { keys: ["n"], shown: ["N"], says: "Orbit or fly", command: "toggleFlying" },
  { keys: ["v"], shown: ["V"], says: "Next view mode", command: "nextMode" },
  { keys: ["c"], shown: ["C"], says: "Cameras", command: "toggleCameras" },
  { keys: ["t"], shown: ["T"], says: "Statistics", command: "toggleStats" },
  { keys: ["f"], shown: ["F"], says: "Full screen", command: "toggleFullscreen" },
  { keys: ["h", "?"], shown: ["H", "?"], says: "Keys", command: "toggleHelp" },
];
export const MOVES = [
  { shown: ["Arrows"], says: "Orbit; with Shift, pan" },
  { shown: ["+", "−"], says: "Nearer, further away" },
  { shown: ["W", "A", "S", "D"], says: "Fly forward, left, back, right; faster with Shift" },
  { shown: ["Q", "E"], says: "Fly down, up" },
];

const TEXT_INPUTS = /^(?!button|checkbox|radio|range|color|file|image|reset|submit)/;

/** Whether keys are typed into it. */
export function takesText(target) {
  if (!target?.tagName) return false;
  const { tagName } = target;
  if (tagName === "INPUT") return TEXT_INPUTS.test(target.type);
  return tagName === "TEXTAREA" || tagName === "SELECT" || target.isContentEditable === true;
}
const PRESSES = [" ", "enter"];
const SLIDES = /^(arrow|home|end|page|[+\-])/;

/** Whether the element that has the focus does something of its own with a key. */
export function keepsKey(target, key) {
  if (takesText(target)) return true;
  const { tagName, type } = target ?? {};
  if (tagName === "BUTTON" || tagName === "A" || tagName === "SUMMARY") return PRESSES.includes(key);
  if (tagName !== "INPUT") return false;
  if (type === "range" || type === "radio") return SLIDES.test(key) || (type === "radio" && PRESSES.includes(key));
  return PRESSES.includes(key);
}

/** {command, value} of a key; null: it does nothing. */
export function commandOf(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  const key = event.key.toLowerCase();
  for (const { keys, command, values } of COMMANDS) {
    const i = keys.indexOf(key);
    if (i >= 0) return { command, value: values?.[i] };
  }
  return null;
}

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
