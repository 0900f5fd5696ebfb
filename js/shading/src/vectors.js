// Vectors of three numbers.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(...a);
export const mix = (a, b, s) => a.map((x, i) => x + (b[i] - x) * s);

/** otherwise: the result for vectors too short to have a direction. */
export function normalise(a, otherwise = [0, 0, 1]) {
  const size = length(a);
  return size > 1e-12 ? a.map((x) => x / size) : otherwise;
}

/** null: the vector is 0. */
export function unit(a) {
  const size = length(a);
  return size > 0 ? scale(a, 1 / size) : null;
}
