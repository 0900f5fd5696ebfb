// Small copies of pictures that were on screen, for the slider: they cost no decoding, and exist only for times that were
// shown.

import { element } from "./widgets.js";

/** The clip is divided into at most as many parts; each has one picture. */
const MAX_PARTS = 64;
/** Pixels of a copy. */
const WIDTH = 144;
/** Milliseconds between two copies, and after which a copy is replaced, because the viewer has moved. */
const INTERVAL = 400;
const OLD = 8000;

export class Previews {
  #kept = new Map(); // part -> {copy, at}
  #last = -Infinity;
  node = element("div", { class: "preview", hidden: true });

  #partOf(frame, frameCount) {
    return Math.floor((frame * Math.min(MAX_PARTS, frameCount)) / frameCount);
  }

  /** canvas: with the picture of a frame. */
  keep(canvas, frame, frameCount) {
    const now = performance.now();
    const part = this.#partOf(frame, frameCount);
    const former = this.#kept.get(part);
    if (now - this.#last < INTERVAL || now - (former?.at ?? -Infinity) < OLD) return;
    this.#last = now;
    const copy = former?.copy ?? element("canvas", {});
    copy.width = WIDTH;
    copy.height = Math.max(1, Math.round((WIDTH * canvas.height) / canvas.width));
    copy.getContext("2d").drawImage(canvas, 0, 0, copy.width, copy.height);
    this.#kept.set(part, { copy, at: now });
  }

  /** Shows the copy of the part with a frame, if there is one. */
  show(frame, frameCount) {
    const copy = this.#kept.get(this.#partOf(frame, frameCount))?.copy;
    this.node.hidden = !copy;
    if (copy && this.node.firstChild !== copy) this.node.replaceChildren(copy);
  }

  forget() {
    this.#kept.clear();
    this.node.replaceChildren();
    this.node.hidden = true;
  }
}
