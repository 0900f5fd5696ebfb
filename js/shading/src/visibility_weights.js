// Visibility weights of the file, 0 to 255 for each vertex and camera (clause 17.4 of the format), as rows of a texture. The
// vertex shader reads them and passes them on as varyings, four cameras in each.

export const WEIGHT_COLUMNS = 2048;
export const MAX_WEIGHT_TEXELS = 16;

function weightsFor(frame, mesh, camera) {
  const found = frame.visibility.find((one) => one.meshTrack === mesh.track && one.cameras.includes(camera));
  return found?.weightsOf(camera) ?? null;
}

/**
 * Sets visibilityWeights and hasVisibilityWeights of the views, for the first 4 x maxTexels of them. Returns the number of
 * texels per vertex; 0: the frame has no visibility weights.
 */
export function visibilityWeightTexels(frame, mesh, views, maxTexels) {
  views.forEach((view, i) => {
    view.visibilityWeights = i < 4 * maxTexels ? weightsFor(frame, mesh, view.camera.id) : null;
    view.hasVisibilityWeights = view.visibilityWeights !== null;
  });
  return Math.floor((views.findLastIndex((view) => view.hasVisibilityWeights) + 4) / 4);
}

/** Writes the weights of the views that visibilityWeightTexels has set, as texels of four bytes per vertex. */
export function packVisibilityWeights(views, vertexCount, texels, bytes) {
  const stride = 4 * texels;
  views.forEach(({ visibilityWeights }, i) => {
    if (!visibilityWeights) return;
    for (let v = 0, at = i; v < vertexCount; v++, at += stride) bytes[at] = visibilityWeights[v];
  });
}
