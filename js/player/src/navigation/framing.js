// The view that one comes to: the first mesh as a whole, from where the first camera stands.

import { toSpherical } from "./axes.js";
import { directionsOf, pan, poseFromOrbit } from "./pose.js";
import { dot, length, normalise, subtract } from "./vectors.js";

export const FIELD_OF_VIEW = (45 * Math.PI) / 180;
/** Of the picture's width and height that the scene may take, and by how much it stands above the middle: controls are below. */
const WIDTH = 0.9;
const HEIGHT = 0.76;
const RAISED = 0.06;

/** Of a place where there is neither. */
export const NOTHING = { centre: [0, 0, 0], radius: 1, low: [-1, -1, -1], high: [1, 1, 1] };

/** {centre, radius, low, high} of a mesh; of the cameras where there is none. */
export function extentOf(frame) {
  const points = frame.mesh?.positions.length ? frame.mesh.positions : frame.cameras.flatMap(({ centre }) => centre);
  if (!points.length) return NOTHING;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i++) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  return {
    centre: low.map((x, i) => (x + high[i]) / 2),
    radius: Math.max(length(subtract(high, low)) / 2, 1e-6),
    low,
    high,
  };
}

const cornersOf = ({ low, high }) =>
  Array.from({ length: 8 }, (_, i) => low.map((x, axis) => ((i >> axis) & 1 ? high[axis] : x)));

/** aspect: width of the picture over its height. */
export function homePose(extent, cameras, axes, aspect) {
  const { centre } = extent;
  const from = cameras.length ? subtract(cameras[0].centre, centre) : [1, 1, 1];
  const { theta, phi } = toSpherical(axes, normalise(from));
  const ahead = poseFromOrbit({ theta, phi, radius: 1 }, centre, FIELD_OF_VIEW, axes);
  const { forward, right, up } = directionsOf(ahead);
  const tangent = Math.tan(FIELD_OF_VIEW / 2);
  const distances = cornersOf(extent).map((corner) => {
    const at = subtract(corner, centre);
    const wide = Math.abs(dot(at, right)) / (tangent * aspect * WIDTH);
    const high = Math.abs(dot(at, up)) / (tangent * HEIGHT);
    return Math.max(wide, high) - dot(at, forward);
  });
  const radius = Math.max(...distances, 1e-6);
  const pose = poseFromOrbit({ theta, phi, radius }, centre, FIELD_OF_VIEW, axes);
  return pan(pose, 0, -RAISED);
}
