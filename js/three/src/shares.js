// Shares of visibility of each vertex and camera in a texture, which the vertex shader reads.

import { packShares, shareTexels, SHARE_COLUMNS } from "@fvv/shading";
import { DataTexture, NearestFilter, RGBAFormat, UnsignedByteType } from "three";

export class ShareTexture {
  #texture = null;

  get texture() {
    return this.#texture;
  }

  /** Answers how many texels a vertex has, at most so many; 0 when the frame tells of none. */
  show(frame, mesh, views, most) {
    const texels = shareTexels(frame, mesh, views, most);
    if (!texels) return 0;
    packShares(views, mesh.vertexCount, texels, this.#room(texels * mesh.vertexCount));
    this.#texture.needsUpdate = true;
    return texels;
  }

  #room(texels) {
    const rows = Math.ceil(texels / SHARE_COLUMNS);
    if (!this.#texture || this.#texture.image.height < rows) {
      this.#texture?.dispose();
      const height = Math.ceil(1.25 * rows);
      const bytes = new Uint8Array(4 * SHARE_COLUMNS * height);
      this.#texture = new DataTexture(bytes, SHARE_COLUMNS, height, RGBAFormat, UnsignedByteType);
      this.#texture.minFilter = this.#texture.magFilter = NearestFilter;
    }
    return this.#texture.image.data;
  }

  dispose() {
    this.#texture?.dispose();
    this.#texture = null;
  }
}
