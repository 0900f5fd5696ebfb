// Where the viewer stands and what of the world the picture shows: a pinhole camera in the conventions of the format, world ->
// view, x right, y down, z forward, pixel centres at +0.5.

const minus = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function normalised(a, what) {
  const length = Math.hypot(...a);
  if (!(length > 1e-12)) throw new RangeError(what);
  return a.map((x) => x / length);
}

/** eye looks at target; fov: vertical, radians; width, height: of the picture in pixels. */
export function viewFromPose({ eye, target, up, fov, width, height }) {
  const z = normalised(minus(target, eye), "eye and target are the same point");
  const x = normalised(cross(z, normalised(up, "up has no length")), "up points along the line of sight");
  const y = cross(z, x);
  const focal = height / (2 * Math.tan(fov / 2));
  const translation = [x, y, z].map((row) => -dot(row, eye));
  return {
    rotation: [...x, ...y, ...z],
    translation,
    fx: focal,
    fy: focal,
    cx: width / 2,
    cy: height / 2,
    width,
    height,
  };
}

/**
 * What a camera of the stream sees, without the distortion of its lens and its skew: the whole of its picture, as large as it
 * fits into width x height, in the middle.
 */
export function viewFromCamera(camera, width = camera.width, height = camera.height) {
  const scale = Math.min(width / camera.width, height / camera.height);
  return {
    rotation: Array.from(camera.rotation),
    translation: Array.from(camera.translation),
    fx: camera.fx * scale,
    fy: camera.fy * scale,
    cx: width / 2 + (camera.cx - camera.width / 2) * scale,
    cy: height / 2 + (camera.cy - camera.height / 2) * scale,
    width,
    height,
  };
}

/** Where the viewer stands in the world. */
export function eyeOf({ rotation: r, translation: t }) {
  return [0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]));
}
