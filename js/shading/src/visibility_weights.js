// Visibility weights of the file, 0 to 255 for each vertex and camera (clause 17.4 of the format), as rows of a texture. The
// vertex shader reads them and passes them on as varyings, four cameras in each.

export const SHARE_COLUMNS = 2048;
export const MOST_SHARE_TEXELS = 16;

/** Shares of a camera; those that are coded are finer than those from bits of faces, and these than from bits of vertices. */
function told(frame, mesh, camera) {
  const all = frame.visibility.filter((one) => one.meshTrack === mesh.track && one.cameras.includes(camera));
  const of = (domain) => all.find((one) => one.domain === domain);
  const found = of("shares") ?? of("faces") ?? all[0];
  if (!found) return null;
  const shares = found.weightsOf(camera);
  if (!shares) throw new TypeError("visibility has no shares: create the decoder with visibilityWeights: true");
  return shares;
}

/**
 * Marks the views of which the frame tells with hasShares, the first 4 x most of them, and answers how many texels
 * a vertex has: 0 when it tells of none.
 */
export function shareTexels(frame, mesh, views, most) {
  views.forEach((view, i) => {
    view.shares = i < 4 * most ? told(frame, mesh, view.camera.id) : null;
    view.hasShares = view.shares !== null;
  });
  return Math.floor((views.findLastIndex((view) => view.hasShares) + 4) / 4);
}

/** Writes the shares of views that shareTexels has marked: texels of four bytes for each vertex. */
export function packShares(views, vertexCount, texels, bytes) {
  const stride = 4 * texels;
  views.forEach(({ shares }, i) => {
    if (!shares) return;
    for (let v = 0, at = i; v < vertexCount; v++, at += stride) bytes[at] = shares[v];
  });
}
