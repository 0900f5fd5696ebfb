// A camera and its projection, which libfvv computes: the same numbers to the last bit as in C.

import { CAMERA_SIZE, writeCamera } from "./flat.js";

/** Projects for all cameras of a decoder. */
export class Projector {
  constructor(core) {
    this.core = core;
    this.camera = core.exports.fvvjs_alloc(CAMERA_SIZE);
    this.room = 0;
    this.buffer = 0;
  }
  /** doubles in, three doubles out for each of count. */
  run(name, camera, numbers, count) {
    const { core } = this;
    if (count > this.room) {
      if (this.buffer) core.exports.fvvjs_free(this.buffer);
      this.buffer = core.exports.fvvjs_alloc(48 * count);
      this.room = this.buffer ? count : 0;
      if (!this.buffer) throw new RangeError(`no memory to project ${count} points`);
    }
    writeCamera(core.memory, this.camera, camera);
    new Float64Array(core.memory.buffer, this.buffer, numbers.length).set(numbers);
    const out = this.buffer + 24 * count;
    core.exports[name](this.camera, this.buffer, count, out);
    return new Float64Array(core.memory.buffer, out, 3 * count).slice();
  }
}

export class Camera {
  #projector;
  constructor(fields, projector) {
    Object.assign(this, fields);
    this.#projector = projector;
    Object.freeze(this);
  }

  /** World metres -> [u, v, depth], or null where the camera does not see: behind it or beyond its lens. */
  project(x, y, z) {
    const [u, v, depth] = this.projectPoints([x, y, z]);
    return Number.isNaN(u) ? null : [u, v, depth];
  }
  /** x y z of any number of points -> u v depth of each, u and v NaN where the camera does not see. */
  projectPoints(points) {
    return this.#projector.run("fvvjs_project", this, points, Math.floor(points.length / 3));
  }
  /** Pixel -> the ray through it in the camera's frame, [x, y, 1], or null beyond the lens. */
  unproject(u, v) {
    const ray = this.#projector.run("fvvjs_unproject", this, [u, v], 1);
    return Number.isNaN(ray[0]) ? null : Array.from(ray);
  }
  /** Where the camera stands in the world: -R^T t. */
  get centre() {
    const { rotation: r, translation: t } = this;
    return [0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]));
  }
}
