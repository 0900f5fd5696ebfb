// Which key does what: one table for who presses them and for who reads about them. Keys that move while they are held
// are in held_keys.js.

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
