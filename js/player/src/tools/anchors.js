// What is measured: a place of the surface, or the centre of an object. Both are found again in other frames.

import { centreOf, objectsOf, pathOf, pointOf, SurfacePoint } from "@fvv/analysis";

/** A place that was picked. It is followed with its faces; where they are others it is known in its own frame only. */
class PlaceAnchor {
  #frame;
  #point;
  #surface;
  object = null;

  constructor(frame, picked, point, origin) {
    this.#frame = frame.number;
    this.#point = point;
    this.#surface = new SurfacePoint(frame, picked, origin);
  }
  in(frame) {
    if (frame.number === this.#frame) return this.#point;
    const place = this.#surface.in(frame);
    return place && pointOf(frame, place);
  }
  /** Nothing is known of frames that were not on screen. */
  path() {
    return null;
  }
  get name() {
    return "place";
  }
}

class ObjectAnchor {
  #name;

  constructor(object, name) {
    this.object = object;
    this.#name = name;
  }
  in(frame) {
    return centreOf(frame, this.object);
  }
  path(frame) {
    return pathOf(frame, this.object);
  }
  get name() {
    return this.#name;
  }
}

/** The name of an object for people. */
export const nameOf = ({ id, name }) => name || `object ${id}`;

/**
 * What a pick found as an anchor: {object, name, in(frame), path(frame)}, of which in returns a point, and path points of the whole stream or
 * null. centre: of the object that was met, if it is one. null: nothing is known of the uncertainty there.
 */
export function anchorOf(frame, picked, ray, centre) {
  const known =
    picked.object === null ? null : objectsOf(frame.configuration).list.find(({ id }) => id === picked.object);
  if (centre && known && centreOf(frame, picked.object)) return new ObjectAnchor(picked.object, nameOf(known));
  const point = pointOf(frame, picked);
  return point && new PlaceAnchor(frame, picked, point, ray.origin);
}
