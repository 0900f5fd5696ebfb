// Which cameras a frame can take colours from: each with its calibration and its tile of this frame, as rows of
// floats in a texture, which the shaders read. How many cameras there are costs no samplers.

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
