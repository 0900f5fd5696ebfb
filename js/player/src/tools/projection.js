// Places of the scene in the picture. view: as the navigator makes it, in CSS pixels.

import { dot, mix } from "@fvv/shading";

/** What is nearer to the eye than this, relative to the scene, is not drawn. */
const NEAR = 1e-3;

function seen({ rotation: r, translation: t }, p) {
  return [0, 3, 6].map((row, k) => r[row] * p[0] + r[row + 1] * p[1] + r[row + 2] * p[2] + t[k]);
}
const onScreen = ({ fx, fy, cx, cy }, [x, y, z]) => [(fx * x) / z + cx, (fy * y) / z + cy];

/** [x, y] of a place; null: it is behind the eye. size: of the scene. */
export function project(view, position, size) {
  const local = seen(view, position);
  return local[2] > NEAR * size ? onScreen(view, local) : null;
}

/** A line of places as lines of [x, y]: what is behind the eye is cut away. */
export function projectLine(view, positions, size) {
  const near = NEAR * size;
  const runs = [];
  let run = null;
  let former = null;
  for (const position of positions) {
    const local = seen(view, position);
    const isAhead = local[2] > near;
    if (former && isAhead !== former[2] > near) {
      // Where the line crosses the near plane.
      const cut = mix(former, local, (near * 1.001 - former[2]) / (local[2] - former[2]));
      if (isAhead) runs.push((run = [onScreen(view, cut)]));
      else run.push(onScreen(view, cut));
    }
    if (isAhead && !run) runs.push((run = []));
    if (isAhead) run.push(onScreen(view, local));
    else run = null;
    former = local;
  }
  return runs.filter((points) => points.length > 1);
}

/** Where a ray meets the plane of all places with dot(place, up) = level; null: it does not. */
export function onPlane({ origin, direction }, { up, level }) {
  const along = (level - dot(origin, up)) / dot(direction, up);
  return along > 0 && Number.isFinite(along) ? origin.map((x, k) => x + along * direction[k]) : null;
}
