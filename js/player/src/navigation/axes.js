// Which way is up in a stream, and spherical coordinates about it, as <model-viewer> has them: theta from the front to
// the right, phi down from above. With y up the front is +z and the right +x, as in glTF.

import { add, cross, dot, length, normalise, scale } from "./vectors.js";

const NAMED = {
  y: { up: [0, 1, 0], front: [0, 0, 1] },
  "-y": { up: [0, -1, 0], front: [0, 0, -1] },
  z: { up: [0, 0, 1], front: [0, -1, 0] },
  "-z": { up: [0, 0, -1], front: [0, 1, 0] },
  x: { up: [1, 0, 0], front: [0, 0, 1] },
  "-x": { up: [-1, 0, 0], front: [0, 0, 1] },
};

export function axesFrom(up, front) {
  const right = normalise(cross(up, front), [1, 0, 0]);
  return { up, right, front: cross(right, up) };
}

/** upAxis: of the configuration; where it is unknown, cameras are taken to stand upright. */
export function axesOf(upAxis, cameras) {
  const named = NAMED[upAxis];
  if (named) return axesFrom(named.up, named.front);
  const sum = cameras.reduce((all, { rotation: r }) => add(all, [-r[3], -r[4], -r[5]]), [0, 0, 0]);
  const up = normalise(sum, [0, 1, 0]);
  // Any front will do that is not up.
  return axesFrom(up, Math.abs(up[2]) < 0.9 ? [0, 0, 1] : [0, -1, 0]);
}

export function toSpherical({ up, front, right }, offset) {
  const radius = length(offset);
  const across = [dot(offset, right), dot(offset, front)];
  return {
    theta: Math.hypot(...across) > 1e-9 * radius ? Math.atan2(...across) : 0,
    phi: Math.acos(Math.min(1, Math.max(-1, dot(offset, up) / (radius || 1)))),
    radius,
  };
}

export function fromSpherical({ up, front, right }, { theta, phi, radius }) {
  const level = radius * Math.sin(phi);
  return add(
    scale(up, radius * Math.cos(phi)),
    add(scale(front, level * Math.cos(theta)), scale(right, level * Math.sin(theta))),
  );
}
