// A contact sheet: the pictures of all cameras beside each other, each in a cell.

import { planes } from "./overlay.js";
import { GrowingBuffer } from "./resources.js";

/** Space between cells, relative to the canvas's height. */
const GAP = 0.012;
const IDENTITY = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

/** {camera, source, place} of each picture of a camera: source is the part of the camera's picture, place that of the texture. */
export function tilesOf(frame, places) {
  const tiles = [];
  for (const video of frame.configuration.videos) {
    const at = places.get(video.track);
    if (!at || video.shows === "atlas") continue;
    for (const { camera: id, source, destination } of frame.tiles(video.track)) {
      const camera = frame.camera(id);
      if (!camera) continue;
      tiles.push({ camera, source, place: { ...destination, x: at.x + destination.x, y: at.y + destination.y } });
    }
  }
  return tiles;
}

/**
 * Cells for the cameras of tiles on a canvas of width x height, as large as possible: [{camera, x, y, width, height}], in
 * fractions of the canvas. bottom: the fraction at the bottom that is left free.
 */
export function sheetCells(tiles, width, height, bottom = 0) {
  const cameras = [...new Map(tiles.map(({ camera }) => [camera.id, camera])).values()];
  if (!cameras.length) return [];
  const aspect = Math.max(...cameras.map((camera) => camera.width / camera.height));
  const gap = GAP * height;
  const room = { width: width - gap, height: (1 - bottom) * height - gap };
  const layouts = cameras.map((_, i) => {
    const columns = i + 1;
    const rows = Math.ceil(cameras.length / columns);
    const across = Math.min(room.width / columns - gap, (room.height / rows - gap) * aspect);
    return { columns, rows, across };
  });
  const { columns, rows, across } = layouts.reduce((best, one) => (one.across > best.across ? one : best));
  const [dx, dy] = [across + gap, across / aspect + gap];
  const top = (room.height - rows * dy + gap) / 2 + gap / 2;
  return cameras.map((camera, i) => {
    const row = Math.floor(i / columns);
    const inRow = Math.min(columns, cameras.length - row * columns);
    const left = (width - inRow * dx + gap) / 2;
    // All cells have the height of the widest picture.
    const own = (across * (camera.width / camera.height)) / aspect;
    return {
      camera: camera.id,
      x: (left + (i - row * columns) * dx + (across - own) / 2) / width,
      y: (top + row * dy) / height,
      width: own / width,
      height: across / aspect / height,
    };
  });
}

export class Sheet {
  #gl;
  #programs;
  #counters;
  #array;
  #buffer;

  constructor(gl, programs, counters) {
    this.#gl = gl;
    this.#programs = programs;
    this.#counters = counters;
    this.#array = gl.createVertexArray();
    this.#buffer = new GrowingBuffer(gl, counters.uploads, gl.ARRAY_BUFFER);
    gl.bindVertexArray(this.#array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.#buffer.buffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 16, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 2, gl.FLOAT, false, 16, 8);
    gl.bindVertexArray(null);
  }

  /** Draws each tile where its camera's picture has it. */
  draw(tiles, cells, pictures) {
    const corners = tiles.flatMap((tile) => {
      const cell = cells.find(({ camera }) => camera === tile.camera.id);
      return cell ? cornersOf(tile, cell) : [];
    });
    if (!corners.length) return;
    const gl = this.#gl;
    gl.disable(gl.DEPTH_TEST);
    this.#buffer.write(new Float32Array(corners));
    pictures.makeLevels();
    const uniforms = { worldToClip: IDENTITY, pictureSize: pictures.size };
    this.#programs.get(planes).use(uniforms, { pictures: pictures.texture });
    gl.bindVertexArray(this.#array);
    gl.drawArrays(gl.TRIANGLES, 0, corners.length / 4);
    gl.bindVertexArray(null);
    this.#counters.drawCalls++;
  }

  close() {
    this.#buffer.close();
    this.#gl.deleteVertexArray(this.#array);
  }
}

/** Two triangles: x y in clip space, and a texel, for each corner. */
function cornersOf({ camera, source, place }, cell) {
  const corner = ([i, j]) => {
    const x = cell.x + cell.width * ((source.x + i * source.width) / camera.width);
    const y = cell.y + cell.height * ((source.y + j * source.height) / camera.height);
    return [2 * x - 1, 1 - 2 * y, place.x + i * place.width, place.y + j * place.height];
  };
  return [
    [0, 0],
    [1, 0],
    [0, 1],
    [0, 1],
    [1, 0],
    [1, 1],
  ].flatMap(corner);
}
