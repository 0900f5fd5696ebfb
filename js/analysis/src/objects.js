// The objects that a stream names, and which of them a piece of a mesh is: the key `objects` of META (spec/registry.md).

import { length, subtract } from "@fvv/shading";

import { piecesOf } from "./pieces.js";

const isCount = (value) => Number.isSafeInteger(value) && value >= 0;
const isPositive = (value) => Number.isFinite(value) && value > 0;
const isVector = (value) => Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);
const isPath = (path) =>
  Array.isArray(path) &&
  path.every((run) => Array.isArray(run) && run.length >= 4 && run.length % 3 === 1 && run.every(Number.isSafeInteger));

/** The value of a key in the first text of META that has it as isRight wants it; null: there is none. */
export function metadataOf({ metadata = [] }, key, isRight) {
  for (const text of metadata) {
    let value;
    try {
      value = JSON.parse(text)?.[key];
    } catch {
      continue;
    }
    if (isRight(value)) return value;
  }
  return null;
}

function isDescribed(value) {
  const { step, origin, unit, list, touching, splits } = value ?? {};
  if (!isCount(step) || step === 0 || !isVector(origin) || !isPositive(unit) || !Array.isArray(list)) return false;
  if (!list.every((one) => isCount(one?.id) && isPositive(one.radius) && isPath(one.path))) return false;
  if (!list.every(({ name }) => name === undefined || typeof name === "string")) return false;
  const ids = new Set(list.map(({ id }) => id));
  const owners = new Set(list.filter(({ of }) => of === undefined).map(({ id }) => id));
  if (!list.every(({ of }) => of === undefined || owners.has(of))) return false;
  if (ids.size !== list.length || !Array.isArray(touching) || !Array.isArray(splits)) return false;
  return (
    touching.every(
      (one) =>
        Array.isArray(one?.objects) &&
        one.objects.length > 1 &&
        one.objects.every((id) => ids.has(id)) &&
        isCount(one.from) &&
        isCount(one.to),
    ) && splits.every((one) => ids.has(one?.from) && ids.has(one.object) && isCount(one.time))
  );
}

/** The places of an object by number, in metres; null where it is nowhere. */
function placesOf(path, origin, unit) {
  const places = [];
  for (const [first, ...numbers] of path) {
    const now = [0, 0, 0];
    for (let i = 0; i < numbers.length; i += 3) {
      for (let k = 0; k < 3; k++) now[k] += numbers[i + k];
      places[first + i / 3] = now.map((x, k) => origin[k] + unit * x);
    }
  }
  return places;
}

export class ObjectPaths {
  #step;
  #objects = new Map(); // {id, name, radius, places}
  #touching;

  /** value: of the key `objects`, as the registry describes it. */
  constructor({ step, origin, unit, list, touching, splits }) {
    this.#step = step;
    /** Metres by which the coordinates of places are rounded at most. */
    this.rounding = unit / 2;
    for (const { id, name = "", of = id, radius, path } of list)
      this.#objects.set(id, { id, name, of, radius, places: placesOf(path, origin, unit) });
    this.#touching = touching.map(({ objects, from, to, sure = true }) => ({ objects, from, to, sure }));
    /** Pieces that came off: {from, object, time}. */
    this.splits = splits.map(({ from, object, time }) => ({ from, object, time: BigInt(time) }));
  }

  /** {id, name, radius} of each; name is "" where it has none. Parts of an object are left out. */
  get list() {
    const whole = Array.from(this.#objects.values()).filter(({ id, of }) => id === of);
    return whole.map(({ id, name, radius }) => ({ id, name, radius }));
  }
  /** Objects that are one piece of the meshes for a time: {objects, from, to, sure}, ticks, both included. */
  get touching() {
    return this.#touching.map(({ from, to, ...more }) => ({ ...more, from: BigInt(from), to: BigInt(to) }));
  }
  /** The identifier of an object by its name; null: there is none. */
  find(name) {
    for (const object of this.#objects.values()) if (object.name === name) return object.id;
    return null;
  }
  /** Where the centre of an object is, by the stream's path: between two of its places on the line. null: nowhere. */
  centreOf(id, time) {
    const places = this.#objects.get(id)?.places;
    if (!places) throw new RangeError(`no object has the identifier ${id}`);
    const at = Number(time) / this.#step;
    const [before, after] = [places[Math.floor(at)], places[Math.ceil(at)]];
    if (!before || !after) return null;
    const part = at - Math.floor(at);
    return before.map((x, k) => x + part * (after[k] - x));
  }
  /** The places that the stream gives of an object, [{time, centre}] in ticks and metres. */
  pathOf(id) {
    const places = this.#objects.get(id)?.places;
    if (!places) throw new RangeError(`no object has the identifier ${id}`);
    // Indices without a place are left out.
    return Object.entries(places).map(([i, centre]) => ({ time: BigInt(i) * BigInt(this.#step), centre }));
  }
  /** The objects that are one piece with an object at a time, in the order of the stream; [id] if it is alone. */
  together(id, time) {
    const at = Number(time);
    const touch = this.#touching.find(({ objects, from, to }) => objects.includes(id) && at >= from && at <= to);
    return [...new Set((touch?.objects ?? [id]).map((one) => this.#objects.get(one).of))];
  }
  /**
   * The objects that a piece with a centre is: the object, or the part of one, whose centre is nearest, if it is no further away
   * than its radius, and those that touch it then. Empty: none.
   */
  at(centre, time) {
    let nearest = null;
    let least = Infinity;
    for (const { id, radius } of this.#objects.values()) {
      const place = this.centreOf(id, time);
      const away = place ? length(subtract(centre, place)) : Infinity;
      if (away <= radius && away < least) [nearest, least] = [id, away];
    }
    return nearest === null ? [] : this.together(nearest, time);
  }
}

const known = new WeakMap();

/** The objects of a stream; null: it names none, or not as the registry describes them. Read once for a configuration. */
export function objectsOf(configuration) {
  let found = known.get(configuration);
  if (found === undefined) known.set(configuration, (found = read(configuration)));
  return found;
}

function read(configuration) {
  const value = metadataOf(configuration, "objects", isDescribed);
  return value && new ObjectPaths(value);
}

/** The objects that a face belongs to: one, several that touch, or none. */
export function objectsAt(frame, mesh, face) {
  const objects = objectsOf(frame.configuration);
  if (!objects) return [];
  const { ofFace, pieces } = piecesOf(mesh);
  return objects.at(pieces[ofFace[face]].centre, frame.time);
}

/**
 * The objects of a frame as its meshes have them: [{objects, centre, area, radius, track, piece}], of each piece of a mesh, those
 * without an object too. centre: of the piece, which is more exact than that of the path.
 */
export function piecesOfFrame(frame) {
  const objects = objectsOf(frame.configuration);
  return frame.meshes.flatMap((mesh) =>
    piecesOf(mesh).pieces.map(({ centre, area, radius, faces }, piece) => ({
      objects: objects ? objects.at(centre, frame.time) : [],
      centre,
      area,
      radius,
      faces,
      track: mesh.track,
      piece,
    })),
  );
}
