// The measurements of a scene: what each is of, its value in the frame on screen, and its values over time.

import { csv, distance, floorOf, height, motion } from "@fvv/analysis";

/** How many anchors each kind has, its quantity, and its name. */
export const KINDS = {
  distance: { anchors: 2, quantity: "length", title: "Distance" },
  height: { anchors: 1, quantity: "length", title: "Height" },
  speed: { anchors: 1, quantity: "speed", title: "Speed" },
};

/** Dispatches "change" when the list is another one, or has other values. */
export class Measurements extends EventTarget {
  #list = [];
  #next = 1;
  #floor = null; // the lowest one of the frames on screen
  #frame = null;

  /** {id, kind, anchors, points, value, samples}: points and value of the frame on screen, null where they are unknown; samples:
   * {frame, seconds, value} of frames whose values are known, value null if it is not. */
  get list() {
    return this.#list;
  }

  add(kind, anchors) {
    const measurement = { id: this.#next++, kind, anchors, points: [], value: null, samples: [], seen: new Map() };
    this.#list = [...this.#list, measurement];
    if (this.#frame) {
      this.#seeFloor(this.#frame);
      this.#prepare(measurement, this.#frame);
      this.#measure(measurement, this.#frame);
    }
    this.dispatchEvent(new Event("change"));
    return measurement;
  }
  remove(id) {
    this.#list = this.#list.filter((one) => one.id !== id);
    this.dispatchEvent(new Event("change"));
  }
  clear() {
    this.#list = [];
    this.#floor = this.#frame = null;
    this.dispatchEvent(new Event("change"));
  }

  /** frame: the one on screen. */
  advance(frame) {
    this.#frame = frame;
    if (!this.#list.length) return;
    this.#seeFloor(frame);
    for (const measurement of this.#list) this.#measure(measurement, frame);
    this.dispatchEvent(new Event("change"));
  }

  /** The lowest place of all frames so far: in a frame in which all jump none is on the floor. */
  #seeFloor(frame) {
    if (!this.#list.some(({ kind }) => kind === "height")) return;
    const floor = floorOf(frame);
    if (floor && !(this.#floor?.level <= floor.level)) this.#floor = floor;
  }

  #value(kind, points) {
    if (points.some((point) => !point)) return null;
    if (kind === "distance") return distance(...points);
    return this.#floor && height(points[0], this.#floor);
  }

  /** Values of the whole stream, where its paths give them. */
  #prepare(measurement, frame) {
    const { kind, anchors } = measurement;
    const paths = anchors.map((anchor) => anchor.path(frame));
    if (paths.some((path) => !path?.length)) return;
    if (kind === "speed") return this.#takeMotion(measurement, paths[0]);
    const others = paths.slice(1).map((path) => new Map(path.filter(Boolean).map((point) => [point.time, point])));
    measurement.samples = paths[0].filter(Boolean).map((point) => ({
      seconds: point.seconds,
      value: this.#value(kind, [point, ...others.map((other) => other.get(point.time))]),
    }));
    measurement.isWhole = true;
  }
  #takeMotion(measurement, points) {
    const moved = motion(points);
    measurement.samples = moved.map((one, i) => ({
      seconds: points[i]?.seconds ?? null,
      value: one?.speed ?? null,
      velocity: one?.velocity,
    }));
    measurement.samples = measurement.samples.filter(({ seconds }) => seconds !== null);
    measurement.isWhole = true;
  }

  #measure(measurement, frame) {
    const { kind, anchors, seen } = measurement;
    const points = anchors.map((anchor) => anchor.in(frame));
    measurement.points = points;
    if (kind === "speed") {
      if (!measurement.isWhole && points[0]) this.#see(measurement, frame, points[0]);
      const sample = this.#sampleAt(measurement, frame);
      measurement.value = sample?.value ?? null;
      measurement.velocity = sample?.velocity ?? null;
      return;
    }
    measurement.value = this.#value(kind, points);
    if (measurement.isWhole) return;
    seen.set(frame.number, { seconds: frame.seconds, value: measurement.value });
    measurement.samples = [...seen].sort(([a], [b]) => a - b).map(([, sample]) => sample);
  }
  /** Speed of a picked place: from frames on either side, which have to be seen first. */
  #see(measurement, { number, seconds }, point) {
    const { seen } = measurement;
    seen.set(number, { seconds, ...point });
    const numbers = [...seen.keys()].sort((a, b) => a - b);
    const first = numbers[0];
    // A frame that was left out interrupts the motion.
    const points = Array.from({ length: numbers.at(-1) - first + 1 }, (_, i) => seen.get(first + i) ?? null);
    measurement.samples = motion(points)
      .map((one, i) => points[i] && { seconds: points[i].seconds, value: one?.speed ?? null, velocity: one?.velocity })
      .filter(Boolean);
  }
  #sampleAt({ samples }, { seconds, duration }) {
    let nearest = null;
    for (const sample of samples)
      if (!nearest || Math.abs(sample.seconds - seconds) < Math.abs(nearest.seconds - seconds)) nearest = sample;
    return nearest && Math.abs(nearest.seconds - seconds) <= (duration || 0.04) * 1.01 ? nearest : null;
  }
}

/** The values over time as comma-separated values. */
export function csvOf({ kind, samples }) {
  return csv(samples.map(({ seconds, value }) => ({ seconds, [kind]: value ?? null })));
}
