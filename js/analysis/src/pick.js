// What of a frame a ray meets first.

import { add, cross, dot, partsAt, pointsOf, scale, subtract, unit } from "@fvv/shading";

import { objectsAt } from "./objects.js";
import { originOf } from "./pieces.js";
import { SurfaceTree } from "./surface_tree.js";

/** Of a ray from the surface to a camera: what is nearer than this part of the way does not hide the point. */
const OWN_SURFACE = 1e-4;

const trees = new WeakMap();

/** The hierarchy of a mesh, built by the first call. Its points count from the mesh's origin. */
export function treeOf(mesh) {
  let tree = trees.get(mesh);
  if (!tree) trees.set(mesh, (tree = new SurfaceTree(pointsOf(mesh), mesh.faces)));
  return tree;
}

/** The corners of a face, which count from the mesh's origin. */
export function cornersOf(mesh, face) {
  const points = pointsOf(mesh);
  return [0, 1, 2].map((k) => {
    const v = 3 * mesh.faces[3 * face + k];
    return [points[v], points[v + 1], points[v + 2]];
  });
}

/** The ray through a pixel of a picture. view: a pinhole as viewFromPose of @fvv/player makes it. */
export function rayThrough({ rotation: r, translation: t, fx, fy, cx, cy }, x, y) {
  const seen = [(x - cx) / fx, (y - cy) / fy, 1];
  // The rotation's transpose leads back to the world.
  const toWorld = (a) => [0, 1, 2].map((k) => r[k] * a[0] + r[3 + k] * a[1] + r[6 + k] * a[2]);
  return { origin: scale(toWorld(t), -1), direction: unit(toWorld(seen)) };
}

/** Whether nothing of the frame's meshes is between a point on a face and a place. */
function isSeenFrom(frame, { mesh, face, local }, place) {
  return frame.meshes.every((other) => {
    // In the coordinates of the other mesh, without a step over large numbers.
    const between = subtract(originOf(mesh), originOf(other));
    const from = add(local, between);
    const way = subtract(subtract(place, originOf(mesh)), local);
    const except = other === mesh ? face : -1;
    return treeOf(other).cast(from, way, { least: OWN_SURFACE, most: 1, except }) === null;
  });
}

/** The camera that gives most of the colour of a point for a viewer, by the rule of clause 17.5; null: none shows it. */
function cameraOf(frame, { mesh, face, local, normal }, eye) {
  const shown = new Set(
    frame.configuration.videos.flatMap(({ track }) => frame.tiles(track)).map((tile) => tile.camera),
  );
  const origin = originOf(mesh);
  const position = add(origin, local);
  const cameras = frame.cameras.filter(
    (camera) =>
      camera.calibrated &&
      shown.has(camera.id) &&
      dot(normal, subtract(subtract(camera.centre, origin), local)) > 0 &&
      pixelOf(camera, position) &&
      isSeenFrom(frame, { mesh, face, local }, camera.centre),
  );
  // Relative to the origin: in coordinates of maps little would be left of the angles.
  const centres = cameras.map(({ centre }) => subtract(centre, origin));
  const [most] = partsAt(local, normal, centres, subtract(eye, origin), frame.configuration.texturing);
  return most ? cameras[most.camera].id : null;
}

/** Where a place is in the picture of a camera, as camera.project returns it; null: not in it. */
export function pixelOf(camera, position) {
  const pixel = camera.project(...position);
  const isThere =
    pixel !== null && pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < camera.width && pixel[1] < camera.height;
  return isThere ? pixel : null;
}

/** What a ray meets first, or null. ray: {origin, direction} in the coordinates of the stream. */
export function pick(frame, { origin, direction }) {
  const along = unit(direction);
  if (!along || ![...origin, ...direction].every(Number.isFinite))
    throw new RangeError(`pick: expected a ray of finite numbers with a direction, found ${origin} and ${direction}`);
  let best = null;
  for (const mesh of frame.meshes) {
    const hit = treeOf(mesh).cast(subtract(origin, originOf(mesh)), along, { most: best?.distance ?? Infinity });
    if (hit) best = { mesh, ...hit };
  }
  if (!best) return null;
  const { mesh, face, barycentric, distance } = best;
  const corners = cornersOf(mesh, face);
  const local = corners.map((corner, k) => scale(corner, barycentric[k])).reduce(add);
  const [a, b, c] = corners;
  const normal = unit(cross(subtract(b, a), subtract(c, a)));
  const objects = objectsAt(frame, mesh, face);
  return {
    time: frame.time,
    frame: frame.number,
    track: mesh.track,
    position: add(originOf(mesh), local),
    normal,
    face,
    barycentric,
    distance,
    facing: Math.abs(dot(normal, along)),
    object: objects.length === 1 ? objects[0] : null,
    touching: objects.length > 1 ? objects : [],
    camera: cameraOf(frame, { mesh, face, local, normal }, origin),
  };
}
