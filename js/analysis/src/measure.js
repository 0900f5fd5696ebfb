// Lengths, angles and speeds, each with its uncertainty: half of the width of the interval that holds the true value in 95 of 100
// cases. What is not known to be right to some figure has none.

import { add, dot, length, scale, subtract, unit } from "@fvv/shading";

import { metadataOf, objectsOf, piecesOfFrame } from "./objects.js";
import { pixelOf } from "./camera_weights.js";
import { originOf } from "./pieces.js";
import { treeOf } from "./surface_tree.js";

/** Where a ray runs along the surface, a shift of that moves what it meets by so much more, but not without end. */
const LEAST_FACING = 0.15;
/** Of the centre of a piece, relative to that of its surface: what is off to one side cancels what is off to the other. Measured: 0.16 to 0.4. */
const CENTRE_PART = 0.5;
/** Standard deviations on either side of the value. */
const SIGMAS = 1.96;
const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], "-x": [-1, 0, 0], "-y": [0, -1, 0], "-z": [0, 0, -1] };

const root = (...parts) => Math.sqrt(parts.reduce((sum, x) => sum + x * x, 0));

/** Student's t for 95 of 100, within 0.02 from 4 degrees of freedom on. */
const student = (freedom) => SIGMAS + 2.37 / freedom + 2.8 / (freedom * freedom);

const isLength = (x) => Number.isFinite(x) && x >= 0;
const isMeshError = (value) => isLength(value?.vertex) && isLength(value.pixels ?? 0) && isLength(value.metres ?? 0);

/** The key mesh_error of META: {vertex, pixels, metres}, each a number or null; null: the stream does not say how exact it is. */
export function meshErrorOf(configuration) {
  const stated = metadataOf(configuration, "mesh_error", isMeshError);
  return stated && { vertex: stated.vertex, pixels: stated.pixels ?? null, metres: stated.metres ?? null };
}

/** Metres that a pixel of the transmitted pictures covers at a place, of the camera that sees it sharpest; null: none sees it. */
function pixelAt(frame, position) {
  const scales = new Map();
  for (const { track } of frame.configuration.videos)
    for (const { camera, source, destination } of frame.tiles(track))
      scales.set(camera, Math.max(scales.get(camera) ?? 0, destination.width / source.width));
  let least = Infinity;
  for (const camera of frame.cameras) {
    const pixel = camera.calibrated ? pixelOf(camera, position) : null;
    const shrunk = scales.size ? scales.get(camera.id) : 1;
    if (pixel && shrunk) least = Math.min(least, pixel[2] / (Math.max(camera.fx, camera.fy) * shrunk));
  }
  return least < Infinity ? least : null;
}

/** How far the meshes of a frame are off what they were made from at a place, a standard deviation in metres; null: unknown. */
function meshDeviation(frame, position) {
  const stated = meshErrorOf(frame.configuration);
  if (!stated) return null;
  if (stated.metres !== null) return stated.metres;
  // Every difference up to the largest is as likely.
  if (stated.pixels === null) return stated.vertex / Math.sqrt(3);
  const pixel = pixelAt(frame, position);
  return pixel === null ? null : stated.pixels * pixel;
}

/**
 * By how much a hull is larger than what it was made of at a place, at most: where no camera looks along the surface, it bulges. The
 * body is taken to be round, and as thick there as the hull is behind the place.
 */
function bulgeAt(frame, { position, normal, face, track }) {
  const mesh = frame.meshes.find((one) => one.track === track);
  const local = subtract(position, originOf(mesh));
  const behind = treeOf(mesh).cast(local, scale(normal, -1), { except: face });
  if (!behind) return null;
  let slant = 1;
  for (const { calibrated, centre } of frame.cameras)
    if (calibrated) slant = Math.min(slant, Math.abs(dot(normal, unit(subtract(centre, position)) ?? normal)));
  const along = Math.sqrt(1 - slant * slant);
  const radius = behind.distance / 2;
  return along > 0 ? Math.min(behind.distance, radius * (1 / along - 1)) : behind.distance;
}

/**
 * The uncertainty of a place that pick found, in metres; null: the stream does not say how exact its meshes are. hull: whether the
 * meshes are visual hulls, which are larger than the bodies.
 */
export function pointUncertainty(frame, picked, { hull = false } = {}) {
  const deviation = meshDeviation(frame, picked.position);
  if (deviation === null) return null;
  const bulge = hull ? bulgeAt(frame, picked) : 0;
  return bulge === null ? null : root(SIGMAS * deviation, bulge) / Math.max(picked.facing, LEAST_FACING);
}

/** A picked place for the functions below: {position, uncertainty}; null: nothing is known of its uncertainty. */
export function pointOf(frame, picked, options) {
  const uncertainty = pointUncertainty(frame, picked, options);
  return uncertainty === null ? null : { position: picked.position, uncertainty };
}

/**
 * The centre of an object in a frame as a point; null: it is not there, it is one piece with others, it is in several pieces, or
 * nothing is known of its uncertainty.
 */
export function centreOf(frame, id) {
  const pieces = piecesOfFrame(frame).filter(({ objects }) => objects.includes(id));
  if (pieces.length !== 1 || pieces[0].objects.length !== 1) return null;
  const position = pieces[0].centre;
  const deviation = meshDeviation(frame, position);
  return deviation === null ? null : { position, uncertainty: CENTRE_PART * SIGMAS * deviation };
}

/**
 * The centre of an object over the whole stream as the stream gives its path, points with {time, seconds}: those of centreOf without
 * decoding, and a little less exact. frame: any, for what its cameras see. null in place of a point where the object touches others; an empty
 * list: the stream names no objects, or nothing is known of their uncertainty.
 */
export function pathOf(frame, id) {
  const objects = objectsOf(frame.configuration);
  const { numerator, denominator } = frame.configuration.timeBase;
  const points = [];
  for (const { time, centre } of objects?.pathOf(id) ?? []) {
    const deviation = meshDeviation(frame, centre);
    if (deviation === null) return [];
    const uncertainty = root(CENTRE_PART * SIGMAS * deviation, SIGMAS * objects.rounding);
    const alone = objects.together(id, time).length === 1;
    const seconds = (Number(time) * numerator) / denominator;
    points.push(alone ? { time, seconds, position: centre, uncertainty } : null);
  }
  return points;
}

/** The distance of two points: {value, uncertainty} in metres. */
export function distance(a, b) {
  return { value: length(subtract(a.position, b.position)), uncertainty: root(a.uncertainty, b.uncertainty) };
}

/** The angle at a point between two others: {value, uncertainty} in degrees; null: one of them is as near as it is uncertain. */
export function angle(at, a, b) {
  const sides = [a, b].map(({ position, uncertainty }) => ({ way: subtract(position, at.position), uncertainty }));
  const [one, other] = sides.map(({ way }) => length(way));
  if (sides.some(({ way, uncertainty }) => length(way) <= root(uncertainty, at.uncertainty))) return null;
  const cosine = dot(sides[0].way, sides[1].way) / (one * other);
  const spread = root(a.uncertainty / one, b.uncertainty / other, at.uncertainty / one, at.uncertainty / other);
  const degrees = 180 / Math.PI;
  return { value: degrees * Math.acos(Math.max(-1, Math.min(1, cosine))), uncertainty: degrees * spread };
}

/**
 * The floor of a scene: {up, level, uncertainty}: the lowest place of the meshes of a frame, on which somebody stands. null: the
 * direction of up, or how exact the meshes are, is unknown, or there is no mesh.
 */
export function floorOf(frame) {
  const up = AXES[frame.configuration.upAxis];
  let lowest = null;
  for (const mesh of up ? frame.meshes : []) {
    const points = mesh.localPositions;
    for (const v of new Set(mesh.faces)) {
      const local = [points[3 * v], points[3 * v + 1], points[3 * v + 2]];
      const position = add(originOf(mesh), local);
      const level = dot(position, up);
      if (!lowest || level < lowest.level) lowest = { level, position };
    }
  }
  const deviation = lowest && meshDeviation(frame, lowest.position);
  return deviation === null ? null : { up, level: lowest.level, uncertainty: SIGMAS * deviation };
}

/** The height of a point over a floor: {value, uncertainty} in metres. */
export function height(point, floor) {
  const value = dot(point.position, floor.up) - floor.level;
  return { value, uncertainty: root(point.uncertainty, floor.uncertainty) };
}

/**
 * Speed and acceleration of a point over time, of the parabola that fits best around each sample. samples: {seconds, position,
 * uncertainty} in order, null where nothing is known; around: how many samples before and after each are used. Returns for each
 * sample {seconds, velocity, speed, acceleration}: metres a second, with {value, uncertainty} in m/s and m/s2; null where one of the
 * samples around is missing. Uncertainties contain how badly the parabola fits: they are large where a ball bounces.
 */
export function motion(samples, { around = 2 } = {}) {
  if (!Number.isInteger(around) || around < 2)
    throw new RangeError(`around: expected an integer of 2 or more, found ${around}`);
  return samples.map((_, i) => {
    const used = samples.slice(Math.max(0, i - around), i + around + 1);
    if (used.length < 2 * around + 1 || used.some((one) => !one)) return null;
    return parabola(used, used[around]);
  });
}

/** Least squares for position = a + b t + c t t, where t is the time from the middle sample. */
function parabola(samples, { seconds, position }) {
  const times = samples.map((one) => one.seconds - seconds);
  const sums = [0, 1, 2, 3, 4].map((power) => times.reduce((sum, t) => sum + t ** power, 0));
  const inverse = inverted([sums.slice(0, 3), sums.slice(1, 4), sums.slice(2, 5)]);
  if (!inverse) return null;
  let squares = 0;
  const axes = [0, 1, 2].map((k) => {
    // From the middle sample: in coordinates of maps little would be left of the sums.
    const values = samples.map((one) => one.position[k] - position[k]);
    const right = [0, 1, 2].map((power) => values.reduce((sum, x, i) => sum + x * times[i] ** power, 0));
    const fit = inverse.map((row) => dot(row, right));
    values.forEach((x, i) => (squares += (x - fit[0] - fit[1] * times[i] - fit[2] * times[i] ** 2) ** 2));
    return fit;
  });
  const freedom = 3 * (samples.length - 3);
  const stated = Math.max(...samples.map(({ uncertainty }) => uncertainty));
  const spread = Math.max(stated, student(freedom) * Math.sqrt(squares / freedom));
  const velocity = axes.map((fit) => fit[1]);
  const acceleration = axes.map((fit) => 2 * fit[2]);
  return {
    seconds,
    velocity,
    speed: { value: length(velocity), uncertainty: spread * Math.sqrt(inverse[1][1]) },
    acceleration: { value: length(acceleration), uncertainty: 2 * spread * Math.sqrt(inverse[2][2]) },
  };
}

/** Of a symmetric matrix of three rows; null: it has none. */
function inverted([[a, b, c], [, d, e], [, , f]]) {
  const first = [d * f - e * e, c * e - b * f, b * e - c * d];
  const size = a * first[0] + b * first[1] + c * first[2];
  if (!(Math.abs(size) > 0)) return null;
  const second = [first[1], a * f - c * c, b * c - a * e];
  const third = [first[2], second[2], a * d - b * b];
  return [first, second, third].map((row) => scale(row, 1 / size));
}

/** Comma-separated values (RFC 4180) of objects with the same keys. What is null stays empty; {value, uncertainty} takes two columns. */
export function csv(rows) {
  const flat = rows.map((row) =>
    Object.fromEntries(
      Object.entries(row).flatMap(([name, x]) =>
        x !== null && typeof x === "object" && "uncertainty" in x
          ? [
              [name, x.value],
              [`${name} uncertainty`, x.uncertainty],
            ]
          : [[name, x]],
      ),
    ),
  );
  const names = [...new Set(flat.flatMap(Object.keys))];
  const quoted = (x) => {
    const text = String(x ?? "");
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [names, ...flat.map((row) => names.map((name) => row[name]))]
    .map((row) => `${row.map(quoted).join()}\r\n`)
    .join("");
}
