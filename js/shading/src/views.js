// What shaders need to know of a frame's cameras: calibration and tile of each, as rows of floats in a texture, and the
// parameters by which colours are mixed. The number of samplers does not depend on the number of cameras.

/** Texels of a row; glsl/projection.js says what stands in them. */
export const VIEW_TEXELS = 12;
export const MOST_VIEWS = 64;
const FAR = 1e30;
const lenses = ["none", "radtan", "fisheye"];
/** Flags of a view. */
const BY_SHARES = 1;
const BY_DEPTH = 2;
const OFF = 4;

/** layout: Map from track to {x, y}, where the picture of a track stands in the texture of all of them. */
export function viewsOf(frame, layout) {
  const views = [];
  for (const video of frame.configuration.videos) {
    const at = layout.get(video.track);
    if (!at || video.shows === "atlas") continue;
    for (const tile of tilesOf(frame, video)) {
      const camera = frame.camera(tile.camera);
      if (!camera?.calibrated || views.length === MOST_VIEWS) continue;
      const { x, y, width, height } = tile.destination;
      views.push({ camera, source: tile.source, place: { x: at.x + x, y: at.y + y, width, height } });
    }
  }
  return views;
}

/** A video of one camera is all of its picture. */
function tilesOf(frame, video) {
  if (video.shows === "tiles") return frame.tiles(video.track);
  const camera = frame.camera(video.camera);
  if (!camera) return [];
  const whole = ({ width, height }) => ({ x: 0, y: 0, width, height });
  return [{ camera: video.camera, source: whole(camera), destination: whole(video) }];
}

/**
 * Fills the rows of a texture of VIEW_TEXELS x MOST_VIEWS texels of four floats. Of a view: depth, its place in the depth
 * maps, or null; hasShares: whether the file says what it sees; off: it gives no colours.
 */
export function writeViews(views, array) {
  views.forEach(({ camera, source, place, depth, hasShares, off }, i) => {
    const { rotation: r, translation: t, distortion } = camera;
    const flags = (hasShares ? BY_SHARES : 0) | (depth ? BY_DEPTH : 0) | (off ? OFF : 0);
    const row = [r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]];
    row.push(...camera.centre, flags);
    row.push(camera.fx, camera.fy, camera.cx, camera.cy);
    row.push(camera.skew, Math.min(camera.rMax, FAR), lenses.indexOf(camera.lens), camera.id);
    row.push(...distortion);
    row.push(source.x, source.y, source.width, source.height);
    row.push(place.x, place.y, place.width, place.height);
    row.push(...(depth ? [...depth.scale, ...depth.offset, ...depth.size, ...depth.breadth] : Array(8).fill(0)));
    array.set(row, 4 * VIEW_TEXELS * i);
  });
}

/** Of the shaders: a stream that asks for more has this many. */
export const MOST_BEST = 8;

/** Display values, 0 to 1, of 0xRRGGBB. */
const displayed = (colour) => [16, 8, 0].map((shift) => ((colour >> shift) & 255) / 255);

/** Throws where an option cannot be; undefined, and of the colour null: the stream's. */
export function checkTexturing({ threshold = 0, best = 1, unseen }) {
  if (!(threshold >= 0 && threshold <= 1)) throw new RangeError(`threshold: expected 0 to 1, found ${threshold}`);
  if (!(Number.isInteger(best) && best >= 1 && best <= MOST_BEST))
    throw new RangeError(`best: expected a whole number from 1 to ${MOST_BEST}, found ${best}`);
  const colour = unseen ?? 0;
  if (!(Number.isInteger(colour) && colour >= 0 && colour <= 0xffffff))
    throw new RangeError(`unseen: expected a colour from 0 to 0xffffff, found ${unseen}`);
}

/** own: {threshold, best, unseen}, of which what is there takes the place of the stream's. */
export function texturingOf({ texturing }, own = {}) {
  return {
    threshold: own.threshold ?? texturing.threshold,
    best: own.best ?? Math.min(texturing.best, MOST_BEST),
    unseen: displayed(own.unseen ?? texturing.unseen),
    tolerance: [texturing.depthBias, texturing.depthSlope],
  };
}
