// Measuring with the pointer or the cross-hair: places are collected until the measurement has all of them.

import { anchorOf } from "./anchors.js";
import { KINDS } from "./measurements.js";
import { COLOURS } from "./style.js";

/** Seconds of movement that the arrow of a speed shows. */
const AHEAD = 0.25;
const UNCERTAIN = "The stream does not say how exact its meshes are there, so nothing is measured";

export class MeasureTool {
  #kind;
  #look;
  #measurements;
  #say;
  #changed;
  #done;
  #anchors = [];
  #hovered = null;
  drags = false;
  /** Whether clicks on an object mean its centre. */
  centre = true;

  /** look(spot): {frame, ray, picked} or null; say(text): for people; changed(): draws again; done(measurement): it is complete. */
  constructor(kind, { look, measurements, say, changed, done }) {
    this.#kind = kind;
    this.#look = look;
    this.#measurements = measurements;
    this.#say = say;
    this.#changed = changed;
    this.#done = done;
    this.#ask();
  }

  #ask() {
    const wanted = KINDS[this.#kind].anchors;
    if (wanted === 1) this.#say(this.#kind === "speed" ? "Choose what moves" : "Choose a place");
    else this.#say(this.#anchors.length ? "Choose the second place" : "Choose the first of two places");
  }
  place(spot) {
    const found = this.#look(spot);
    if (!found?.picked) return this.#say("Nothing is there");
    const anchor = anchorOf(found.frame, found.picked, found.ray, this.centre);
    if (!anchor) return this.#say(UNCERTAIN);
    this.#anchors.push(anchor);
    if (this.#anchors.length < KINDS[this.#kind].anchors) this.#ask();
    else this.#done(this.#measurements.add(this.#kind, this.#anchors.splice(0)));
    this.#changed();
  }
  hover(spot) {
    this.#hovered = spot && this.#anchors.length ? (this.#look(spot)?.picked?.position ?? null) : null;
    if (this.#anchors.length) this.#changed();
  }
  cancel() {
    this.#anchors = [];
    this.hover(null);
  }

  /** What is chosen so far. */
  shapes(frame) {
    const places = this.#anchors.map((anchor) => anchor.in(frame)?.position).filter(Boolean);
    const colour = COLOURS[0];
    const dots = places.map((at) => ({ kind: "dot", at, colour }));
    if (!places.length || !this.#hovered) return dots;
    return [...dots, { kind: "line", points: [places[0], this.#hovered], colour, width: 2, faint: true }];
  }
}

const middle = (a, b) => a.map((x, k) => (x + b[k]) / 2);

/** The shapes of a measurement in the scene. text: of its value; up: of the scene. */
export function shapesOf({ id, kind, points, value, velocity }, text, up) {
  if (!value || points.some((point) => !point)) return [];
  const colour = COLOURS[id % COLOURS.length];
  const places = points.map(({ position }) => position);
  const dots = places.map((at) => ({ kind: "dot", at, colour }));
  const [at] = places;
  if (kind === "distance")
    return [
      { kind: "line", points: places, colour },
      ...dots,
      { kind: "text", at: middle(...places), text, colour, offset: [8, -8] },
    ];
  if (kind === "height") {
    const foot = at.map((x, k) => x - value.value * up[k]);
    return [
      { kind: "line", points: [at, foot], colour },
      ...dots,
      { kind: "text", at: middle(at, foot), text, colour, offset: [8, 4] },
    ];
  }
  const tip = velocity && at.map((x, k) => x + AHEAD * velocity[k]);
  const arrow = tip ? [{ kind: "line", points: [at, tip], colour, arrow: true }] : [];
  return [...arrow, ...dots, { kind: "text", at, text, colour, offset: [10, -10] }];
}
