// What draw() may be told, and what holds when it is not.

import { BEST, THRESHOLD } from "@fvv/shading";

import { MODES } from "./surface_shaders.js";

export const MOST_BEST = 8;

const defaults = {
  mode: "textured",
  visibleBy: "auto",
  cameras: null,
  threshold: THRESHOLD,
  best: BEST,
  soft: 0,
  shadows: true,
  environment: true,
  clearColour: [0, 0, 0, 1],
  frusta: null,
  grid: null,
};

const within = (name, value, least, most) => {
  if (!(value >= least && value <= most)) throw new RangeError(`${name}: expected ${least} to ${most}, found ${value}`);
};

/** Options with everything in its place; cameras as a Set. */
export function complete(given = {}) {
  const options = { ...defaults };
  for (const [name, value] of Object.entries(given)) if (value !== undefined) options[name] = value;
  if (!(options.mode in MODES)) throw new TypeError(`mode: expected one of ${Object.keys(MODES).join(", ")}`);
  within("threshold", options.threshold, 0, 1);
  within("soft", options.soft, 0, 1);
  within("best", options.best, 1, MOST_BEST);
  if (!Number.isInteger(options.best)) throw new RangeError(`best: expected a whole number, found ${options.best}`);
  options.cameras = options.cameras && new Set(options.cameras);
  return options;
}

/** The same text for the same picture of the same content; cameras of frusta are compared by who they are. */
export function keyOf(view, { cameras, frusta, ...others }) {
  const { cameras: drawn, ...outlines } = frusta ?? {};
  return JSON.stringify([view, cameras && [...cameras].sort(), frusta && outlines, others]);
}
