// Where the scene is in the viewer's room: its scale, turn and place on the floor, and from these the views of both eyes. The
// room has metres, y up and its floor at 0, as WebXR's local-floor.

import { add, cross, dot, normalise, scale as times, subtract } from "@fvv/shading";

/** Scenes of these radii in metres keep their size; others, and those of unknown scale, get a radius of one metre. */
const NATURAL = [0.15, 12];
const RADIUS = 1;
/** Metres between the viewer and the nearest part of the scene, and the maximum to its middle. */
const CLEARANCE = 1;
const FARTHEST = 6;
/** Limits of the scale, relative to the first. */
const SCALES = [0.02, 20];
const EYE_HEIGHT = 1.6;

/** A direction without its vertical part. */
const level = ([x, , z]) => normalise([x, 0, z]);
const turned = ([x, y, z], angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c * x + s * z, y, c * z - s * x];
};

export class Placement {
  #rows; // from the stream's axes to right, up and backward of the room, for turn 0
  #pivot; // of the stream
  #first;
  /** Radians around the vertical through anchor. */
  turn;
  /** Metres of the room per metre of the stream. */
  scale;
  /** The place in the room of the middle of the scene's floor. */
  anchor;

  /**
   * extent, axes: of the scene, {centre, radius}, {up, front}. floor: height of its lowest point along up; null: the centre is
   * at the height of the viewer's eyes. eye: the viewer's place in
   * the stream, who continues to see the scene from that side. scaleKnown: lengths of the stream are metres.
   */
  constructor({ extent, axes, floor, eye, scaleKnown }) {
    const { centre, radius } = extent;
    const { up } = axes;
    const rise = (point) => dot(point, up);
    const towards = subtract(eye, centre);
    const back = normalise(subtract(towards, times(up, rise(towards))), axes.front);
    this.#rows = [cross(up, back), up, back];
    const natural = scaleKnown && radius >= NATURAL[0] && radius <= NATURAL[1];
    this.scale = this.#first = natural ? 1 : RADIUS / radius;
    const below = floor === null ? EYE_HEIGHT / this.scale : rise(centre) - floor;
    this.#pivot = subtract(centre, times(up, below));
    this.distance = Math.min(radius * this.scale + CLEARANCE, FARTHEST);
    this.turn = 0;
    this.anchor = [0, 0, -this.distance];
  }

  /** Puts the scene in front of the viewer. matrix: of the viewer in the room, by columns. floorKnown: y is 0 on the floor. */
  face(matrix, floorKnown = true) {
    const back = level(matrix.slice(8, 11));
    const [x, y, z] = matrix.slice(12, 15);
    this.turn = Math.atan2(back[0], back[2]);
    this.anchor = [x - this.distance * back[0], floorKnown ? 0 : y - EYE_HEIGHT, z - this.distance * back[2]];
  }

  turnBy(angle) {
    this.turn += angle;
  }
  scaleBy(factor) {
    const [min, max] = SCALES.map((limit) => limit * this.#first);
    this.scale = Math.min(Math.max(this.scale * factor, min), max);
  }
  moveBy(offset) {
    this.anchor = add(this.anchor, offset);
  }
  /** Moves, turns and scales the scene as two hands do that held the points from and now hold the points to. */
  hold([a, b], [c, d]) {
    const [before, after] = [subtract(b, a), subtract(d, c)];
    const angle = Math.atan2(after[0], after[2]) - Math.atan2(before[0], before[2]);
    const former = this.scale;
    this.scaleBy(Math.hypot(...after) / Math.max(1e-3, Math.hypot(...before)));
    const [middle, goal] = [times(add(a, b), 0.5), times(add(c, d), 0.5)];
    const held = times(turned(subtract(this.anchor, middle), angle), this.scale / former);
    this.turn += angle;
    this.anchor = add(goal, held);
  }

  /** A direction of the room in the stream's axes. */
  #toStream(direction) {
    const [x, y, z] = turned(direction, -this.turn);
    const [right, up, back] = this.#rows;
    return add(add(times(right, x), times(up, y)), times(back, z));
  }

  /**
   * The view of an eye, for the renderer. matrix: of the eye in the room; projection: of WebXR; viewport: {x, y, width,
   * height}, y up.
   */
  view(matrix, projection, { x, y, width, height }) {
    const column = (i) => Array.from(matrix.slice(4 * i, 4 * i + 3));
    const right = this.#toStream(column(0));
    const down = times(this.#toStream(column(1)), -1);
    const forward = times(this.#toStream(column(2)), -1);
    const offset = times(this.#toStream(subtract(column(3), this.anchor)), 1 / this.scale);
    const eye = add(this.#pivot, offset);
    return {
      rotation: [...right, ...down, ...forward],
      translation: [right, down, forward].map((row) => -dot(row, eye)),
      fx: (projection[0] * width) / 2,
      fy: (projection[5] * height) / 2,
      cx: ((1 - projection[8]) * width) / 2,
      cy: ((1 + projection[9]) * height) / 2,
      x,
      y,
      width,
      height,
    };
  }
}
