// Matrices for WebGL, by columns, from viewers and lamps.

import { cross, dot, nearPlaneOf, normalise } from "@fvv/shading";

/** Bounds of points x y z, [min, max] of each axis; null without points. */
export function boundsOf(positions) {
  if (!positions.length) return null;
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i += 3)
    for (let k = 0; k < 3; k++) {
      const value = positions[i + k];
      if (value < min[k]) min[k] = value;
      if (value > max[k]) max[k] = value;
    }
  return { min, max };
}

/** Bounds by an offset. */
export function moved({ min, max }, by) {
  return { min: min.map((value, k) => value + by[k]), max: max.map((value, k) => value + by[k]) };
}

export function joined(a, b) {
  if (!a || !b) return a ?? b;
  return {
    min: a.min.map((value, k) => Math.min(value, b.min[k])),
    max: a.max.map((value, k) => Math.max(value, b.max[k])),
  };
}

/** {centre, radius} of the sphere around a box. */
export function sphereOf({ min, max }) {
  const centre = min.map((value, k) => (value + max[k]) / 2);
  return { centre, radius: Math.hypot(...max.map((value, k) => value - min[k])) / 2 };
}

/** Minimum and maximum depth of a box in a view. */
function depthsOf({ min, max }, { rotation: r, translation: t }) {
  let near = t[2];
  let far = t[2];
  for (let k = 0; k < 3; k++) {
    const [a, b] = [r[6 + k] * min[k], r[6 + k] * max[k]];
    near += Math.min(a, b);
    far += Math.max(a, b);
  }
  return { near, far };
}

/**
 * Near and far planes that enclose the drawn objects tightly, because depth buffers have few bits. nearest: nearPlaneOf the
 * scene.
 */
export function clippingOf(bounds, view, nearest = bounds && nearPlaneOf(bounds)) {
  if (!bounds) return { near: 1, far: 2 };
  const { near, far } = depthsOf(bounds, view);
  const min = Math.max(nearest, 1e-3 * sphereOf(bounds).radius, 0.98 * near);
  return { near: min, far: Math.max(2 * min, 1.02 * far) };
}

/** World -> clip space of a pinhole viewer. */
export function projectionOf({ rotation: r, translation: t, fx, fy, cx, cy, width, height }, { near, far }) {
  // Rows of clip space over x y z of the view.
  const rows = [
    [(2 * fx) / width, 0, (2 * cx) / width - 1, 0],
    [0, (-2 * fy) / height, 1 - (2 * cy) / height, 0],
    [0, 0, (far + near) / (far - near), (-2 * far * near) / (far - near)],
    [0, 0, 1, 0],
  ];
  const matrix = new Float32Array(16);
  rows.forEach(([x, y, z, one], i) => {
    for (let k = 0; k < 3; k++) matrix[4 * k + i] = x * r[k] + y * r[3 + k] + z * r[6 + k];
    matrix[12 + i] = x * t[0] + y * t[1] + z * t[2] + one;
  });
  return matrix;
}

/** gl_FragCoord and 1 -> a ray in the world. x, y: the lower left corner of the viewport. */
export function raysOf({ rotation: r, fx, fy, cx, cy, height, x = 0, y = 0 }) {
  const matrix = new Float32Array(9);
  for (let k = 0; k < 3; k++) {
    matrix[k] = r[k] / fx;
    matrix[3 + k] = -r[3 + k] / fy;
    matrix[6 + k] = (-(cx + x) / fx) * r[k] + ((height - cy + y) / fy) * r[3 + k] + r[6 + k];
  }
  return matrix;
}

/** A rotation whose z axis is a direction. */
function lookingAlong(direction) {
  const z = normalise(direction);
  const x = normalise(cross(Math.abs(z[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0], z));
  return [x, cross(z, x), z];
}

/** World -> clip space of a lamp that illuminates a sphere; null: the lamp is inside the sphere. */
export function lampProjection(light, { centre, radius }) {
  const distant = light.type === "directional";
  const towards = centre.map((value, k) => value - light.position[k]);
  const distance = Math.hypot(...towards);
  if (!distant && distance < 1.05 * radius) return null;
  const rows = lookingAlong(distant ? light.direction : towards);
  const origin = distant ? centre.map((value, k) => value - 2 * radius * rows[2][k]) : light.position;
  const view = { rotation: rows.flat(), translation: rows.map((row) => -dot(row, origin)), width: 2, height: 2 };
  if (distant) {
    const matrix = new Float32Array(16);
    rows.forEach((row, i) => {
      const offset = view.translation[i] - (i === 2 ? 2 * radius : 0);
      for (let k = 0; k < 3; k++) matrix[4 * k + i] = row[k] / radius;
      matrix[12 + i] = offset / radius;
    });
    matrix[15] = 1;
    return matrix;
  }
  const focal = Math.sqrt(distance * distance - radius * radius) / radius;
  const pinhole = { ...view, fx: focal, fy: focal, cx: 1, cy: 1 };
  return projectionOf(pinhole, { near: distance - radius, far: distance + radius });
}
