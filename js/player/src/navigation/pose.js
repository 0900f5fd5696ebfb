// Where one looks from, and what moving does to it. A pose is {eye, target, up, fov}: metres of the stream, and the
// vertical angle of view in radians. Poses are never changed, but made anew.

import { fromSpherical, toSpherical } from "./axes.js";
import { add, cross, dot, length, mix, normalise, scale, subtract } from "./vectors.js";

/** Radians that looking straight up and down stays away from: there, nothing is level. */
const POLE = 0.02;

const clamp = (x, least, most) => Math.min(Math.max(x, least), most);
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

/** Around the target, by radians. */
export function orbit(pose, { theta, phi }, axes) {
  const from = orbitOf(pose, axes);
  const to = { theta: from.theta + theta, phi: tilt(from.phi + phi), radius: from.radius };
  return { ...pose, eye: add(pose.target, fromSpherical(axes, to)) };
}

/** Turns the head, by radians. */
export function look(pose, { theta, phi }, axes) {
  const from = toSpherical(axes, subtract(pose.target, pose.eye));
  const to = { theta: from.theta + theta, phi: tilt(from.phi + phi), radius: from.radius };
  return { ...pose, target: add(pose.eye, fromSpherical(axes, to)) };
}

/** Eye and target together, by metres to the right, up and forward as one sees. */
export function move(pose, [right, up, forward]) {
  const to = directionsOf(pose);
  const by = add(add(scale(to.right, right), scale(to.up, up)), scale(to.forward, forward));
  return { ...pose, eye: add(pose.eye, by), target: add(pose.target, by) };
}

/** Moves what is seen at the target's distance by shares of the picture's height. */
export function pan(pose, x, y) {
  const height = 2 * length(subtract(pose.eye, pose.target)) * Math.tan(pose.fov / 2);
  return move(pose, [-x * height, y * height, 0]);
}

/** Times as far from the target. */
export function dolly(pose, factor, { nearest, farthest }) {
  const offset = subtract(pose.eye, pose.target);
  const distance = clamp(length(offset) * factor, nearest, farthest);
  return { ...pose, eye: add(pose.target, scale(normalise(offset), distance)) };
}

/** Upright again, by a share of what is missing. */
export function level(pose, share, axes) {
  if (dot(pose.up, axes.up) > 1 - 1e-9) return pose.up === axes.up ? pose : { ...pose, up: axes.up };
  return { ...pose, up: normalise(mix(pose.up, axes.up, share), axes.up) };
}

/** On the way from one to another, around what is looked at and not through it. */
export function between(from, to, share, axes) {
  if (share >= 1) return to;
  const [a, b] = [orbitOf(from, axes), orbitOf(to, axes)];
  const turn = ((((b.theta - a.theta + Math.PI) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI)) - Math.PI;
  const target = mix(from.target, to.target, share);
  const orbit = {
    theta: a.theta + turn * share,
    phi: a.phi + (b.phi - a.phi) * share,
    radius: a.radius * (b.radius / a.radius) ** share,
  };
  return {
    eye: add(target, fromSpherical(axes, orbit)),
    target,
    up: normalise(mix(from.up, to.up, share), axes.up),
    fov: from.fov + (to.fov - from.fov) * share,
  };
}

/** Of a camera of the stream. towards: what it looks at is as far as this. */
export function poseOfCamera(camera, towards) {
  const { rotation: r, centre: eye } = camera;
  const forward = [r[6], r[7], r[8]];
  const distance = Math.max(dot(subtract(towards, eye), forward), 0.1 * length(subtract(towards, eye)), 1e-3);
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
