import { Camera } from "@fvv/decoder";

/** World -> view: R x + t, x right, y down, z forward. Other values in pixels; pixel centres are at +0.5. */
export interface View {
  /** Row-major, 9 numbers. */
  rotation: readonly number[];
  translation: readonly number[];
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  width: number;
  height: number;
}

type Vector = readonly [number, number, number];

/** fov: vertical, in degrees. */
export function viewFromPose(pose: {
  eye: Vector;
  target: Vector;
  up: Vector;
  fov: number;
  width: number;
  height: number;
}): View;
/** Without lens distortion; the camera's whole picture fits into width x height. */
export function viewFromCamera(camera: Camera, width?: number, height?: number): View;
export function eyeOf(view: View): [number, number, number];
