// The view that one comes to: the first mesh as a whole, from where the first camera stands.

import { toSpherical } from "./axes.js";
import { poseFromOrbit } from "./pose.js";
import { length, normalise, subtract } from "./vectors.js";

export const FIELD_OF_VIEW = (45 * Math.PI) / 180;
/** Of the sphere around the mesh, so that nothing touches the edge. */
const MARGIN = 1.08;

/** {centre, radius} of the sphere around the box of a mesh; of the cameras where there is none. */
export function extentOf(frame) {
  const points = frame.mesh?.positions.length ? frame.mesh.positions : frame.cameras.flatMap(({ centre }) => centre);
  if (!points.length) return { centre: [0, 0, 0], radius: 1 };
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i++) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  return {
    centre: low.map((x, i) => (x + high[i]) / 2),
    radius: Math.max(length(subtract(high, low)) / 2, 1e-6),
  };
}

/** aspect: width of the picture over its height. */
export function homePose({ centre, radius }, cameras, axes, aspect) {
  const from = cameras.length ? subtract(cameras[0].centre, centre) : [1, 1, 1];
  const { theta, phi } = toSpherical(axes, normalise(from));
  const half = Math.min(FIELD_OF_VIEW / 2, Math.atan(Math.tan(FIELD_OF_VIEW / 2) * aspect));
  return poseFromOrbit({ theta, phi, radius: (MARGIN * radius) / Math.sin(half) }, centre, FIELD_OF_VIEW, axes);
}
