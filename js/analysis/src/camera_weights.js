// How much of the colour of a place on the surface each camera gives, by the rule of clause 17.5.

import { add, borderFactor, cross, dot, partsAt, scale, subtract, unit, visibilityFactor } from "@fvv/shading";

import { cornersOf, originOf } from "./pieces.js";
import { treeOf } from "./surface_tree.js";

/** Of a ray from the surface to a camera: what is nearer than this part of the way does not hide the point. */
const OWN_SURFACE = 1e-4;
/** Pixels at the border of a tile that are not used. */
const MARGIN = 0.5;
/** Of the normal to the viewer's ray, whose way to the inset would become too long. */
const LEAST_SLOPE = 0.5;

/** Where a place is in the picture of a camera, as camera.project returns it; null: not in it. */
export function pixelOf(camera, position) {
  const pixel = camera.project(...position);
  const isThere =
    pixel !== null && pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < camera.width && pixel[1] < camera.height;
  return isThere ? pixel : null;
}

/** Without visibility weights: whether a camera is in front of a face and nothing hides a place on it. */
function isSeenFrom(frame, { mesh, face, local }, camera) {
  const [a, b, c] = cornersOf(mesh, face);
  const towards = subtract(subtract(camera.centre, originOf(mesh)), local);
  if (!(dot(cross(subtract(b, a), subtract(c, a)), towards) > 0)) return false;
  return frame.meshes.every((other) => {
    // In the coordinates of the other mesh, without a step over large numbers.
    const from = add(local, subtract(originOf(mesh), originOf(other)));
    const except = other === mesh ? face : -1;
    return treeOf(other).cast(from, towards, { least: OWN_SURFACE, most: 1, except }) === null;
  });
}

/** The visibility weight of a place, interpolated over its face; null: the stream has none for this camera. */
function seenBy(frame, { mesh, face, barycentric }, { id }) {
  const found = frame.visibility.find((one) => one.meshTrack === mesh.track && one.cameras.includes(id));
  if (!found) return null;
  const weights = found.weightsOf(id);
  return barycentric.reduce((sum, part, k) => sum + part * weights[mesh.faces[3 * face + k]], 0);
}

/** Pixels of a tile from where it shows a position to its usable border; negative or NaN: it does not show it. */
function insideOf({ source, destination }, camera, position) {
  const pixel = camera.project(...position);
  if (!pixel) return NaN;
  const x = ((pixel[0] - source.x) * destination.width) / source.width;
  const y = ((pixel[1] - source.y) * destination.height) / source.height;
  return Math.min(x, y, destination.width - x, destination.height - y) - MARGIN;
}

/** Where pictures show a place, in the coordinates of the stream. */
function shownAt({ inset }, { mesh, local, normal }, eye) {
  const towardsEye = inset ? unit(subtract(eye, local)) : null;
  if (!towardsEye) return add(originOf(mesh), local);
  const along = inset / Math.max(dot(normal, towardsEye), LEAST_SLOPE);
  return add(originOf(mesh), subtract(local, scale(towardsEye, along)));
}

/**
 * The cameras that colour a place for a viewer, [{camera: id, weight}], the largest first; together 1, or none: no camera shows
 * it. eye: in the coordinates of the stream.
 */
export function weightsAt(frame, { track, face, barycentric, normal }, eye) {
  const mesh = frame.meshes.find((one) => one.track === track);
  const local = cornersOf(mesh, face)
    .map((corner, k) => scale(corner, barycentric[k]))
    .reduce(add);
  const place = { mesh, face, barycentric, local, normal };
  const rule = frame.configuration.texturing;
  // Relative to the origin: in coordinates of maps little would be left of the angles.
  const origin = originOf(mesh);
  const viewer = subtract(eye, origin);
  const shown = shownAt(rule, place, viewer);
  const able = [];
  for (const tile of frame.configuration.videos.flatMap((video) => frame.tiles(video.track))) {
    const camera = frame.cameras.find(({ id }) => id === tile.camera);
    const inside = camera?.calibrated ? insideOf(tile, camera, shown) : NaN;
    if (!(inside >= 0)) continue;
    const seen = seenBy(frame, place, camera);
    if (seen === null && !isSeenFrom(frame, place, camera)) continue;
    const factor = borderFactor(rule.blend, inside) * visibilityFactor(rule.blend, seen ?? 255);
    able.push({ id: camera.id, centre: subtract(camera.centre, origin), factor });
  }
  const centres = able.map(({ centre }) => centre);
  const parts = partsAt(local, normal, centres, viewer, rule, (i) => able[i].factor);
  return parts.map(({ camera, part }) => ({ camera: able[camera].id, weight: part }));
}
