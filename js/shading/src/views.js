// What shaders need to know of a frame's cameras: calibration and tile of each, as rows of floats in a texture, and the
// parameters by which colours are mixed. The number of samplers does not depend on the number of cameras.

import { THRESHOLDS } from "./camera_rule.js";

/** Texels of a row; glsl/surface.js describes them. */
export const VIEW_TEXELS = 12;
export const MAX_VIEWS = 64;
const FAR = 1e30;
const lenses = ["none", "radtan", "fisheye"];
/** Flags of a view. */
const BY_WEIGHTS = 1;
const BY_DEPTH = 2;
const OFF = 4;

/** What is drawn counts from here: the stream's origin of local positions, because shaders have 32 bits. */
export function originOf({ mesh, configuration }) {
  return mesh?.origin ?? configuration.localOrigin ?? [0, 0, 0];
}

/** Metres: cameras and viewers see nothing that is nearer. */
const NEAREST = 0.01;
/** The same of small scenes, as a part of their longest side: their unit may be anything. */
const NEAREST_PART = 0.01;

/** The depth from which on a scene is drawn. bounds: {min, max} of the mesh. */
export function nearPlaneOf({ min, max }) {
  const longest = Math.max(...max.map((value, k) => value - min[k]));
  return longest > 0 ? Math.min(NEAREST, NEAREST_PART * longest) : NEAREST;
}

/** Positions of a mesh, or of a part of an environment, that count from its origin. */
export const pointsOf = ({ localPositions, positions }) => localPositions ?? positions;

const dot = (a, i, b) => a[i] * b[0] + a[i + 1] * b[1] + a[i + 2] * b[2];

/** A camera or a viewer, {rotation, translation, ...}, in coordinates that count from origin. */
export function viewFrom(origin, pinhole) {
  if (origin.every((x) => x === 0)) return pinhole;
  const { rotation, translation } = pinhole;
  return { ...pinhole, translation: [0, 1, 2].map((row) => translation[row] + dot(rotation, 3 * row, origin)) };
}

/** The cameras that give colours in a frame. layout: Map from track to {x, y}, the place of its picture in the texture. */
export function viewsOf(frame, layout) {
  const views = [];
  const origin = originOf(frame);
  for (const video of frame.configuration.videos) {
    const at = layout.get(video.track);
    if (!at || video.shows === "atlas") continue;
    for (const tile of frame.tiles(video.track)) {
      const camera = frame.camera(tile.camera);
      if (!camera?.calibrated || views.length === MAX_VIEWS) continue;
      const { x, y, width, height } = tile.destination;
      const { translation } = viewFrom(origin, camera);
      const centre = camera.centre.map((value, k) => value - origin[k]);
      const place = { x: at.x + x, y: at.y + y, width, height };
      views.push({ camera, translation, centre, source: tile.source, place });
    }
  }
  return views;
}

/**
 * Defines of the shaders for a frame's views, with what takes time in software only where it is needed. LENSES: 0 no view has
 * a lens, 1 none is a fisheye, 2 any. VIEW_BLOCKS: the number of fours of views. DEPTHS: if a view has a depth map.
 */
export function definesOf(views) {
  const defines = {
    LENSES: views.reduce((most, { camera }) => Math.max(most, lenses.indexOf(camera.lens)), 0),
    VIEW_BLOCKS: Math.max(1, Math.ceil(views.length / 4)),
  };
  return views.some(({ depth }) => depth) ? { ...defines, DEPTHS: 1 } : defines;
}

/**
 * Fills the rows of a texture of VIEW_TEXELS x MAX_VIEWS texels of four floats. Of a view: depth, its place in the depth
 * maps, or null; hasVisibilityWeights: the file has visibility weights for it; off: it gives no colours.
 */
export function writeViews(views, array) {
  views.forEach(({ camera, translation: t, centre, source, place, depth, hasVisibilityWeights, off }, i) => {
    const { rotation: r, distortion } = camera;
    const flags = (hasVisibilityWeights ? BY_WEIGHTS : 0) | (depth ? BY_DEPTH : 0) | (off ? OFF : 0);
    const row = [r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]];
    row.push(...centre, flags);
    row.push(camera.fx, camera.fy, camera.cx, camera.cy);
    row.push(camera.skew, Math.min(camera.rMax, FAR), lenses.indexOf(camera.lens), camera.id);
    row.push(...distortion);
    row.push(source.x, source.y, source.width, source.height);
    row.push(place.x, place.y, place.width, place.height);
    row.push(...(depth ? [...depth.scale, ...depth.offset, ...depth.size, ...depth.breadth] : Array(8).fill(0)));
    array.set(row, 4 * VIEW_TEXELS * i);
  });
}

/** Limit of the shaders; larger values of a stream are reduced to it. */
export const MAX_BEST = 8;

/** Display values, 0 to 1, of 0xRRGGBB. */
const displayed = (colour) => [16, 8, 0].map((shift) => ((colour >> shift) & 255) / 255);

/** Throws for invalid options; undefined and null mean the stream's value. */
export function checkTexturing({ blend, threshold = 0, best = 1, unseen }) {
  if (blend != null && !(blend in THRESHOLDS))
    throw new TypeError(`blend: expected one of ${Object.keys(THRESHOLDS).join(", ")}, found ${blend}`);
  if (!(threshold >= 0 && threshold <= 1)) throw new RangeError(`threshold: expected 0 to 1, found ${threshold}`);
  if (!(Number.isInteger(best) && best >= 1 && best <= MAX_BEST))
    throw new RangeError(`best: expected an integer from 1 to ${MAX_BEST}, found ${best}`);
  const colour = unseen ?? 0;
  if (!(Number.isInteger(colour) && colour >= 0 && colour <= 0xffffff))
    throw new RangeError(`unseen: expected a colour from 0 to 0xffffff, found ${unseen}`);
}

/**
 * How colours are mixed: as the stream specifies (clause 17.5), in the units of the shaders. overrides: {blend, threshold,
 * best, unseen}, each replaces the stream's value; another blend than the stream's has a threshold of its own.
 */
export function texturingOf({ texturing }, overrides = {}) {
  const blend = overrides.blend ?? texturing.blend;
  const threshold = blend === texturing.blend ? texturing.threshold : THRESHOLDS[blend];
  return {
    blend,
    threshold: overrides.threshold ?? threshold,
    best: overrides.best ?? Math.min(texturing.best, MAX_BEST),
    unseen: displayed(overrides.unseen ?? texturing.unseen),
    tolerance: [texturing.depthBias, texturing.depthSlope],
    inset: texturing.inset,
  };
}

/**
 * Levels of the texture of pictures, averages of squares of texels: for viewers so far away that a pixel covers many. Level 0 is the pictures as they are. Texels of
 * higher levels than these would mix tiles of different cameras.
 */
export const LEVELS = 4;

/** The number of texels per pixel, along a side, from which on a level above 0 is used. */
export const SHARP = Math.SQRT2;

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

/**
 * Whether shaders need a level above 0 anywhere on the surface. views: of viewsOf; atlas: its place, [x, y, width, height], if
 * there are no views; sphere: {centre, radius} around the mesh; eye: the viewer's position, which counts from originOf as the
 * sphere does; pixelAngle: the width of a pixel of the viewer's picture at a distance of 1.
 */
export function usesLevels({ views, atlas }, { centre, radius }, eye, pixelAngle) {
  const away = distance(eye, centre);
  // The texels of an atlas cover the surface from all sides.
  if (atlas) return Math.sqrt(atlas[2] * atlas[3]) * away * pixelAngle > 2 * radius * SHARP;
  const pixel = (away + radius) * pixelAngle;
  return views.some(({ camera, centre: from, source, place, off }) => {
    const nearest = Math.max(0, distance(from, centre) - radius);
    return !off && pixel * place.width * camera.fx > SHARP * nearest * source.width;
  });
}
