// Cameras: projection, which libfvv computes with the same bits as in C, and the selection of cameras for a viewpoint.

// Copied from js/shading/src by the build: players and decoder have one rule.
import { partsAt, THRESHOLDS } from "./camera_rule.js";
import { CAMERA_SIZE, writeCamera } from "./wasm_structs.js";

/** Projection by the wasm module, for all cameras of a decoder. */
export class Projector {
  #core;
  #camera; // address of a struct
  #room = 0; // points that buffer has room for
  #buffer = 0;

  constructor(core) {
    this.#core = core;
    this.#camera = core.exports.fvvjs_alloc(CAMERA_SIZE);
  }
  /** Calls an exported function on count points: doubles in, three doubles out per point. */
  transform(name, camera, numbers, count) {
    const core = this.#core;
    if (count > this.#room) {
      if (this.#buffer) core.exports.fvvjs_free(this.#buffer);
      this.#buffer = core.exports.fvvjs_alloc(48 * count);
      this.#room = this.#buffer ? count : 0;
      if (!this.#buffer) throw new RangeError(`no memory to project ${count} points`);
    }
    writeCamera(core.memory, this.#camera, camera);
    new Float64Array(core.memory.buffer, this.#buffer, numbers.length).set(numbers);
    const out = this.#buffer + 24 * count;
    core.exports[name](this.#camera, this.#buffer, count, out);
    return new Float64Array(core.memory.buffer, out, 3 * count).slice();
  }
}

export class Camera {
  #projector;
  constructor(fields, projector) {
    Object.assign(this, fields);
    this.#projector = projector;
    Object.freeze(this);
  }

  /** World metres -> [u, v, depth], or null behind the camera or beyond the range of its lens. */
  project(x, y, z) {
    const [u, v, depth] = this.projectPoints([x, y, z]);
    return Number.isNaN(u) ? null : [u, v, depth];
  }
  /** x y z of any number of points -> u v depth of each; u and v are NaN where project returns null. */
  projectPoints(points) {
    return this.#projector.transform("fvvjs_project", this, points, Math.floor(points.length / 3));
  }
  /** Pixel -> the ray through it in the camera's frame, [x, y, 1], or null beyond the range of the lens. */
  unproject(u, v) {
    const ray = this.#projector.transform("fvvjs_unproject", this, [u, v], 1);
    return Number.isNaN(ray[0]) ? null : Array.from(ray);
  }
  /** The position of the camera in the world: -R^T t. */
  get centre() {
    const { rotation: r, translation: t } = this;
    return [0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]));
  }
}

/** Sample points on a ball in the middle of the picture; each represents the same area of the picture. */
const POINTS = 250;
const GOLDEN_ANGLE = Math.PI * (3 - Math.sqrt(5));
/** Of the picture, that the cameras that are chosen give. */
const SHARE = 0.95;
/** Radius of the ball, as a part of the viewer's distance. */
const RADIUS = 0.2;

const subtract = (a, b) => a.map((x, i) => x - b[i]);
const add = (a, b) => a.map((x, i) => x + b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, factor) => a.map((x) => x * factor);
const unit = (a) => scaled(a, 1 / Math.hypot(...a));

/** Two directions at right angles to axis and to each other. */
function acrossTo(axis) {
  const aside = unit(cross(axis, Math.abs(axis[0]) < 0.5 ? [1, 0, 0] : [0, 1, 0]));
  return [aside, cross(axis, aside)];
}

/** Normals of the hemisphere that faces axis, evenly distributed over its projection. */
function* normalsTowards(axis) {
  const [aside, above] = acrossTo(axis);
  for (let i = 0; i < POINTS; i++) {
    const radius = Math.sqrt((i + 0.5) / POINTS);
    const [x, y] = [radius * Math.cos(i * GOLDEN_ANGLE), radius * Math.sin(i * GOLDEN_ANGLE)];
    const z = Math.sqrt(1 - radius * radius);
    yield [0, 1, 2].map((k) => x * aside[k] + y * above[k] + z * axis[k]);
  }
}

function shows(camera, [x, y, z]) {
  const place = camera.calibrated ? camera.project(x, y, z) : null;
  return place !== null && place[0] >= 0 && place[0] < camera.width && place[1] >= 0 && place[1] < camera.height;
}

/** Of the picture of a ball from eye: the parts that cameras give, [{camera: index in centres, share}], the largest first. */
function sharesFrom(eye, target, centres, rule) {
  const axis = unit(subtract(eye, target));
  const radius = rule.radius ?? RADIUS * Math.hypot(...subtract(eye, target));
  const shares = centres.map((_, camera) => ({ camera, share: 0 }));
  let all = 0;
  for (const normal of normalsTowards(axis)) {
    const point = add(target, scaled(normal, radius));
    for (const { camera, part } of partsAt(point, normal, centres, eye, rule)) {
      shares[camera].share += part;
      all += part;
    }
  }
  const given = shares.filter(({ share }) => share > 0).sort((a, b) => b.share - a.share);
  return given.map(({ camera, share }) => ({ camera, share: share / all }));
}

/**
 * The cameras that a picture needs by the rule of clause 17.5, [{camera: id, share}], the largest share first. The picture is
 * taken to be a ball at target, seen from eye. Returns as many cameras as together give the fraction share of the picture; with
 * 1 all that give anything. margin: metres that the eye may have moved before the next choice takes effect; what it needs there
 * is included. texturing: the stream's rule, unless blend, threshold and best name another. Empty if no camera shows the target.
 */
export function camerasFor(cameras, { eye, target, share = SHARE, margin = 0, radius, ...given }) {
  [eye, target] = [Array.from(eye), Array.from(target)];
  const axis = unit(subtract(eye, target));
  if (axis.length !== 3 || !axis.every(Number.isFinite)) throw new TypeError("eye and target have to be two points");
  if (!(margin >= 0)) throw new TypeError(`margin: expected metres, found ${margin}`);
  const stream = given.texturing ?? { blend: "viewer", threshold: THRESHOLDS.viewer, best: 3 };
  const blend = given.blend ?? stream.blend;
  const threshold = given.threshold ?? (blend === stream.blend ? stream.threshold : THRESHOLDS[blend]);
  const rule = { blend, threshold, best: given.best ?? stream.best, radius };
  const able = cameras.filter((camera) => shows(camera, target));
  const centres = able.map(({ centre }) => centre);
  const ways = margin > 0 ? acrossTo(axis).flatMap((way) => [scaled(way, margin), scaled(way, -margin)]) : [];
  const needed = new Map();
  for (const place of [eye, ...ways.map((way) => add(eye, way))]) {
    let found = 0;
    for (const one of sharesFrom(place, target, centres, rule)) {
      if (found >= share) break;
      found += one.share;
      const { id } = able[one.camera];
      needed.set(id, Math.max(needed.get(id) ?? 0, one.share));
    }
  }
  const list = Array.from(needed, ([camera, part]) => ({ camera, share: part }));
  return list.sort((a, b) => b.share - a.share);
}

/** The video tracks that show at least one of these cameras, or the atlas. */
export function tracksOf(videos, cameras) {
  const wanted = new Set(cameras);
  const isWanted = (video) => video.shows === "atlas" || video.tiles.some(({ camera }) => wanted.has(camera));
  return videos.filter(isWanted).map(({ track }) => track);
}
