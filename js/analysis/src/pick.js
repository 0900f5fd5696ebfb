// What of a frame a ray meets first.

import { add, cross, dot, scale, subtract, unit } from "@fvv/shading";

import { weightsAt } from "./camera_weights.js";
import { objectsAt } from "./objects.js";
import { cornersOf, originOf } from "./pieces.js";
import { treeOf } from "./surface_tree.js";

/** The ray through a pixel of a picture. view: a pinhole as viewFromPose of @fvv/player makes it. */
export function rayThrough({ rotation: r, translation: t, fx, fy, cx, cy }, x, y) {
  const seen = [(x - cx) / fx, (y - cy) / fy, 1];
  // The rotation's transpose leads back to the world.
  const toWorld = (a) => [0, 1, 2].map((k) => r[k] * a[0] + r[3 + k] * a[1] + r[6 + k] * a[2]);
  return { origin: scale(toWorld(t), -1), direction: unit(toWorld(seen)) };
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
    camera: weightsAt(frame, { track: mesh.track, face, barycentric, normal }, origin)[0]?.camera ?? null,
  };
}
