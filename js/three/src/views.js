// Which cameras a frame can take colours from: each with its calibration and its tile of this frame, as rows of
// floats in a texture, which the shaders read. How many cameras there are costs no samplers.

import { DataTexture, FloatType, NearestFilter, RGBAFormat } from "three";

/** Texels of a row; shaders.js says what stands in them. */
const TEXELS = 12;
export const MOST_VIEWS = 64;
const FAR = 1e30;
const lenses = ["none", "radtan", "fisheye"];

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

export class ViewTexture extends DataTexture {
  constructor() {
    super(new Float32Array(4 * TEXELS * MOST_VIEWS), TEXELS, MOST_VIEWS, RGBAFormat, FloatType);
    this.minFilter = this.magFilter = NearestFilter;
  }

  /** depth: what DepthMaps knows of each view, or null; shares: whether the file says what the view sees. */
  show(views) {
    views.forEach(({ camera, source, place, depth, hasShares }, i) => {
      const { rotation: r, translation: t, distortion } = camera;
      const row = [r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]];
      row.push(...camera.centre, hasShares ? 1 : 0);
      row.push(camera.fx, camera.fy, camera.cx, camera.cy);
      row.push(camera.skew, Math.min(camera.rMax, FAR), lenses.indexOf(camera.lens), depth ? 1 : 0);
      row.push(...distortion);
      row.push(source.x, source.y, source.width, source.height);
      row.push(place.x, place.y, place.width, place.height);
      row.push(...(depth ? [...depth.scale, ...depth.offset, ...depth.size, ...depth.breadth] : Array(8).fill(0)));
      this.image.data.set(row, 4 * TEXELS * i);
    });
    this.needsUpdate = true;
  }
}
