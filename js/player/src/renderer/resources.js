// Textures, buffers and layers of one WebGL context, and the count of uploaded bytes.

import { pointsOf } from "@fvv/shading";

/** Allocates a quarter more: sizes of meshes with changing topology differ by less from frame to frame. */
const SPARE = 1.25;

/** Counts uploaded bytes. */
export class Uploads {
  bytes = 0;
  add(bytes) {
    this.bytes += bytes;
  }
}

export function newTexture(gl, target, filter, wrap = gl.CLAMP_TO_EDGE) {
  const texture = gl.createTexture();
  gl.bindTexture(target, texture);
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, filter === gl.NEAREST ? gl.NEAREST : gl.LINEAR);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, wrap);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, wrap);
  return texture;
}

/** A texture that data are written to. */
export class DataTexture {
  #gl;
  #formats;
  #uploads;
  texture = null;
  width = 0;
  height = 0;

  /** formats: {internal, format, type, texelBytes, filter, levels}; levels: at most as many, 1 by default. */
  constructor(gl, uploads, formats) {
    this.#gl = gl;
    this.#uploads = uploads;
    this.#formats = formats;
    this.resize(1, 1);
  }

  /** A change of size discards the contents. */
  resize(width, height) {
    if (width === this.width && height === this.height) return;
    const gl = this.#gl;
    gl.deleteTexture(this.texture);
    this.texture = newTexture(gl, gl.TEXTURE_2D, this.#formats.filter);
    const { internal, levels = 1 } = this.#formats;
    gl.texStorage2D(
      gl.TEXTURE_2D,
      Math.min(levels, 1 + Math.floor(Math.log2(Math.max(width, height)))),
      internal,
      width,
      height,
    );
    Object.assign(this, { width, height });
  }

  /** Writes the first rows. */
  write(data, width, height) {
    const gl = this.#gl;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const { format, type, texelBytes } = this.#formats;
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, format, type, data);
    this.#uploads.add(width * height * texelBytes);
  }

  close() {
    this.#gl.deleteTexture(this.texture);
    this.texture = null;
  }
}

/** A buffer that is rewritten with every frame, and grows if necessary. */
export class GrowingBuffer {
  #gl;
  #target;
  #uploads;
  #size = 0;

  constructor(gl, uploads, target) {
    this.#gl = gl;
    this.#uploads = uploads;
    this.#target = target;
    this.buffer = gl.createBuffer();
  }

  /** Leaves the buffer bound. */
  write(data) {
    const gl = this.#gl;
    gl.bindBuffer(this.#target, this.buffer);
    if (data.byteLength > this.#size) {
      this.#size = Math.ceil(SPARE * data.byteLength);
      gl.bufferData(this.#target, this.#size, gl.DYNAMIC_DRAW);
    }
    gl.bufferSubData(this.#target, 0, data);
    this.#uploads.add(data.byteLength);
  }

  close() {
    this.#gl.deleteBuffer(this.buffer);
  }
}

/** Layers of an array texture that are drawn into. formats: {internal, attachment, comparison, depth}; depth: the format of an
 * additional depth buffer, or undefined. */
export class Layers {
  #gl;
  #formats;
  #framebuffer;
  #depth = null;
  texture = null;
  width = 0;
  height = 0;
  layers = 0;

  constructor(gl, formats) {
    this.#gl = gl;
    this.#formats = formats;
    this.#framebuffer = gl.createFramebuffer();
    this.resize({ width: 1, height: 1, layers: 1 });
  }

  resize({ width, height, layers }) {
    if (width === this.width && height === this.height && layers === this.layers) return;
    const gl = this.#gl;
    const { internal, comparison, depth } = this.#formats;
    gl.deleteTexture(this.texture);
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    const filter = comparison ? gl.LINEAR : gl.NEAREST;
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    if (comparison) gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, internal, width, height, layers);
    if (depth) {
      gl.deleteRenderbuffer(this.#depth);
      this.#depth = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, this.#depth);
      gl.renderbufferStorage(gl.RENDERBUFFER, depth, width, height);
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.#depth);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }
    Object.assign(this, { width, height, layers });
  }

  /** Calls draw(layer) for each layer, which is cleared to zeros, and its depth to the maximum. */
  draw(layers, draw) {
    const gl = this.#gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
    gl.viewport(0, 0, this.width, this.height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    gl.clearColor(0, 0, 0, 0);
    for (const layer of layers) {
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, this.#formats.attachment, this.texture, 0, layer);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      draw(layer);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  close() {
    const gl = this.#gl;
    gl.deleteTexture(this.texture);
    gl.deleteRenderbuffer(this.#depth);
    gl.deleteFramebuffer(this.#framebuffer);
  }
}

/** Names and components; bytes are fractions of 255. */
const ATTRIBUTES = [
  ["points", 3],
  ["normals", 3],
  ["uvs", 2],
  ["colours", 4],
];

/** The buffers of a mesh that changes with every frame. */
export class MeshBuffers {
  #gl;
  #uploads;
  #array;
  #buffers = new Map();
  #mesh = null;
  #edges = null;

  constructor(gl, uploads) {
    this.#gl = gl;
    this.#uploads = uploads;
    this.#array = gl.createVertexArray();
  }

  #buffer(name, target) {
    let buffer = this.#buffers.get(name);
    if (!buffer) this.#buffers.set(name, (buffer = new GrowingBuffer(this.#gl, this.#uploads, target)));
    return buffer;
  }

  show(mesh) {
    const gl = this.#gl;
    this.#mesh = mesh;
    this.#edges = null;
    gl.bindVertexArray(this.#array);
    const arrays = { ...mesh, points: pointsOf(mesh) };
    ATTRIBUTES.forEach(([name, components], i) => {
      if (!arrays[name]) return gl.disableVertexAttribArray(i);
      this.#buffer(name, gl.ARRAY_BUFFER).write(arrays[name]);
      gl.enableVertexAttribArray(i);
      const bytes = arrays[name] instanceof Uint8Array;
      gl.vertexAttribPointer(i, components, bytes ? gl.UNSIGNED_BYTE : gl.FLOAT, bytes, 0, 0);
    });
    this.#buffer("indices", gl.ELEMENT_ARRAY_BUFFER).write(mesh.faces);
    gl.bindVertexArray(null);
  }

  draw() {
    const gl = this.#gl;
    gl.bindVertexArray(this.#array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.#buffer("indices").buffer);
    gl.drawElements(gl.TRIANGLES, this.#mesh.faces.length, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }

  /** Draws the edges of all faces, which are uploaded on the first call. */
  drawEdges() {
    const gl = this.#gl;
    gl.bindVertexArray(this.#array);
    const buffer = this.#buffer("edges", gl.ELEMENT_ARRAY_BUFFER);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer.buffer);
    if (!this.#edges) {
      this.#edges = edgesOf(this.#mesh.faces);
      buffer.write(this.#edges);
    }
    gl.drawElements(gl.LINES, this.#edges.length, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }

  close() {
    for (const buffer of this.#buffers.values()) buffer.close();
    this.#gl.deleteVertexArray(this.#array);
  }
}

/** Each edge between two faces once: on closed surfaces one of the two faces has its corners in descending order. */
function edgesOf(indices) {
  const edges = [];
  for (let face = 0; face < indices.length; face += 3)
    for (let k = 0; k < 3; k++) {
      const [a, b] = [indices[face + k], indices[face + ((k + 1) % 3)]];
      if (a < b) edges.push(a, b);
    }
  return new Uint32Array(edges);
}
