// What a frame of the stream is to its user.

import { revivePicture } from "./planar_picture.js";

/** What one visibility chunk says. */
class Visibility {
  constructor(fields) {
    Object.assign(this, fields);
  }
  /** Of each element 0: averse, 1: hidden, 2: seen, of shares 3 to 6 too; null for a camera that is not told of. */
  of(camera) {
    const row = this.cameras.indexOf(camera);
    return row < 0 ? null : this.states.subarray(row * this.elementCount, (row + 1) * this.elementCount);
  }
  /** Of each vertex 0 to 255, as clause 17.4 makes them for shaders; null for such a camera, or without the option. */
  sharesOf(camera) {
    const row = this.cameras.indexOf(camera);
    return row < 0 || !this.shares ? null : this.shares.subarray(row * this.vertexCount, (row + 1) * this.vertexCount);
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
    this.group = raw.group;
    this.configuration = configuration;
    this.meshes = raw.meshes;
    this.visibility = raw.visibility.map((fields) => new Visibility(fields));
    this.cameras = cameras;
    this.samples = raw.samples;
    this.tracks = raw.tracks;
    this.#layouts = raw.layouts;
    this.pictures = raw.pictures.map(({ track, image }) => ({ track, image: revivePicture(image) }));
    this.decodeMs = raw.decodeMs;
  }
  /** The mesh of the first mesh track; null when the frame has none. */
  get mesh() {
    return this.meshes[0] ?? null;
  }
  /** The camera with an identifier as it is in this frame. */
  camera(id) {
    return this.cameras.find((camera) => camera.id === id) ?? null;
  }
  /** The picture of a video track: VideoFrame, ImageBitmap or PlanarPicture; without track that of the first. */
  picture(track) {
    const found = this.pictures.find((picture) => track === undefined || picture.track === track);
    return found?.image ?? null;
  }
  /** Where each camera's picture stands in the video of a track: the group's layout, else the configuration's. */
  tiles(track) {
    const { videos } = this.configuration;
    const video = track === undefined ? videos[0] : videos.find((one) => one.track === track);
    // Of a track that was left out nothing came, its layout neither.
    if (!video || (this.tracks && !this.tracks.includes(video.track))) return [];
    return this.#layouts.find((layout) => layout.track === video.track)?.tiles ?? video.tiles;
  }
  /** Lets its pictures go. Decoders of video have few of them and stall when they are kept. */
  close() {
    if (this.#closed) return;
    this.#closed = true;
    for (const { image } of this.pictures) image.close();
    this.pictures = [];
  }
}
