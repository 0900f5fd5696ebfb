// What of the environment is between the viewer and the action, and fades; and floors, which can be seen from below.

import { cross, dot, pointsOf, subtract } from "@fvv/shading";

import { boundsOf } from "./matrices.js";

/** What is left of an obstacle, and of a floor from below. */
const OBSTACLE = 0.15;
const FLOOR = 0.4;
/** The length of a ray inside the action from which on what is before it fades wholly, relative to the action's longest side. */
const SOFT = 0.12;

/**
 * obstruction(point): how much a point is in the way, 0 to 1: the ray from the eye through it enters the box around the action
 * behind it. A floor before the action is not: rays leave it downwards.
 */
export const obstruction = /* glsl */ `
uniform vec3 eye, up;
uniform vec3 actionMin, actionMax;

float obstruction(vec3 point) {
  vec3 ray = point - eye;
  vec3 safe = mix(ray, vec3(1e-9), lessThan(abs(ray), vec3(1e-9)));
  vec3 a = (actionMin - eye) / safe, b = (actionMax - eye) / safe;
  vec3 low = min(a, b), high = max(a, b);
  float enters = max(max(low.x, low.y), low.z), leaves = min(min(high.x, high.y), high.z);
  vec3 sides = actionMax - actionMin;
  float soft = ${SOFT} * max(max(sides.x, sides.y), sides.z);
  return enters > 1.0 ? smoothstep(0.0, soft, (leaves - enters) * length(ray)) : 0.0;
}
// What is left of a point; 1: it is drawn before, with all that is opaque.
float opacity(vec3 point, vec3 normalToEye, bool isBack) {
  if (isBack) return dot(normalToEye, up) < -0.5 ? ${FLOOR} : 0.0;
  return 1.0 - ${1 - OBSTACLE} * obstruction(point);
}
`;

/** Whether the line from one place to another meets a triangle between them, on the side that is drawn. */
function meets(from, ray, [a, b, c], doubleSided) {
  const [ab, ac] = [subtract(b, a), subtract(c, a)];
  const normal = cross(ab, ac);
  const against = -dot(normal, ray);
  if (doubleSided ? against === 0 : !(against > 0)) return false;
  const offset = subtract(from, a);
  const t = dot(normal, offset) / against;
  if (!(t > 0 && t < 1)) return false;
  const turned = cross(offset, ray);
  const [u, v] = [dot(ac, turned) / against, -dot(ab, turned) / against];
  return u >= 0 && v >= 0 && u + v <= 1;
}

const apart = (a, b) => a.min.some((low, k) => low > b.max[k]) || b.min.some((low, k) => low > a.max[k]);

/** Places in a box, evenly spread and in no rows, so that narrow beams do not pass between them. */
const PLACES = 192;
/** Powers of the root of x^4 = x + 1. */
const STEPS = [0.8191725134, 0.6710436067, 0.5497004779];
const placesIn = ({ min, max }) =>
  Array.from({ length: PLACES }, (_, i) =>
    STEPS.map((step, k) => min[k] + ((0.5 + (i + 1) * step) % 1) * (max[k] - min[k])),
  );

/** How a viewer looks at the action, {min, max}: the rays to some places of it, and the box around them. */
export function sightOf(eye, action) {
  const between = {
    min: action.min.map((low, k) => Math.min(low, eye[k])),
    max: action.max.map((high, k) => Math.max(high, eye[k])),
  };
  return { eye, between, rays: placesIn(action).map((place) => subtract(place, eye)) };
}

/** Whether a part of an environment hides any of the places of a sight. bounds: of the part. */
export function hides(part, bounds, { eye, between, rays }) {
  if (apart(bounds, between)) return false;
  const points = pointsOf(part);
  const corner = (i) => points.subarray(3 * part.faces[i], 3 * part.faces[i] + 3);
  for (let i = 0; i < part.faces.length; i += 3) {
    const triangle = [corner(i), corner(i + 1), corner(i + 2)];
    if (apart(boundsOf(triangle.flatMap((place) => [...place])), between)) continue;
    if (rays.some((ray) => meets(eye, ray, triangle, part.doubleSided))) return true;
  }
  return false;
}

/** Whether the viewer is below the action. */
export function isBelow(eye, up, { min, max }) {
  const lowest = up.reduce((sum, x, k) => sum + x * (x > 0 ? min[k] : max[k]), 0);
  return dot(eye, up) < lowest;
}
