// The marks of a scene, what was undone, and where each is in a frame.

import { add, subtract } from "@fvv/shading";
import { objectsOf } from "@fvv/analysis";

import { nameOf } from "./anchors.js";
import { COLOURS } from "./style.js";

const MOST_STEPS = 200;
/** Sides of an ellipse, and seconds of a trail. */
const SIDES = 48;
const TRAIL = 2;

/** Dispatches "change" when the marks are others. */
export class Marks extends EventTarget {
  #states = [[]];
  #at = 0;

  get list() {
    return this.#states[this.#at];
  }
  get canUndo() {
    return this.#at > 0;
  }
  get canRedo() {
    return this.#at < this.#states.length - 1;
  }
  #take(marks) {
    this.#states = [...this.#states.slice(0, this.#at + 1), marks].slice(-MOST_STEPS);
    this.#at = this.#states.length - 1;
    this.dispatchEvent(new Event("change"));
  }
  add(mark) {
    this.#take([...this.list, Object.freeze(mark)]);
  }
  remove(mark) {
    this.#take(this.list.filter((one) => one !== mark));
  }
  /** In place of all, which can be undone. */
  set(marks) {
    this.#take(marks);
  }
  undo() {
    this.#at = Math.max(0, this.#at - 1);
    this.dispatchEvent(new Event("change"));
  }
  redo() {
    this.#at = Math.min(this.#states.length - 1, this.#at + 1);
    this.dispatchEvent(new Event("change"));
  }
}

/** The identifier of the object of a mark; null: it has none, or the stream does not know it. */
export function objectOf({ object }, frame) {
  const objects = objectsOf(frame.configuration);
  if (object === undefined || !objects) return null;
  if (typeof object === "string") return objects.find(object);
  return objects.list.some(({ id }) => id === object) ? object : null;
}
/** How a document names an object: by its name, or by its identifier where it has none. */
export function referenceOf(id, frame) {
  const { name } = objectsOf(frame.configuration).list.find((one) => one.id === id);
  return name || id;
}

/** Where the places of a mark count from in a frame; null: its object is not there. */
export function originOfMark(mark, frame) {
  if (mark.object === undefined) return [0, 0, 0];
  const id = objectOf(mark, frame);
  return id === null ? null : objectsOf(frame.configuration).centreOf(id, frame.time);
}

/** The places around an ellipse: its middle and the ends of two half axes. */
function ellipse([middle, one, other]) {
  const [a, b] = [subtract(one, middle), subtract(other, middle)];
  return Array.from({ length: SIDES + 1 }, (_, i) => {
    const angle = (2 * Math.PI * i) / SIDES;
    return middle.map((x, k) => x + Math.cos(angle) * a[k] + Math.sin(angle) * b[k]);
  });
}

/** The way of an object up to a frame. */
function trailOf(mark, frame) {
  const id = objectOf(mark, frame);
  if (id === null) return [];
  const objects = objectsOf(frame.configuration);
  const { numerator, denominator } = frame.configuration.timeBase;
  const now = Number(frame.time);
  const first = Math.max(mark.from ?? -Infinity, now - ((mark.seconds ?? TRAIL) * denominator) / numerator);
  const places = objects.pathOf(id).filter(({ time }) => Number(time) >= first && Number(time) <= now);
  const here = objects.centreOf(id, frame.time);
  const points = places.map(({ centre }) => centre);
  return here ? [...points, here] : points;
}

export const isShown = ({ from, to }, time) => !(Number(time) < from) && !(Number(time) > to);

/** What the overlay draws of a mark in a frame. */
export function shapesOfMark(mark, frame) {
  if (!isShown(mark, frame.time)) return [];
  const { kind, colour = COLOURS[0], width = 4, text } = mark;
  if (kind === "trail") {
    const points = trailOf(mark, frame);
    return points.length > 1 ? [{ kind: "line", points, colour, width }] : [];
  }
  const origin = originOfMark(mark, frame);
  if (!origin) return [];
  const points = mark.points.map((point) => add(origin, point));
  const label = text ? [{ kind: "text", at: points[0], text, colour, offset: kind === "text" ? [0, 0] : [8, -8] }] : [];
  if (kind === "text") return label;
  if (kind === "ellipse") {
    const around = ellipse(points);
    return [{ kind: "line", points: around, colour, width, closed: true, fill: true }, ...label];
  }
  return [{ kind: "line", points, colour, width, arrow: kind === "arrow" }, ...label];
}

/** "Arrow on ball, from 0:01.20", for people. */
export function describe({ kind, object, from, text }, frame, clock) {
  const title = kind[0].toUpperCase() + kind.slice(1);
  const known = frame && typeof object === "number" ? nameOf({ id: object, name: "" }) : object;
  const parts = [text ? `${title} “${text}”` : title];
  if (object !== undefined) parts.push(kind === "trail" ? `of ${known}` : `with ${known}`);
  if (from !== undefined && frame) {
    const { numerator, denominator } = frame.configuration.timeBase;
    parts.push(`from ${clock((from * numerator) / denominator)}`);
  }
  return parts.join(" ");
}
