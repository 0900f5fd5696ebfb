// The content of a frame that the renderer keeps, also to draw it again after the loss of a context: everything but its
// pictures, which the caller closes. Pictures are kept as bytes or as clones.

import { layoutOf, loadPictures, viewsOf } from "@fvv/shading";

import { boundsOf } from "./matrices.js";

/** A picture that outlives its frame. Of a JPEG picture the file is kept, and decoded again if necessary. */
function keptPicture(picture, frame) {
  const { video, image, planes } = picture;
  if (planes) return picture;
  if (typeof VideoFrame === "function" && image instanceof VideoFrame) return { video, image: image.clone() };
  const sample = frame.samples.find(({ track }) => track === video.track);
  return { video, file: sample?.data ?? null };
}

export class Content {
  #kept = false;

  /** Loads the pictures of a frame. */
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
    // A texture atlas is used if there are no cameras.
    this.atlas = place && mesh?.uvs && !this.views.length ? [place.x, place.y, atlas.width, atlas.height] : null;
  }

  /** Replaces the frame's pictures by copies that this object owns. */
  keep() {
    this.#kept = true;
    this.pictures = this.pictures.map((picture) => keptPicture(picture, this.frame));
  }

  /** The kept pictures; JPEG files are decoded again. */
  async loadKept() {
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
