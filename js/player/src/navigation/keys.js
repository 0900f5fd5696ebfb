// Keys and what they do: commands, and movements that last while a key is pressed.

/** The table of commands, for key presses and for the help. keys: KeyboardEvent.key in lower case. */
export const COMMANDS = [
  { keys: [" ", "k"], shown: ["Space", "K"], description: "Play or pause", command: "togglePlay" },
  { keys: [",", "."], shown: [",", "."], description: "Frame back, frame forward", command: "step", values: [-1, 1] },
  { keys: ["j", "l"], shown: ["J", "L"], description: "5 seconds back, forward", command: "skip", values: [-5, 5] },
  {
    keys: ["home", "end"],
    shown: ["Home", "End"],
    description: "Go to the beginning, to the end",
    command: "jump",
    values: [0, 1],
  },
  { keys: ["<", ">"], shown: ["<", ">"], description: "Slower, faster", command: "changeSpeed", values: [-1, 1] },
  {
    keys: ["i", "o"],
    shown: ["I", "O"],
    description: "Loop start, loop end",
    command: "markLoop",
    values: ["from", "to"],
  },
  { keys: ["x"], shown: ["X"], description: "Sound on or off", command: "toggleSound" },
  { keys: ["u"], shown: ["U"], description: "Clear loop", command: "clearLoop" },
  { keys: ["g"], shown: ["G"], description: "Go live", command: "goLive" },
  {
    keys: ["[", "]"],
    shown: ["[", "]"],
    description: "Previous camera, next camera",
    command: "nextCamera",
    values: [-1, 1],
  },
  {
    keys: [..."123456789"],
    shown: ["1–9"],
    description: "Look through a camera",
    command: "snapTo",
    values: [...Array(9).keys()],
  },
  { keys: ["0", "r"], shown: ["0", "R"], description: "Whole scene", command: "goHome" },
  { keys: ["n"], shown: ["N"], description: "Orbit or fly", command: "toggleFlying" },
  { keys: ["v"], shown: ["V"], description: "Next view mode", command: "nextMode" },
  { keys: ["c"], shown: ["C"], description: "Cameras", command: "toggleCameras" },
  { keys: ["m"], shown: ["M"], description: "Pictures of all cameras", command: "toggleSheet" },
  { keys: ["t"], shown: ["T"], description: "Statistics", command: "toggleStats" },
  { keys: ["f"], shown: ["F"], description: "Full screen", command: "toggleFullscreen" },
  { keys: ["h", "?"], shown: ["H", "?"], description: "Keys", command: "toggleHelp" },
];
export const MOVES = [
  { shown: ["Arrows"], description: "Orbit; with Shift, pan" },
  { shown: ["+", "−"], description: "Closer, farther away" },
  { shown: ["W", "A", "S", "D"], description: "Fly forward, left, back, right; faster with Shift" },
  { shown: ["Q", "E"], description: "Fly down, up" },
];

const TEXT_INPUTS = /^(?!button|checkbox|radio|range|color|file|image|reset|submit)/;

/** Whether an element takes text. */
export function takesText(target) {
  if (!target?.tagName) return false;
  const { tagName } = target;
  if (tagName === "INPUT") return TEXT_INPUTS.test(target.type);
  return tagName === "TEXTAREA" || tagName === "SELECT" || target.isContentEditable === true;
}
const PRESSES = [" ", "enter"];
const SLIDES = /^(arrow|home|end|page|[+\-])/;

/** Whether the focused element handles a key itself. */
export function keepsKey(target, key) {
  if (takesText(target)) return true;
  const { tagName, type } = target ?? {};
  if (tagName === "BUTTON" || tagName === "A" || tagName === "SUMMARY") return PRESSES.includes(key);
  if (tagName !== "INPUT") return false;
  if (type === "range" || type === "radio") return SLIDES.test(key) || (type === "radio" && PRESSES.includes(key));
  return PRESSES.includes(key);
}

/** {command, value} of a key; null: none. */
export function commandOf(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  const key = event.key.toLowerCase();
  for (const { keys, command, values } of COMMANDS) {
    const i = keys.indexOf(key);
    if (i >= 0) return { command, value: values?.[i] };
  }
  return null;
}

const TURN = Math.PI / 2; // radians per second
const TAP = 0.07; // radians
const PAN = 0.8; // heights of the picture per second
const DOLLY = 1;
/** Sizes of the scene per second. */
const FLY = 0.7;
const FASTER = 3;
/** Milliseconds until a pressed key moves continuously. */
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

/** Keys that move the viewer: arrows, and letters at the same places on every keyboard. A tap moves a little, holding moves
 * continuously. */
export class MovementKeys {
  #navigator;
  #pressed = new Map();
  flying = false;

  constructor(navigator) {
    this.#navigator = navigator;
  }

  /** The movement of a key: {name, amount: per second, tap: at once}; null: none. */
  #meaning({ code, key, shiftKey }) {
    const arrow = ARROWS[code];
    if (arrow) {
      const names = shiftKey ? ["panX", "panY"] : this.flying ? ["lookTheta", "lookPhi"] : ["theta", "phi"];
      const name = names.find((one) => one in arrow);
      const [rate, tap] = shiftKey ? [PAN, 0.04] : [TURN, TAP];
      return { name, amount: arrow[name] * rate, tap: arrow[name] * tap };
    }
    if (key in NEARER) return { name: "dolly", amount: NEARER[key] * DOLLY, tap: NEARER[key] * 0.08 };
    const [name, sign] = FLIGHT[code] ?? [];
    if (!name) return null;
    const size = this.#navigator.extent.radius * sign;
    return { name, amount: FLY * size * (shiftKey ? FASTER : 1), tap: 0.04 * size };
  }

  /** Returns whether the key is a movement key. */
  press(event) {
    const meaning = this.#meaning(event);
    if (!meaning) return false;
    if (event.repeat && this.#pressed.has(event.code)) return true;
    this.release(event);
    const { name, amount, tap } = meaning;
    this.#navigator.nudge(name, tap);
    const pressed = { name, amount, drifting: false };
    pressed.timer = setTimeout(() => this.#drift(pressed), HOLD);
    this.#pressed.set(event.code, pressed);
    return true;
  }
  #drift(pressed) {
    pressed.drifting = true;
    this.#navigator.drift[pressed.name] += pressed.amount;
    this.#navigator.nudge(pressed.name, 0);
  }
  release({ code }) {
    const pressed = this.#pressed.get(code);
    if (!pressed) return;
    clearTimeout(pressed.timer);
    this.#pressed.delete(code);
    if (pressed.drifting) this.#navigator.drift[pressed.name] -= pressed.amount;
    if (!this.#pressed.size) this.releaseAll();
  }
  /** Without the focus, releases of keys are not reported. */
  releaseAll() {
    for (const { timer } of this.#pressed.values()) clearTimeout(timer);
    this.#pressed.clear();
    for (const name of Object.keys(this.#navigator.drift)) this.#navigator.drift[name] = 0;
  }
}
