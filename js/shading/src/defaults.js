// What docs/fvvrender.md says of players where nobody says otherwise: the one place of these numbers.

/** Least cosine between the surface's normal and the ray to a camera that gives colour. */
export const THRESHOLD = 0.25;
/** Most cameras for a place. */
export const BEST = 3;
/** How far behind a depth map's sample a place is hidden: in pixels' breadths, and in what the surface recedes from one pixel to the next. */
export const BIAS = 0.2;
export const SLOPE = 0.5;
/** Display value of surface that no camera shows. */
export const UNSEEN = 0.5;
