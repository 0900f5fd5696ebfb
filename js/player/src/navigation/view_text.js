// Views as text: in attributes of the element, and as bookmarks in the address of its page.

import { length, subtract } from "@fvv/shading";

import { radiansOf } from "../view.js";
import { isPose } from "./pose.js";

const ANGLES = { deg: Math.PI / 180, rad: 1 };
const LENGTHS = { m: 1, cm: 0.01, mm: 0.001, "": 1 };
const TERM = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)([a-z%]*)$/i;

function parse(text, units, auto) {
  if (text === "auto") return auto;
  const [, number, unit] = TERM.exec(text) ?? [];
  if (number === undefined) return NaN;
  if (unit === "%") return (Number(number) / 100) * auto;
  return unit in units ? Number(number) * units[unit] : NaN;
}

function parseAll(text, kinds, autos) {
  const terms = text.trim().split(/\s+/);
  if (terms.length !== kinds.length) return null;
  const numbers = terms.map((term, i) => parse(term, kinds[i], autos[i]));
  return numbers.every(Number.isFinite) ? numbers : null;
}

/**
 * Cameras in attributes, in the manner of <model-viewer>: camera-orbit="30deg 75deg 4m", camera-target="0m 1m 0m",
 * field-of-view="45deg". "auto" means the value of the first view. auto: {theta, phi, radius}. null: invalid text.
 */
export function parseOrbit(text, auto) {
  const numbers = parseAll(text, [ANGLES, ANGLES, LENGTHS], [auto.theta, auto.phi, auto.radius]);
  return numbers && numbers[2] > 0 ? { theta: numbers[0], phi: numbers[1], radius: numbers[2] } : null;
}
export function parseTarget(text, auto) {
  return parseAll(text, [LENGTHS, LENGTHS, LENGTHS], auto);
}
export function parseFieldOfView(text, auto) {
  const numbers = parseAll(text, [ANGLES], [auto]);
  return numbers && numbers[0] > 0 && numbers[0] < Math.PI ? numbers[0] : null;
}

/** Digits after the point that show a thousandth of a length, at least least: scenes may be a millimetre in size. */
const digitsFor = (size, least) =>
  Math.min(20, Math.max(least, Number.isFinite(size) && size > 0 ? 3 - Math.floor(Math.log10(size)) : 0));
/** Without an exponent, which a unit could follow. */
const decimal = (x, digits) => {
  const text = x.toFixed(digits).replace(/0+$/, "").replace(/\.$/, "");
  return text === "-0" ? "0" : text;
};

const degrees = (radians) => `${Number(((radians * 180) / Math.PI).toFixed(2))}deg`;
const metres = (x, size) => `${decimal(x, digitsFor(size, 4))}m`;
export const formatOrbit = ({ theta, phi, radius }) => `${degrees(theta)} ${degrees(phi)} ${metres(radius, radius)}`;
/** size: of the scene. */
export const formatTarget = (target, size = 1) => target.map((x) => metres(x, size)).join(" ");
export const formatFieldOfView = degrees;

const short = (x, digits = 3) => decimal(x, digits);
const list = (vector, digits) => vector.map((x) => short(x, digits)).join(",");

/**
 * A time and a view as a part of a URL's fragment: #fvv=t:1.28;eye:1.2,1.6,3;at:0,1,0;up:0,1,0;fov:45. Other parts of the
 * fragment are kept. camera: identifier of the camera of the view, or null.
 */
export function formatBookmark({ seconds, pose, camera }) {
  const digits = digitsFor(length(subtract(pose.eye, pose.target)), 3);
  const view =
    camera !== null
      ? `camera:${camera}`
      : `eye:${list(pose.eye, digits)};at:${list(pose.target, digits)};up:${list(pose.up)};fov:${short(pose.fov)}`;
  return `t:${short(seconds)};${view}`;
}

/** {seconds, pose, camera}, each null if it is missing or invalid. */
export function parseBookmark(text) {
  const fields = Object.fromEntries(text.split(";").map((field) => field.split(":")));
  const numbers = (name) => (fields[name] ?? "").split(",").map((word) => (word === "" ? NaN : Number(word)));
  const [seconds] = numbers("t");
  const [camera] = numbers("camera");
  const pose = {
    eye: numbers("eye"),
    target: numbers("at"),
    up: numbers("up"),
    fov: numbers("fov")[0],
  };
  return {
    seconds: Number.isFinite(seconds) ? seconds : null,
    camera: Number.isInteger(camera) ? camera : null,
    pose: isPose({ ...pose, fov: radiansOf(pose.fov) }) ? pose : null,
  };
}

/** The value of a name in a fragment; null: none. */
export function findInHash(hash, name) {
  const part = hash
    .replace(/^#/, "")
    .split("&")
    .find((one) => one.startsWith(`${name}=`));
  if (part === undefined) return null;
  try {
    return decodeURIComponent(part.slice(name.length + 1));
  } catch {
    return null;
  }
}

export function putIntoHash(hash, name, text) {
  const others = hash
    .replace(/^#/, "")
    .split("&")
    .filter((one) => one && !one.startsWith(`${name}=`));
  return `#${[...others, `${name}=${text}`].join("&")}`;
}

/** Seconds. */
const JOURNEY = 0.6;

/** Bookmarks of a player in the address of its page, under its id, or "fvv" without one. */
export class Bookmarks {
  #player;

  constructor(player, signal) {
    this.#player = player;
    addEventListener("hashchange", () => this.#follow(), { signal });
  }

  get #name() {
    return this.#player.id || "fvv";
  }
  get #bookmark() {
    const text = this.#player.bookmarks ? findInHash(location.hash, this.#name) : null;
    return text === null ? null : parseBookmark(text);
  }

  /** Where playback begins: {seconds}, or null. */
  get place() {
    const seconds = this.#bookmark?.seconds ?? null;
    return seconds === null ? null : { seconds };
  }
  /** Moves to the view of the address, once there is a frame. */
  look(duration = 0) {
    const { camera, pose } = this.#bookmark ?? {};
    const player = this.#player;
    if (player.cameras.some(({ id, calibrated }) => id === camera && calibrated))
      player.snapToCamera(camera, { duration });
    else if (pose) player.setPose(pose, { duration });
  }
  #follow() {
    const { place } = this;
    if (place) this.#player.currentTime = place.seconds;
    if (this.#player.cameras.length) this.look(JOURNEY);
  }

  get text() {
    const { currentTime: seconds, camera } = this.#player;
    return formatBookmark({ seconds, pose: this.#player.getPose(), camera });
  }
  /** Puts the bookmark into the address and returns the address. */
  put() {
    const hash = putIntoHash(location.hash, this.#name, this.text);
    history.replaceState(history.state, "", hash);
    return location.href;
  }
}
