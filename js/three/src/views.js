// The table of views as a texture, which the shaders read.

import { MOST_VIEWS, VIEW_TEXELS, writeViews } from "@fvv/shading";
import { DataTexture, FloatType, NearestFilter, RGBAFormat } from "three";

export class ViewTexture extends DataTexture {
  constructor() {
    super(new Float32Array(4 * VIEW_TEXELS * MOST_VIEWS), VIEW_TEXELS, MOST_VIEWS, RGBAFormat, FloatType);
    this.minFilter = this.magFilter = NearestFilter;
  }

  show(views) {
    writeViews(views, this.image.data);
    this.needsUpdate = true;
  }
}
