// Which cameras a picture from somewhere takes its colours from, by the rule of docs/fvvrender.md.

/** Points of a ball in the middle of the picture; each is worth the same part of it. */
const POINTS = 1000;
const GOLDEN_ANGLE = Math.PI * (3 - Math.sqrt(5));

const subtract = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, factor) => a.map((x) => x * factor);
const unit = (a) => scaled(a, 1 / Math.hypot(...a));

/** Normals of the half of a ball that turns to axis, evenly over the disc that is seen of it. */
function* normalsTowards(axis) {
  const aside = unit(cross(axis, Math.abs(axis[0]) < 0.5 ? [1, 0, 0] : [0, 1, 0]));
  const above = cross(axis, aside);
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

/**
 * The cameras that a picture needs, [{camera: id, share}], those first that most of it comes from: of a ball at target
 * as it is seen from eye, each point from the best cameras, by the cosine between its normal and the ray to the
 * camera, unless that is below threshold. Those that together give the part share of the picture; with 1 all that
 * give anything. None when no camera shows the target.
 */
export function camerasFor(cameras, { eye, target, best = 3, threshold = 0.25, share = 0.9 }) {
  [eye, target] = [Array.from(eye), Array.from(target)];
  const axis = unit(subtract(eye, target));
  if (axis.length !== 3 || !axis.every(Number.isFinite)) throw new TypeError("eye and target have to be two points");
  const able = cameras
    .filter((camera) => shows(camera, target))
    .map((camera) => ({ camera: camera.id, ray: unit(subtract(camera.centre, target)), share: 0 }));
  for (const normal of normalsTowards(axis)) {
    const seen = able.map((one) => ({ one, weight: dot(normal, one.ray) })).filter(({ weight }) => weight >= threshold);
    const used = seen.sort((a, b) => b.weight - a.weight).slice(0, best);
    const sum = used.reduce((total, { weight }) => total + weight, 0);
    for (const { one, weight } of used) one.share += weight / sum;
  }
  const all = able.reduce((total, one) => total + one.share, 0);
  const needed = [];
  let found = 0;
  for (const one of able.filter((each) => each.share > 0).sort((a, b) => b.share - a.share)) {
    if (found >= share * all) break;
    found += one.share;
    needed.push({ camera: one.camera, share: one.share / all });
  }
  return needed;
}

/** Video tracks that show some of these cameras, or the atlas. */
export function tracksOf(videos, cameras) {
  const wanted = new Set(cameras);
  const isWanted = (video) =>
    video.shows === "atlas" ||
    (video.shows === "camera" ? wanted.has(video.camera) : video.tiles.some(({ camera }) => wanted.has(camera)));
  return videos.filter(isWanted).map(({ track }) => track);
}
