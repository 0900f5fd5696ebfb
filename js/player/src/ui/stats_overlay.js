// Figures of playing, beside the picture.

import { element } from "./dom.js";
import { bitrateText, megabytes } from "./text.js";

const ROWS = [
  ["Frames/s", ({ framesPerSecond }) => framesPerSecond.toFixed(1)],
  ["Frame", ({ frame, frameCount }) => (frameCount ? `${frame} of ${frameCount}` : String(frame))],
  ["Decoding", ({ decodeMs }) => `${decodeMs.toFixed(1)} ms`],
  ["Showing", ({ showMs }) => `${showMs.toFixed(1)} ms`],
  ["Buffer", ({ bufferedSeconds }) => `${bufferedSeconds.toFixed(2)} s`],
  ["Bit rate", ({ bitrate }) => bitrateText(bitrate)],
  ["Dropped", ({ framesDropped, framesShown }) => `${framesDropped} of ${framesDropped + framesShown}`],
  ["Memory", ({ memoryBytes }) => megabytes(memoryBytes)],
  ["Pixels", ({ width, height }) => `${width}\u00d7${height}`],
  ["Draw calls", ({ drawCalls }) => String(drawCalls)],
];

export class StatsOverlay {
  #values = ROWS.map(() => element("dd", {}));

  constructor() {
    const rows = ROWS.flatMap(([name], i) => [element("dt", {}, name), this.#values[i]]);
    this.node = element("dl", { class: "stats", part: "stats", "aria-label": "Statistics", hidden: true }, ...rows);
  }
  update(stats) {
    ROWS.forEach(([, text], i) => (this.#values[i].textContent = text(stats)));
  }
}
