// Frames as users of the decoder get them.

import { revivePicture } from "./media/planar_picture.js";

/** The content of a visibility chunk. */
class Visibility {
  constructor(fields) {
    Object.assign(this, fields);
  }
  /** The visibility weight of each vertex, 0 to 255 (clause 17.4); null for other cameras. */
  weightsOf(camera) {
    const row = this.cameras.indexOf(camera);
    return row < 0 ? null : this.weights.subarray(row * this.vertexCount, (row + 1) * this.vertexCount);
  }
}

export class Frame {
  #closed = false;
  #layouts;
  constructor(raw, configuration, cameras) {
    const { numerator, denominator } = configuration.timeBase;
    this.number = raw.number;
    this.time = raw.time;
    this.seconds = (Number(raw.time) * numerator) / denominator;
    this.duration = (Number(configuration.frameDuration) * numerator) / denominator;
    this.edgeSeconds = raw.edge === null ? null : (Number(raw.edge) * numerator) / denominator;
    this.group = raw.group;
    this.configuration = configuration;
    this.meshes = raw.meshes;
    this.visibility = raw.visibility.map((fields) => new Visibility(fields));
    this.cameras = cameras;
    this.samples = raw.samples;
    this.tracks = raw.tracks;
    this.rung = raw.rung;
    this.#layouts = raw.layouts;
    this.pictures = raw.pictures.map(({ track, picture }) => ({ track, picture: revivePicture(picture) }));
    this.decodeMs = raw.decodeMs;
  }
  /** The mesh of the first mesh track; null if the frame has none. */
  get mesh() {
    return this.meshes[0] ?? null;
  }
  /** The camera with this identifier, as it is in this frame. */
  camera(id) {
    return this.cameras.find((camera) => camera.id === id) ?? null;
  }
  /** The picture of a video track, by default the first: VideoFrame, ImageBitmap or PlanarPicture. */
  picture(track) {
    const found = this.pictures.find((one) => track === undefined || one.track === track);
    return found?.picture ?? null;
  }
  /** Where each camera's picture is in the video of a track: the group's layout, else the configuration's. */
  tiles(track) {
    const { videos } = this.configuration;
    // A track that was left out has no layout either.
    const shown = this.tracks ? videos.filter((one) => this.tracks.includes(one.track)) : videos;
    const video = track === undefined ? shown[0] : shown.find((one) => one.track === track);
    if (!video) return [];
    return this.#layouts.find((layout) => layout.track === video.track)?.tiles ?? video.tiles;
  }
  /** Closes its pictures. Decoders of video have few of them and stall while they are open. */
  close() {
    if (this.#closed) return;
    this.#closed = true;
    for (const { picture } of this.pictures) picture.close();
    this.pictures = [];
  }
}
