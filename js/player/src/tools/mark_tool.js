// Drawing marks with the pointer, or place by place with the cross-hair.

import { cross, dot, normalise, subtract } from "@fvv/shading";

import { originOfMark, referenceOf, shapesOfMark } from "./marks.js";
import { onPlane } from "./projection.js";

/** Of the tool bar: how many places each takes, and its name. */
export const MARK_KINDS = {
  arrow: { places: 2, title: "Arrow" },
  line: { places: 2, title: "Line" },
  ellipse: { places: 2, title: "Ellipse" },
  freehand: { places: Infinity, title: "Freehand" },
  text: { places: 1, title: "Text" },
  trail: { places: 1, title: "Trail" },
};
const MOST_PLACES = 1000;
/** Pixels between two places of a freehand line. */
const APART = 4;

export class MarkTool {
  #kind;
  #parts;
  #begun = null; // {mark, origin, plane, spot}
  #pending = null; // the mark as it would be

  /**
   * look(spot): {frame, ray, view, picked} or null; floor(): {up, level}; style(): {colour, on, stays, seconds, text}; add(mark); say(text);
   * changed(): draws again.
   */
  constructor(kind, parts) {
    this.#kind = kind;
    this.#parts = parts;
    const asked = {
      text: "Choose where the text begins",
      trail: "Choose an object",
      freehand: "Draw; or choose places, and the last one twice",
    };
    parts.say(asked[kind] ?? "Draw, or choose the two ends");
  }
  get drags() {
    return MARK_KINDS[this.#kind].places > 1;
  }

  #begin(spot) {
    const found = this.#parts.look(spot);
    if (!found) return null;
    const { colour, on, stays, seconds, text } = this.#parts.style();
    const { frame, picked, ray } = found;
    const mark = { kind: this.#kind, colour };
    const { numerator, denominator } = frame.configuration.timeBase;
    if (seconds !== null) {
      mark.from = Number(frame.time);
      mark.to = mark.from + Math.round((seconds * denominator) / numerator);
    }
    const object = picked?.object ?? null;
    if (this.#kind === "trail") {
      if (object === null) return this.#refuse("There is no object that the stream names");
      return { mark: { kind: "trail", colour, object: referenceOf(object, frame) }, frame };
    }
    if (this.#kind === "text") {
      if (!text) return this.#refuse("First write the text");
      mark.text = text;
    }
    const floor = this.#parts.floor();
    const onSurface = on === "surface" && picked;
    const place = onSurface ? picked.position : floor && onPlane(ray, floor);
    if (!place) return this.#refuse("Nothing is there");
    if (onSurface && stays && object !== null) mark.object = referenceOf(object, frame);
    const origin = originOfMark(mark, frame) ?? [0, 0, 0];
    // What goes on beside the surface is as far away as its beginning.
    const { rotation: r } = found.view;
    const away = [r[6], r[7], r[8]];
    const plane = onSurface ? { up: away, level: dot(away, place) } : floor;
    const right = onSurface ? [r[0], r[1], r[2]] : normalise(cross(away, floor.up), [r[0], r[1], r[2]]);
    return { mark, origin, plane, right, across: cross(plane.up, right), onSurface, places: [place], spot };
  }
  #refuse(text) {
    this.#parts.say(text);
    return null;
  }

  #placeOf(spot) {
    const found = this.#parts.look(spot);
    if (!found) return null;
    // An ellipse is flat.
    if (this.#begun.onSurface && this.#kind !== "ellipse" && found.picked) return found.picked.position;
    return onPlane(found.ray, this.#begun.plane);
  }
  /** The mark of these places of the scene. */
  #markOf(places) {
    const { mark, origin, right, across } = this.#begun;
    let points = places;
    if (this.#kind === "ellipse") {
      const [one, other] = places;
      const middle = one.map((x, k) => (x + other[k]) / 2);
      const half = subtract(other, middle);
      const along = (axis) => middle.map((x, k) => x + dot(half, axis) * axis[k]);
      points = [middle, along(right), along(across)];
    }
    return { ...mark, points: points.map((point) => subtract(point, origin)) };
  }

  place(spot) {
    if (!this.#begun) {
      this.#begun = this.#begin(spot);
      if (this.#begun && MARK_KINDS[this.#kind].places === 1)
        this.#add(this.#kind === "trail" ? this.#begun.mark : this.#markOf(this.#begun.places));
      else if (this.#begun) this.#parts.say(this.#kind === "freehand" ? "Go on" : "Choose the other end");
      return this.#parts.changed();
    }
    const place = this.#placeOf(spot);
    if (!place) return this.#parts.say("Nothing is there");
    const { places, spot: former } = this.#begun;
    const again = Math.hypot(spot[0] - former[0], spot[1] - former[1]) < APART;
    if (this.#kind !== "freehand") this.#add(this.#markOf([places[0], place]));
    else if (again) this.finish(spot);
    else this.draw(spot);
    this.#parts.changed();
  }
  hover(spot) {
    if (!this.#begun) return;
    const place = spot && this.#placeOf(spot);
    const { places } = this.#begun;
    this.#pending = place ? this.#markOf(this.#kind === "freehand" ? [...places, place] : [places[0], place]) : null;
    this.#parts.changed();
  }
  /** Dragged on to a spot. */
  draw(spot) {
    if (!this.#begun) return;
    if (this.#kind === "freehand") {
      const { places, spot: former } = this.#begun;
      const isFar = Math.hypot(spot[0] - former[0], spot[1] - former[1]) >= APART;
      const place = isFar && places.length < MOST_PLACES ? this.#placeOf(spot) : null;
      if (place) Object.assign(this.#begun, { places: [...places, place], spot });
    }
    this.hover(spot);
  }
  finish(spot) {
    if (!this.#begun) return;
    const { places } = this.#begun;
    if (this.#kind === "freehand") {
      if (places.length > 1) this.#add(this.#markOf(places));
      else this.cancel();
      return;
    }
    const place = this.#placeOf(spot);
    if (place) this.#add(this.#markOf([places[0], place]));
    else this.cancel();
  }
  #add(mark) {
    this.#begun = this.#pending = null;
    this.#parts.add(mark);
  }
  cancel() {
    this.#begun = this.#pending = null;
    this.#parts.changed();
  }

  shapes(frame) {
    return this.#pending ? shapesOfMark(this.#pending, frame) : [];
  }
}
