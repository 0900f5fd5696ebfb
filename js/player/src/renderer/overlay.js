// Overlays for orientation: cameras as frusta, bent by their lenses, optionally with their pictures, and a grid on the
// ground.

import { cross, normalise, subtract, viewFrom } from "@fvv/shading";

import { sphereOf } from "./matrices.js";
import { GrowingBuffer } from "./resources.js";

/** Points along a side of a picture. */
const STEPS = 8;
const OTHER = [0.45, 0.55, 0.65, 1];
const SELECTED = [1, 0.68, 0.2, 1];
const GRID = [0.3, 0.33, 0.37, 1];

const lines = {
  vertex: /* glsl */ `
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 colour;
uniform mat4 worldToClip;
out vec4 vColour;
void main() {
  vColour = colour;
  gl_Position = worldToClip * vec4(position, 1.0);
}
`,
  fragment: /* glsl */ `
in vec4 vColour;
layout(location = 0) out highp vec4 outColour;
void main() { outColour = vColour; }
`,
};

/** The pictures of cameras: position in clip space by worldToClip, and texel. */
export const planes = {
  vertex: /* glsl */ `
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 place;
uniform mat4 worldToClip;
out vec2 vPlace;
void main() {
  vPlace = place.xy;
  gl_Position = worldToClip * vec4(position, 1.0);
}
`,
  fragment: /* glsl */ `
uniform sampler2D pictures;
uniform vec2 pictureSize;
in vec2 vPlace;
layout(location = 0) out highp vec4 outColour;
void main() { outColour = vec4(texture(pictures, vPlace / pictureSize).rgb, 1.0); }
`,
};

/** R^T (depth ray - t): metres from where the translation counts. */
function place({ rotation: r, translation: t }, ray, depth) {
  const at = ray.map((x, i) => depth * x - t[i]);
  return [0, 1, 2].map((i) => r[i] * at[0] + r[3 + i] * at[1] + r[6 + i] * at[2]);
}

/** Seven floats per vertex: position from origin, and colour. */
function frustumLines(camera, origin, length, colour) {
  const { width, height } = camera;
  const local = viewFrom(origin, camera);
  const centre = subtract(camera.centre, origin);
  const rim = [];
  for (let i = 0; i < STEPS; i++) rim.push([(width * i) / STEPS, 0]);
  for (let i = 0; i < STEPS; i++) rim.push([width, (height * i) / STEPS]);
  for (let i = 0; i < STEPS; i++) rim.push([width - (width * i) / STEPS, height]);
  for (let i = 0; i < STEPS; i++) rim.push([0, height - (height * i) / STEPS]);
  const points = rim.map(([u, v]) => {
    const ray = camera.unproject(u, v);
    return ray && place(local, ray, length);
  });
  const out = [];
  points.forEach((point, i) => {
    const next = points[(i + 1) % points.length];
    if (point && next) out.push(...point, ...colour, ...next, ...colour);
    if (point && i % STEPS === 0) out.push(...centre, ...colour, ...point, ...colour);
  });
  return out;
}

/** The tile of a view as triangles. */
function pictureTriangles({ camera, translation, source, place: tile }, length) {
  const { rotation } = camera;
  const corner = (i, j) => {
    const ray = camera.unproject(source.x + (source.width * i) / STEPS, source.y + (source.height * j) / STEPS);
    const texel = [tile.x + (tile.width * i) / STEPS, tile.y + (tile.height * j) / STEPS];
    return ray && [...place({ rotation, translation }, ray, length), ...texel, 0, 0];
  };
  const out = [];
  for (let j = 0; j < STEPS; j++)
    for (let i = 0; i < STEPS; i++) {
      const corners = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
      if (corners.every((one) => one)) for (const k of [0, 1, 2, 2, 1, 3]) out.push(...corners[k]);
    }
  return out;
}

function gridLines({ centre: middle, up = [0, 1, 0], extent, step, colour = GRID }, origin) {
  const centre = subtract(middle, origin);
  const side = cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1]);
  const across = normalise(side);
  const along = cross(across, up);
  const at = (u, v) => centre.map((x, k) => x + u * across[k] + v * along[k]);
  const count = Math.round(extent / step);
  const out = [];
  for (let i = -count; i <= count; i++) {
    const u = i * step;
    out.push(...at(u, -extent), ...colour, ...at(u, extent), ...colour);
    out.push(...at(-extent, u), ...colour, ...at(extent, u), ...colour);
  }
  return out;
}

/** Relative to the radius of the scene. */
const LENGTH = 0.14;
const EXTENT = 1.2;
const STEP = 0.2;
/** Metres: the radius where nothing else is drawn. */
const RADIUS = 2.5;

/** Options of overlays with the lengths that suit a scene. bounds: of what is drawn, or null. */
export function sizedOverlays({ frusta, grid }, bounds) {
  const radius = (bounds && sphereOf(bounds).radius) || RADIUS;
  return {
    frusta: frusta && { ...frusta, length: frusta.length ?? LENGTH * radius },
    grid: grid && { ...grid, extent: grid.extent ?? EXTENT * radius, step: grid.step ?? STEP * radius },
  };
}

export class Overlay {
  #gl;
  #programs;
  #counters;
  #lines;
  #planes;
  #shown = null;

  constructor(gl, programs, counters) {
    this.#gl = gl;
    this.#programs = programs;
    this.#counters = counters;
    this.#lines = this.#vertices();
    this.#planes = this.#vertices();
  }

  #vertices() {
    const gl = this.#gl;
    const array = gl.createVertexArray();
    const buffer = new GrowingBuffer(gl, this.#counters.uploads, gl.ARRAY_BUFFER);
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer.buffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 28, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 4, gl.FLOAT, false, 28, 12);
    gl.bindVertexArray(null);
    return { array, buffer, count: 0 };
  }

  /** The views have changed. */
  forget() {
    this.#shown = null;
  }

  /** The result of sizedOverlays. views: of the frame; origin: what they count from. */
  prepare({ frusta, grid }, views, origin) {
    const shown = JSON.stringify([frusta?.length, frusta?.selected, frusta?.picturePlanes, frusta?.only, grid, origin]);
    if (this.#shown?.key === shown && this.#shown.cameras === frusta?.cameras) return;
    this.#shown = { key: shown, cameras: frusta?.cameras };
    const corners = grid ? gridLines(grid, origin) : [];
    const triangles = [];
    if (frusta) {
      const { cameras = [], selected = null, length, only = null } = frusta;
      for (const camera of only === null ? cameras : [])
        if (camera.calibrated)
          corners.push(...frustumLines(camera, origin, length, camera.id === selected ? SELECTED : OTHER));
      if (frusta.picturePlanes)
        for (const view of views)
          if (only === null || view.camera.id === only) triangles.push(...pictureTriangles(view, length));
    }
    this.#write(this.#lines, corners);
    this.#write(this.#planes, triangles);
  }

  #write(vertices, corners) {
    vertices.count = corners.length / 7;
    if (vertices.count) vertices.buffer.write(new Float32Array(corners));
  }

  draw({ worldToClip }, pictures) {
    const gl = this.#gl;
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    const draw = ({ array, count }, shaders, kind, textures) => {
      if (!count) return;
      this.#programs.get(shaders).use({ worldToClip, pictureSize: pictures.size }, textures);
      gl.bindVertexArray(array);
      gl.drawArrays(kind, 0, count);
      gl.bindVertexArray(null);
      this.#counters.drawCalls++;
    };
    if (this.#planes.count) pictures.makeLevels();
    draw(this.#planes, planes, gl.TRIANGLES, { pictures: pictures.texture });
    draw(this.#lines, lines, gl.LINES);
  }

  close() {
    for (const { array, buffer } of [this.#lines, this.#planes]) {
      buffer.close();
      this.#gl.deleteVertexArray(array);
    }
  }
}
