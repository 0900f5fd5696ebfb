// The viewer as a pinhole camera in the conventions of the format: world -> view, x right, y down, z forward, pixel centres
// at +0.5.

import { cross, dot, length, subtract } from "@fvv/shading";

export const radiansOf = (degrees) => (degrees * Math.PI) / 180;
export const degreesOf = (radians) => (radians * 180) / Math.PI;

function direction(a, problem) {
  const size = length(a);
  if (!(size > 1e-12)) throw new RangeError(problem);
  return a.map((x) => x / size);
}

/** eye looks at target; fov: vertical, degrees; width, height: of the picture in pixels. */
export function viewFromPose({ fov, ...pose }) {
  return viewOf({ ...pose, fov: radiansOf(fov) });
}

/** The same of a pose of the navigator, which has radians. */
export function viewOf({ eye, target, up, fov, width, height }) {
  const z = direction(subtract(target, eye), "eye and target are the same point");
  const x = direction(cross(z, direction(up, "up has no length")), "up points along the line of sight");
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
 * The view of a camera of the stream, without its lens distortion and skew: its whole picture, centred in width x height and
 * as large as possible.
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

/** The position of the viewer in the world. */
export function eyeOf({ rotation: r, translation: t }) {
  return [0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]));
}

/**
 * How many pixels of the screen show a pixel of the cameras' pictures at the pose's target, along one axis: the median of the
 * cameras. height: of the picture on the screen, in pixels. null: no camera is calibrated.
 */
export function shownScale({ eye, target, fov }, height, cameras) {
  const viewer = height / (2 * Math.tan(fov / 2)) / length(subtract(target, eye));
  const scales = cameras
    .filter(({ calibrated }) => calibrated)
    .map(({ fy, centre }) => viewer / (fy / length(subtract(target, centre))))
    .filter(Number.isFinite)
    .sort((a, b) => a - b);
  return scales.length ? scales[scales.length >> 1] : null;
}
