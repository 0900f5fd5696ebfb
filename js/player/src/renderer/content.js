// What of a frame stays with the renderer, also to draw it anew when a context is lost: everything but its pictures, which
// the caller closes, and these as bytes or as a picture of its own.

import { layoutOf, loadPictures, viewsOf } from "@fvv/shading";

import { boundsOf } from "./matrices.js";

/** A picture that outlives its frame. Of JPEG the file does, and is decoded again when it has to be. */
function kept(picture, frame) {
  const { video, image, planes } = picture;
  if (planes) return picture;
  if (typeof VideoFrame === "function" && image instanceof VideoFrame) return { video, image: image.clone() };
  const sample = frame.samples.find(({ track }) => track === video.track);
  return { video, file: sample?.data ?? null };
}

export class Content {
  #kept = false;

  /** pictures: what loadPictures had, and the caller may close. */
  static async of(frame) {
    const pictures = await loadPictures(frame);
    return new Content(frame, pictures);
  }

  constructor(frame, pictures) {
    const { mesh, configuration } = frame;
    this.frame = frame;
    this.pictures = pictures;
    this.mesh = mesh?.faceCount ? mesh : null;
    this.layout = layoutOf(pictures);
    this.views = viewsOf(frame, this.layout.places);
    this.bounds = this.mesh && boundsOf(mesh.positions);
    const atlas = configuration.videos.find(({ shows, track }) => shows === "atlas" && this.layout.places.has(track));
    const place = atlas && this.layout.places.get(atlas.track);
    // A texture map takes the place of cameras where there are none.
    this.atlas = place && mesh?.uvs && !this.views.length ? [place.x, place.y, atlas.width, atlas.height] : null;
  }

  /** From here on the pictures are the renderer's own. */
  keep() {
    this.#kept = true;
    this.pictures = this.pictures.map((picture) => kept(picture, this.frame));
  }

  /** Those that are there, and those that have to be decoded again. */
  async again() {
    const decode = async ({ video, file }) => {
      const blob = new Blob([file], { type: "image/jpeg" });
      return { video, image: await createImageBitmap(blob, { colorSpaceConversion: "none" }) };
    };
    const there = this.pictures.filter(({ image, planes, file }) => image || planes || file);
    return Promise.all(there.map((picture) => (picture.file ? decode(picture) : picture)));
  }

  close() {
    if (!this.#kept) return;
    for (const { image } of this.pictures) image?.close();
  }
}
