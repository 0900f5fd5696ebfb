// A place of the surface that is followed from frame to frame, as long as the meshes keep their faces.

import { add, cross, dot, scale, subtract, unit } from "@fvv/shading";

import { cornersOf, originOf } from "./pieces.js";

const known = new WeakMap();

/** Two hashes of the faces of a mesh and their number, as text: meshes with the same faces have the same. Found once for a mesh. */
function connectivityOf(mesh) {
  let found = known.get(mesh);
  if (found === undefined) {
    const { faces } = mesh;
    let [one, other] = [0x811c9dc5, 0x9e3779b9];
    for (let i = 0; i < faces.length; i++) {
      one = Math.imul(one ^ faces[i], 0x01000193);
      other = Math.imul((other << 5) ^ (other >>> 27) ^ faces[i], 0x85ebca6b);
    }
    known.set(mesh, (found = `${faces.length}:${one}:${other}`));
  }
  return found;
}

export class SurfacePoint {
  #track;
  #face;
  #barycentric;
  #origin;
  #connectivity;

  /** picked: what pick found in the frame, with a ray from origin. */
  constructor(frame, picked, origin) {
    this.#track = picked.track;
    this.#face = picked.face;
    this.#barycentric = picked.barycentric;
    this.#origin = origin;
    this.#connectivity = connectivityOf(frame.meshes.find(({ track }) => track === picked.track));
  }

  /**
   * The same place in another frame, {position, normal, face, track, facing}, of which pointOf makes a point; null: the faces are others.
   * facing: for a ray from where the place was picked.
   */
  in(frame) {
    const mesh = frame.meshes.find(({ track }) => track === this.#track);
    if (!mesh || connectivityOf(mesh) !== this.#connectivity) return null;
    const corners = cornersOf(mesh, this.#face);
    const position = add(originOf(mesh), corners.map((corner, k) => scale(corner, this.#barycentric[k])).reduce(add));
    const [a, b, c] = corners;
    const normal = unit(cross(subtract(b, a), subtract(c, a)));
    const along = unit(subtract(position, this.#origin));
    if (!normal || !along) return null;
    return { position, normal, face: this.#face, track: this.#track, facing: Math.abs(dot(normal, along)) };
  }
}
