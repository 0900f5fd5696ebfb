// Sets three's camera to the view of a camera of the stream.

import { Matrix4, WebGPUCoordinateSystem } from "three";

const turned = new Matrix4();

/** The third row of a projection: depths from -1 to 1, for WebGPU from 0 to 1, or, reversed, from 1, near, to 0. */
function depthOf({ near, far, reversedDepth, coordinateSystem }) {
  const length = far - near;
  if (reversedDepth) return [near / length, (far * near) / length];
  if (coordinateSystem === WebGPUCoordinateSystem) return [-far / length, (-far * near) / length];
  return [-(far + near) / length, (-2 * far * near) / length];
}

/**
 * viewer: a PerspectiveCamera in the coordinates of the stream, i.e. a child of the FvvObject3D or of an object with the
 * same transform. Its matrices become those of the camera, without the distortion of the lens; projectionMatrix is valid
 * until updateProjectionMatrix is called. renderer: with a reversed depth buffer or WebGPU, whose cameras have another projection.
 */
export function lookThrough(viewer, camera, renderer = null) {
  const { rotation: r, translation: t, width, height, fx, fy, cx, cy, skew } = camera;
  // The renderer does the same when it first draws with this viewer, and would then replace the matrix.
  const isReversed = renderer?.state?.buffers?.depth.getReversed?.() ?? renderer?.reversedDepthBuffer;
  if (isReversed !== undefined) viewer._reversedDepth = isReversed;
  if (renderer?.coordinateSystem) viewer.coordinateSystem = renderer.coordinateSystem;
  // OpenGL's y points up and its z backward.
  turned.set(r[0], r[1], r[2], t[0], -r[3], -r[4], -r[5], -t[1], -r[6], -r[7], -r[8], -t[2], 0, 0, 0, 1).invert();
  turned.decompose(viewer.position, viewer.quaternion, viewer.scale);
  viewer.updateWorldMatrix(true, false);
  viewer.projectionMatrix.set(
    (2 * fx) / width,
    (-2 * skew) / width,
    1 - (2 * cx) / width,
    0,
    0,
    (2 * fy) / height,
    (2 * cy) / height - 1,
    0,
    0,
    0,
    ...depthOf(viewer),
    0,
    0,
    -1,
    0,
  );
  viewer.projectionMatrixInverse.copy(viewer.projectionMatrix).invert();
}
