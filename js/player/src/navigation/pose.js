// Poses of the viewer: axes of a stream, movements, and the first view of a scene. A pose is {eye, target, up, fov}: metres
// of the stream, and the vertical angle of view in radians. Poses are immutable.

import { add, cross, dot, length, mix, normalise, pointsOf, scale, subtract } from "@fvv/shading";

/** The vertical and the front of each named axis. With y up the front is +z and the right +x, as in glTF. */
const NAMED = {
  y: { up: [0, 1, 0], front: [0, 0, 1] },
  "-y": { up: [0, -1, 0], front: [0, 0, -1] },
  z: { up: [0, 0, 1], front: [0, -1, 0] },
  "-z": { up: [0, 0, -1], front: [0, 1, 0] },
  x: { up: [1, 0, 0], front: [0, 0, 1] },
  "-x": { up: [-1, 0, 0], front: [0, 0, 1] },
};

function axesFrom(up, front) {
  const right = normalise(cross(up, front), [1, 0, 0]);
  return { up, right, front: cross(right, up) };
}

/** upAxis: of the configuration; if it is unknown, cameras are assumed to be upright. */
export function axesOf(upAxis, cameras) {
  const named = NAMED[upAxis];
  if (named) return axesFrom(named.up, named.front);
  const sum = cameras.reduce((all, { rotation: r }) => add(all, [-r[3], -r[4], -r[5]]), [0, 0, 0]);
  const up = normalise(sum, [0, 1, 0]);
  // Any direction that differs from up can be the front.
  return axesFrom(up, Math.abs(up[2]) < 0.9 ? [0, 0, 1] : [0, -1, 0]);
}

/** Spherical coordinates as in <model-viewer>: theta from the front to the right, phi down from above. */
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

/** Minimum angle to the vertical in radians: looking straight up or down, level is undefined. */
const POLE = 0.02;

const clamp = (x, min, max) => Math.min(Math.max(x, min), max);
const tilt = (phi) => clamp(phi, POLE, Math.PI - POLE);

/** Right, up and forward of the picture. */
export function directionsOf({ eye, target, up }) {
  const forward = normalise(subtract(target, eye), [0, 0, -1]);
  const right = normalise(cross(forward, up), [1, 0, 0]);
  return { forward, right, up: cross(right, forward) };
}

export function orbitOf(pose, axes) {
  return toSpherical(axes, subtract(pose.eye, pose.target));
}
export function poseFromOrbit(orbit, target, fov, axes) {
  return { eye: add(target, fromSpherical(axes, { ...orbit, phi: tilt(orbit.phi) })), target, up: axes.up, fov };
}

/** Rotates the eye around the target, by radians. */
export function orbit(pose, { theta, phi }, axes) {
  const from = orbitOf(pose, axes);
  const to = { theta: from.theta + theta, phi: tilt(from.phi + phi), radius: from.radius };
  return { ...pose, eye: add(pose.target, fromSpherical(axes, to)) };
}

/** Rotates the view around the eye, by radians. */
export function look(pose, { theta, phi }, axes) {
  const from = toSpherical(axes, subtract(pose.target, pose.eye));
  const to = { theta: from.theta + theta, phi: tilt(from.phi + phi), radius: from.radius };
  return { ...pose, target: add(pose.eye, fromSpherical(axes, to)) };
}

/** Moves eye and target by metres to the right, up and forward in the view. */
export function move(pose, [right, up, forward]) {
  const to = directionsOf(pose);
  const by = add(add(scale(to.right, right), scale(to.up, up)), scale(to.forward, forward));
  return { ...pose, eye: add(pose.eye, by), target: add(pose.target, by) };
}

/** Moves objects at the target's distance by fractions of the picture's height. */
export function pan(pose, x, y) {
  const height = 2 * length(subtract(pose.eye, pose.target)) * Math.tan(pose.fov / 2);
  return move(pose, [-x * height, y * height, 0]);
}

/** Multiplies the distance from the target. */
export function dolly(pose, factor, { nearest, farthest }) {
  const offset = subtract(pose.eye, pose.target);
  const distance = clamp(length(offset) * factor, nearest, farthest);
  return { ...pose, eye: add(pose.target, scale(normalise(offset), distance)) };
}

/** Rotates the pose towards upright, by a fraction of the difference. */
export function level(pose, fraction, axes) {
  if (dot(pose.up, axes.up) > 1 - 1e-9) return pose.up === axes.up ? pose : { ...pose, up: axes.up };
  return { ...pose, up: normalise(mix(pose.up, axes.up, fraction), axes.up) };
}

/** A pose on the way from one to another, around the target and not through it. */
export function between(from, to, fraction, axes) {
  if (fraction >= 1) return to;
  const [a, b] = [orbitOf(from, axes), orbitOf(to, axes)];
  const turn = ((((b.theta - a.theta + Math.PI) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI)) - Math.PI;
  const target = mix(from.target, to.target, fraction);
  const orbit = {
    theta: a.theta + turn * fraction,
    phi: a.phi + (b.phi - a.phi) * fraction,
    radius: a.radius * (b.radius / a.radius) ** fraction,
  };
  return {
    eye: add(target, fromSpherical(axes, orbit)),
    target,
    up: normalise(mix(from.up, to.up, fraction), axes.up),
    fov: from.fov + (to.fov - from.fov) * fraction,
  };
}

/** The pose of a camera of the stream, with a target at the distance of the point towards. */
export function poseOfCamera(camera, towards) {
  const { rotation: r, centre: eye } = camera;
  const forward = [r[6], r[7], r[8]];
  const distance = Math.max(dot(subtract(towards, eye), forward), 0.1 * length(subtract(towards, eye))) || 1;
  return {
    eye,
    target: add(eye, scale(forward, distance)),
    up: [-r[3], -r[4], -r[5]],
    fov: 2 * Math.atan(camera.height / (2 * camera.fy)),
  };
}

export function isPose(pose) {
  const vectors = [pose?.eye, pose?.target, pose?.up];
  return (
    vectors.every((v) => v?.length === 3 && Array.from(v).every(Number.isFinite)) &&
    length(cross(subtract(pose.target, pose.eye), pose.up)) > 0 &&
    pose.fov > 0 &&
    pose.fov < Math.PI
  );
}

const FIELD_OF_VIEW = (45 * Math.PI) / 180;
/** What lies at the edge of wider pictures looks stretched. */
const WIDEST = (70 * Math.PI) / 180;
/** Fractions of the picture: the scene's maximum width and height, and its offset above the middle, as controls are below. */
const WIDTH = 0.9;
const HEIGHT = 0.76;
const RAISED = 0.06;

/** The extent without mesh and cameras. */
export const EMPTY_EXTENT = { centre: [0, 0, 0], radius: 1, low: [-1, -1, -1], high: [1, 1, 1] };

/** {centre, radius, low, high} of the mesh; without a mesh, of the cameras. */
export function extentOf(frame) {
  const { mesh, cameras } = frame;
  const hasMesh = mesh?.positions.length > 0;
  const points = hasMesh ? pointsOf(mesh) : cameras.flatMap(({ centre }) => centre);
  const origin = (hasMesh && mesh.origin) || [0, 0, 0];
  if (!points.length) return EMPTY_EXTENT;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i++) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  return {
    centre: low.map((x, i) => origin[i] + (x + high[i]) / 2),
    radius: length(subtract(high, low)) / 2 || 1,
    low: add(origin, low),
    high: add(origin, high),
  };
}

const cornersOf = ({ low, high }) =>
  Array.from({ length: 8 }, (_, i) => low.map((x, axis) => ((i >> axis) & 1 ? high[axis] : x)));

/** The camera that the writer of the stream chose for the first view (spec/registry.md, keys of META); undefined: none. */
export function firstCamera({ metadata = [] }, cameras) {
  for (const text of metadata) {
    let id;
    try {
      id = JSON.parse(text)?.view?.camera;
    } catch {
      continue; // ancillary
    }
    const found = cameras.find((camera) => camera.id === id);
    if (found) return found;
  }
  return undefined;
}

/**
 * The first view: the whole mesh, from the direction of a camera. What is behind the camera may hide the scene, so the view
 * is at most as far away as that, and wider where it has to be. aspect: width over height of the picture.
 */
export function homePose(extent, camera, axes, aspect) {
  const { centre } = extent;
  const from = camera ? subtract(camera.centre, centre) : [1, 1, 1];
  const { theta, phi } = toSpherical(axes, normalise(from));
  const { forward, right, up } = directionsOf(poseFromOrbit({ theta, phi, radius: 1 }, centre, FIELD_OF_VIEW, axes));
  // Of each corner: how far in front of the centre it lies, and the tangent of half the angle at a distance of 1.
  const corners = cornersOf(extent).map((corner) => {
    const at = subtract(corner, centre);
    return [-dot(at, forward), Math.max(Math.abs(dot(at, right)) / (aspect * WIDTH), Math.abs(dot(at, up)) / HEIGHT)];
  });
  const distanceFor = (fov) =>
    Math.max(...corners.map(([ahead, size]) => size / Math.tan(fov / 2) + ahead), 1e-6 * extent.radius);
  let fov = FIELD_OF_VIEW;
  const most = camera ? length(from) : Infinity;
  if (distanceFor(fov) > most) {
    const tangents = corners.map(([ahead, size]) => (ahead < most ? size / (most - ahead) : Infinity));
    fov = Math.min(Math.max(2 * Math.atan(Math.max(...tangents)), fov), WIDEST);
  }
  const pose = poseFromOrbit({ theta, phi, radius: distanceFor(fov) }, centre, fov, axes);
  return pan(pose, 0, -RAISED);
}
