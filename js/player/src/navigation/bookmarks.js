// Bookmarks of one player in the address of its page, under its id, or "fvv" without one.

import { findInHash, formatBookmark, parseBookmark, putIntoHash } from "./bookmark.js";

const JOURNEY = 0.6;

export class Bookmarks {
  #player;

  constructor(player, signal) {
    this.#player = player;
    addEventListener("hashchange", () => this.#follow(), { signal });
  }

  get #name() {
    return this.#player.id || "fvv";
  }
  get #said() {
    const text = this.#player.bookmarks ? findInHash(location.hash, this.#name) : null;
    return text === null ? null : parseBookmark(text);
  }

  /** Where playing begins: {seconds}, or null. */
  get place() {
    const seconds = this.#said?.seconds ?? null;
    return seconds === null ? null : { seconds };
  }
  /** The view that the address has, once there is something to see. */
  look(duration = 0) {
    const { camera, pose } = this.#said ?? {};
    const player = this.#player;
    if (player.cameras.some(({ id, calibrated }) => id === camera && calibrated))
      player.snapToCamera(camera, { duration });
    else if (pose) player.setPose(pose, { duration });
  }
  #follow() {
    const { place } = this;
    if (place) this.#player.currentTime = place.seconds;
    if (this.#player.cameras.length) this.look(JOURNEY);
  }

  get text() {
    const { currentTime: seconds, camera } = this.#player;
    return formatBookmark({ seconds, pose: this.#player.getPose(), camera });
  }
  /** Answers the whole address. */
  put() {
    const hash = putIntoHash(location.hash, this.#name, this.text);
    history.replaceState(history.state, "", hash);
    return location.href;
  }
}
