// The values of a measurement over time, with the playhead and their uncertainty, as a small picture that seeks.

import { pathText, svg } from "./overlay.js";

const WIDTH = 240;
const HEIGHT = 72;
const EDGE = 4;

export class Graph {
  #from = 0;
  #to = 1;
  #band = svg("path", { class: "band" });
  #line = svg("path", { class: "curve" });
  #playhead = svg("line", { class: "playhead", y1: 0, y2: HEIGHT });
  #most = svg("text", { x: EDGE, y: 12 });
  #least = svg("text", { x: EDGE, y: HEIGHT - EDGE });
  node;

  /** seek(seconds) */
  constructor(seek) {
    this.node = svg(
      "svg",
      { class: "graph", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", preserveAspectRatio: "none" },
      this.#band,
      this.#line,
      this.#playhead,
      this.#most,
      this.#least,
    );
    this.node.addEventListener("click", ({ clientX }) => {
      const { left, width } = this.node.getBoundingClientRect();
      seek(this.#from + ((clientX - left) / width) * (this.#to - this.#from));
    });
  }

  /** samples: {seconds, value}; show(value): its text; now: seconds. */
  update(title, samples, show, now) {
    const known = samples.filter(({ value }) => value);
    if (known.length < 2) {
      for (const node of [this.#band, this.#line]) node.setAttribute("d", "");
      this.#most.textContent = "Play to fill the graph";
      this.#least.textContent = "";
      this.node.setAttribute("aria-label", `${title} over time: nothing yet`);
      return;
    }
    [this.#from, this.#to] = [known[0].seconds, known.at(-1).seconds];
    const values = known.map(({ value }) => value.value);
    const [least, most] = [Math.min(...values), Math.max(...values)];
    const range = most - least || 1;
    const x = (seconds) => ((seconds - this.#from) / (this.#to - this.#from || 1)) * WIDTH;
    const y = (value) => {
      const part = (value - least) / range;
      return HEIGHT - EDGE - Math.min(1.5, Math.max(-0.5, part)) * (HEIGHT - 2 * EDGE);
    };
    const runs = runsOf(samples);
    this.#line.setAttribute(
      "d",
      pathText(runs.map((run) => run.map(({ seconds, value }) => [x(seconds), y(value.value)]))),
    );
    const edge = (run, sign) =>
      run.map(({ seconds, value }) => [x(seconds), y(value.value + sign * value.uncertainty)]);
    const bands = runs.map((run) => [...edge(run, 1), ...edge(run, -1).reverse()]);
    this.#band.setAttribute("d", pathText(bands, true));
    for (const end of ["x1", "x2"]) this.#playhead.setAttribute(end, x(now));
    const at = (value) => show(known.find((one) => one.value.value === value).value);
    this.#most.textContent = at(most);
    this.#least.textContent = at(least);
    const seconds = (this.#to - this.#from).toFixed(1);
    this.node.setAttribute("aria-label", `${title} over ${seconds} seconds: from ${at(least)} to ${at(most)}`);
  }
}

/** What follows one another without a gap. */
function runsOf(samples) {
  const runs = [];
  let run = null;
  for (const sample of samples) {
    if (!sample.value) run = null;
    else if (run) run.push(sample);
    else runs.push((run = [sample]));
  }
  return runs.filter((one) => one.length > 1);
}
