// How colours are mixed: as the stream says (spec/fvv.md, clause 17.5), but for what the player's user asks for, in the units
// of the shaders.

/** Of the shaders: a stream that asks for more has this many. */
export const MOST_BEST = 8;

/** Display values, 0 to 1, of 0xRRGGBB. */
const displayed = (colour) => [16, 8, 0].map((shift) => ((colour >> shift) & 255) / 255);

/** Throws where an option cannot be; undefined, and of the colour null: the stream's. */
export function checkTexturing({ threshold = 0, best = 1, unseen }) {
  if (!(threshold >= 0 && threshold <= 1)) throw new RangeError(`threshold: expected 0 to 1, found ${threshold}`);
  if (!(Number.isInteger(best) && best >= 1 && best <= MOST_BEST))
    throw new RangeError(`best: expected a whole number from 1 to ${MOST_BEST}, found ${best}`);
  const colour = unseen ?? 0;
  if (!(Number.isInteger(colour) && colour >= 0 && colour <= 0xffffff))
    throw new RangeError(`unseen: expected a colour from 0 to 0xffffff, found ${unseen}`);
}

/** own: {threshold, best, unseen}, of which what is there takes the place of the stream's. */
export function texturingOf({ texturing }, own = {}) {
  return {
    threshold: own.threshold ?? texturing.threshold,
    best: own.best ?? Math.min(texturing.best, MOST_BEST),
    unseen: displayed(own.unseen ?? texturing.unseen),
    tolerance: [texturing.depthBias, texturing.depthSlope],
  };
}
