// What draw() may be told, and what holds when it is not.

import { checkTexturing } from "@fvv/shading";

import { MODES } from "./surface_shaders.js";

const defaults = {
  mode: "textured",
  visibleBy: "auto",
  cameras: null,
  // Of these three the stream's (clause 17.5).
  threshold: undefined,
  best: undefined,
  unseen: undefined,
  soft: 0,
  shadows: true,
  environment: true,
  clearColour: [0, 0, 0, 1],
  frusta: null,
  grid: null,
};

/** Options with everything in its place; cameras as a Set. */
export function complete(given = {}) {
  const options = { ...defaults };
  for (const [name, value] of Object.entries(given)) if (value !== undefined) options[name] = value;
  if (!(options.mode in MODES)) throw new TypeError(`mode: expected one of ${Object.keys(MODES).join(", ")}`);
  checkTexturing(options);
  if (!(options.soft >= 0 && options.soft <= 1)) throw new RangeError(`soft: expected 0 to 1, found ${options.soft}`);
  options.cameras = options.cameras && new Set(options.cameras);
  return options;
}

/** The same text for the same picture of the same content; cameras of frusta are compared by who they are. */
export function keyOf(view, { cameras, frusta, ...others }) {
  const { cameras: drawn, ...outlines } = frusta ?? {};
  return JSON.stringify([view, cameras && [...cameras].sort(), frusta && outlines, others]);
}
