// The sound of a clip in three's scene: a PositionalAudio for each track, at its place, or in the middle of the surface.

import { AudioListener, PositionalAudio, Vector3 } from "three";

const scale = new Vector3();

export class ClipAudio {
  #clip;
  #given;
  #own = null; // follows the camera that sees the clip
  #tracks = new Map(); // track -> {audio, moves: [{place, at}], isPlaced}
  #volume = 1;

  /** listener: the page's, or null. */
  constructor(clip, listener) {
    this.#clip = clip;
    this.#given = listener;
  }

  /** What Sound takes as its device. */
  open() {
    const { context } = this.#listener;
    const wayOf = (about) => this.#wayOf(about);
    const setVolume = (volume) => this.#setVolume(volume);
    return {
      context,
      wayOf,
      set volume(volume) {
        setVolume(volume);
      },
    };
  }

  get #listener() {
    return this.#given ?? (this.#own ??= new AudioListener());
  }

  /** The objects, each a child of the clip. */
  get sources() {
    return [...this.#tracks.values()].map(({ audio }) => audio);
  }

  #wayOf(about) {
    this.#remove(about.track);
    const audio = new PositionalAudio(this.#listener);
    const input = audio.context.createGain();
    audio.setNodeSource(input);
    audio.setVolume(this.#volume);
    audio.name = `sound ${about.track}`;
    this.#clip.add(audio);
    const track = { audio, moves: [], isPlaced: Boolean(about.position || about.moves) };
    if (about.position) audio.position.fromArray(about.position);
    this.#tracks.set(about.track, track);
    this.settle();
    return { input, place: (place, at) => track.moves.push({ place, at }) };
  }

  #setVolume(volume) {
    this.#volume = volume;
    for (const { audio } of this.#tracks.values()) audio.setVolume(volume);
  }

  /** Moves tracks to where they are now. For each picture of the screen. */
  move() {
    for (const { audio, moves } of this.#tracks.values())
      while (moves.length && moves[0].at <= audio.context.currentTime) audio.position.fromArray(moves.shift().place);
  }

  /** Another frame is shown: what has no place of its own is in the middle of it. */
  settle() {
    const { mesh } = this.#clip;
    const sphere = mesh.geometry.boundingSphere;
    if (!sphere) return;
    // Within the radius of the scene sound has its full volume.
    const radius = Math.max(sphere.radius * this.#clip.getWorldScale(scale).x, 1e-6);
    for (const { audio, isPlaced } of this.#tracks.values()) {
      if (!isPlaced) audio.position.copy(sphere.center).add(mesh.position);
      audio.setRefDistance(radius);
    }
  }

  /** The camera that draws the clip is the listener, if the page has none. */
  follow(camera) {
    if (!this.#own) return;
    camera.matrixWorld.decompose(this.#own.position, this.#own.quaternion, scale);
    this.#own.updateMatrixWorld();
  }

  #remove(number) {
    const track = this.#tracks.get(number);
    if (!track) return;
    track.audio.disconnect();
    track.audio.removeFromParent();
    this.#tracks.delete(number);
  }
  close() {
    for (const number of [...this.#tracks.keys()]) this.#remove(number);
  }
}
