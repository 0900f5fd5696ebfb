// A mesh that is another one in every frame, in buffers that are written anew.

import { GrowingBuffer } from "./textures.js";

const ATTRIBUTES = [
  ["positions", 3],
  ["normals", 3],
  ["uvs", 2],
];

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
    ATTRIBUTES.forEach(([name, components], i) => {
      if (!mesh[name]) return gl.disableVertexAttribArray(i);
      this.#buffer(name, gl.ARRAY_BUFFER).write(mesh[name]);
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, components, gl.FLOAT, false, 0, 0);
    });
    this.#buffer("indices", gl.ELEMENT_ARRAY_BUFFER).write(mesh.indices);
    gl.bindVertexArray(null);
  }

  draw() {
    const gl = this.#gl;
    gl.bindVertexArray(this.#array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.#buffer("indices").buffer);
    gl.drawElements(gl.TRIANGLES, this.#mesh.indices.length, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }

  /** The edges of all faces; they go to the GPU when somebody looks at them. */
  drawEdges() {
    const gl = this.#gl;
    gl.bindVertexArray(this.#array);
    const buffer = this.#buffer("edges", gl.ELEMENT_ARRAY_BUFFER);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer.buffer);
    if (!this.#edges) {
      this.#edges = edgesOf(this.#mesh.indices);
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

/** An edge between two faces is drawn once: with closed surfaces one of them has its corners in falling order. */
function edgesOf(indices) {
  const edges = [];
  for (let face = 0; face < indices.length; face += 3)
    for (let k = 0; k < 3; k++) {
      const [a, b] = [indices[face + k], indices[face + ((k + 1) % 3)]];
      if (a < b) edges.push(a, b);
    }
  return new Uint32Array(edges);
}
