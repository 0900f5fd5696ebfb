// What the file says about who sees what, as a share of 0 to 255 for each vertex and camera (clause 17.4 of the format).
// The vertex shader reads them and hands them on as varyings, four cameras in each.

import { DataTexture, NearestFilter, RGBAFormat, UnsignedByteType } from "three";

const WIDTH = 2048;
/** Nothing around the vertex has a bit: a little less than half, so that other corners decide. */
const UNKNOWN = 127;
const HIDDEN = 1;
const SEEN = 2;

/** The chunk that tells of a camera; bits of faces are finer than those of vertices. */
function told(frame, mesh, camera) {
  const all = frame.visibility.filter((one) => one.meshTrack === mesh.track && one.cameras.includes(camera));
  return all.find((one) => one.domain === "faces") ?? all[0] ?? null;
}

/** Writes every stride-th byte of out, from the first one on. */
function ofFaces(states, { indices, vertexCount }, out, stride) {
  const seen = new Uint16Array(vertexCount);
  const all = new Uint16Array(vertexCount);
  for (let face = 0; face < states.length; face++) {
    const state = states[face];
    if (state !== HIDDEN && state !== SEEN) continue;
    for (let corner = 3 * face; corner < 3 * face + 3; corner++) {
      all[indices[corner]]++;
      if (state === SEEN) seen[indices[corner]]++;
    }
  }
  for (let v = 0; v < vertexCount; v++)
    out[stride * v] = all[v] ? Math.floor((255 * seen[v] + (all[v] >> 1)) / all[v]) : UNKNOWN;
}

export class ShareTexture {
  #texture = null;

  get texture() {
    return this.#texture;
  }

  /**
   * Marks the views of which the frame tells with hasShares, the first 4 x most of them, and answers how many texels
   * a vertex has: 0 when it tells of none.
   */
  show(frame, mesh, views, most) {
    views.forEach((view, i) => (view.hasShares = i < 4 * most && told(frame, mesh, view.camera.id) !== null));
    const last = views.findLastIndex((view) => view.hasShares);
    if (last < 0) return 0;
    const texels = Math.floor(last / 4) + 1;
    const stride = 4 * texels;
    const bytes = this.#room(texels * mesh.vertexCount);
    views.forEach((view, i) => {
      if (!view.hasShares) return;
      const visibility = told(frame, mesh, view.camera.id);
      const states = visibility.of(view.camera.id);
      const out = bytes.subarray(i);
      if (visibility.domain === "faces") ofFaces(states, mesh, out, stride);
      else for (let v = 0; v < mesh.vertexCount; v++) out[stride * v] = states[v] === SEEN ? 255 : 0;
    });
    this.#texture.needsUpdate = true;
    return texels;
  }

  #room(texels) {
    const rows = Math.ceil(texels / WIDTH);
    if (!this.#texture || this.#texture.image.height < rows) {
      this.#texture?.dispose();
      const height = Math.ceil(1.25 * rows);
      const bytes = new Uint8Array(4 * WIDTH * height);
      this.#texture = new DataTexture(bytes, WIDTH, height, RGBAFormat, UnsignedByteType);
      this.#texture.minFilter = this.#texture.magFilter = NearestFilter;
    }
    return this.#texture.image.data;
  }

  dispose() {
    this.#texture?.dispose();
    this.#texture = null;
  }
}
