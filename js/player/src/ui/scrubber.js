// The bar that one scrubs on: a slider for everyone, with what is buffered, played and looped drawn beneath it.

import { element } from "./dom.js";
import { clockTime, spokenTime } from "./text.js";

export class Scrubber {
  #player;
  #buffered = []; // one for each range
  #played = element("div", { class: "played", part: "played" });
  #loop = element("div", { class: "looped", part: "loop", hidden: true });
  #tip = element("output", { class: "tip", "aria-hidden": "true", hidden: true });
  #track;
  #input;
  #dragging = false;

  constructor(player) {
    this.#player = player;
    this.#input = element("input", {
      type: "range",
      "aria-label": "Seek",
      min: 0,
      max: 1,
      step: "any",
      value: 0,
      disabled: true,
      oninput: () => this.#scrub(),
      onpointerdown: () => (this.#dragging = true),
      onpointerup: () => (this.#dragging = false),
      onpointercancel: () => (this.#dragging = false),
      onpointermove: (event) => this.#point(event),
      onpointerleave: () => (this.#tip.hidden = true),
    });
    this.#track = element("div", { class: "track" }, this.#loop, this.#played);
    this.node = element("div", { class: "scrubber", part: "scrubber" }, this.#track, this.#input, this.#tip);
  }

  get #range() {
    const { seekable, duration } = this.#player;
    if (seekable.length) return [seekable.start(0), seekable.end(0)];
    return [0, Number.isFinite(duration) && duration > 0 ? duration : 1];
  }

  #scrub() {
    this.#player.currentTime = Number(this.#input.value);
    this.update();
  }

  #point(event) {
    if (this.#input.disabled || event.pointerType === "touch") return;
    const { left, width } = this.#input.getBoundingClientRect();
    const share = Math.min(Math.max((event.clientX - left) / width, 0), 1);
    const [start, end] = this.#range;
    this.#tip.textContent = clockTime(start + share * (end - start));
    this.#tip.hidden = false;
    this.#tip.style.setProperty("--at", share);
  }

  update() {
    const player = this.#player;
    const [start, end] = this.#range;
    const share = (seconds) => Math.min(Math.max((seconds - start) / (end - start), 0), 1);
    const place = (node, from, to) => {
      node.style.setProperty("--from", share(from));
      node.style.setProperty("--to", Math.max(share(from), share(to)));
    };
    const input = this.#input;
    const now = player.currentTime;
    input.disabled = player.seekable.length === 0;
    // A slider that is changed while it is dragged lets go of the mouse.
    if (!this.#dragging) Object.assign(input, { min: start, max: end, value: now });
    // While it plays, once a second is often enough to hear.
    const spoken = `${spokenTime(player.paused ? now : Math.floor(now))} of ${spokenTime(end)}`;
    if (input.getAttribute("aria-valuetext") !== spoken) input.setAttribute("aria-valuetext", spoken);
    place(this.#played, start, now);
    const { buffered, loopRange } = player;
    for (const node of this.#buffered.splice(buffered.length)) node.remove();
    for (let i = 0; i < buffered.length; i++) {
      this.#buffered[i] ??= this.#track.insertBefore(
        element("div", { class: "buffered", part: "buffered" }),
        this.#loop,
      );
      place(this.#buffered[i], buffered.start(i), buffered.end(i));
    }
    this.#loop.hidden = loopRange === null;
    if (loopRange) place(this.#loop, loopRange.from, loopRange.to);
  }
}
