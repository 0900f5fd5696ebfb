// The pictures of a frame as one texture of display values. Most streams have one video with all cameras, which goes
// to the texture as it is; several are put below each other.

import { LinearFilter, NoColorSpace, Texture } from "three";

export class PictureTexture {
  texture = null;
  width = 1;
  height = 1;
  #canvas = null;

  /** Uploads what the frame has. Answers where the picture of each track stands: Map from track to {x, y}. */
  show(renderer, frame) {
    const layout = new Map();
    const pictures = [];
    let width = 0;
    let height = 0;
    for (const video of frame.configuration.videos) {
      const image = frame.picture(video.track);
      if (!image) continue;
      layout.set(video.track, { x: 0, y: height });
      pictures.push({ image, video, y: height });
      width = Math.max(width, video.width);
      height += video.height;
    }
    if (!pictures.length) return layout;
    this.#resize(width, height);
    this.texture.image = pictures.length === 1 ? pictures[0].image : this.#stack(pictures);
    this.texture.needsUpdate = true;
    // Now: the caller may close the frame as soon as it has been shown.
    renderer.initTexture(this.texture);
    return layout;
  }

  #resize(width, height) {
    if (this.texture && this.width === width && this.height === height) return;
    this.texture?.dispose();
    Object.assign(this, { width, height, texture: new Texture() });
    // Tiles are found by their rows from the top, and ImageBitmaps can't be turned over.
    this.texture.flipY = false;
    this.texture.colorSpace = NoColorSpace;
    this.texture.generateMipmaps = false;
    this.texture.minFilter = this.texture.magFilter = LinearFilter;
  }

  #stack(pictures) {
    const { width, height } = this;
    if (this.#canvas?.width !== width || this.#canvas?.height !== height)
      this.#canvas = new OffscreenCanvas(width, height);
    const context = this.#canvas.getContext("2d", { alpha: false });
    for (const { image, video, y } of pictures) context.drawImage(image, 0, y, video.width, video.height);
    return this.#canvas;
  }

  dispose() {
    this.texture?.dispose();
    this.texture = this.#canvas = null;
  }
}
