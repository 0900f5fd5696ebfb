// The pictures of a frame in one texture of display values.

import { conversionOf, copyFragment, planesFragment } from "@fvv/shading";

import { DataTexture, newTexture } from "./textures.js";

const wholeVertex = /* glsl */ `
void main() {
  // A triangle that covers the viewport.
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
`;
const planes = { vertex: wholeVertex, fragment: planesFragment };
const copy = { vertex: wholeVertex, fragment: copyFragment };

export class PictureTexture {
  #gl;
  #programs;
  #uploads;
  #planes = new Map(); // "track plane" -> DataTexture
  #images = new Map(); // track -> texture
  #target;
  #framebuffer;
  #empty;

  constructor(gl, programs, uploads) {
    this.#gl = gl;
    this.#programs = programs;
    this.#uploads = uploads;
    this.#target = new DataTexture(gl, uploads, { internal: gl.RGBA8, filter: gl.LINEAR });
    this.#framebuffer = gl.createFramebuffer();
    this.#empty = gl.createVertexArray();
  }

  get texture() {
    return this.#target.texture;
  }
  get size() {
    return [this.#target.width, this.#target.height];
  }

  /** layout: of all of them, as layoutOf tells. */
  show(pictures, { places, width, height }) {
    const gl = this.#gl;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (width > most || height > most)
      throw new RangeError(
        `the pictures of a frame take ${width}x${height}; textures here have at most ${most} a side`,
      );
    this.#target.resize(Math.max(1, width), Math.max(1, height));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.#target.texture, 0);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.#empty);
    for (const picture of pictures) {
      const { track, width: columns, height: rows, colour } = picture.video;
      const { x, y } = places.get(track);
      gl.viewport(x, y, columns, rows);
      const uniforms = { place: [x, y] };
      if (picture.planes) {
        const [Y, U, V] = picture.planes.map((plane, i) => this.#plane(`${track} ${i}`, plane));
        this.#programs.get(planes).use({ ...uniforms, ...conversionOf(colour) }, { Y, U, V });
      } else {
        this.#programs.get(copy).use(uniforms, { picture: this.#image(track, picture.image) });
      }
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  #plane(key, { data, width, height }) {
    const gl = this.#gl;
    let plane = this.#planes.get(key);
    if (!plane) {
      const formats = { internal: gl.R8, format: gl.RED, type: gl.UNSIGNED_BYTE, texelBytes: 1, filter: gl.LINEAR };
      this.#planes.set(key, (plane = new DataTexture(gl, this.#uploads, formats)));
    }
    plane.resize(width, height);
    plane.write(data, width, height);
    return plane.texture;
  }

  #image(track, image) {
    const gl = this.#gl;
    if (!this.#images.has(track)) this.#images.set(track, newTexture(gl, gl.TEXTURE_2D, gl.NEAREST));
    const texture = this.#images.get(track);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    // Tiles are found by their rows from the top, and colours are those of the file.
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    this.#uploads.add(4 * (image.displayWidth ?? image.width) * (image.displayHeight ?? image.height));
    return texture;
  }

  close() {
    const gl = this.#gl;
    for (const plane of this.#planes.values()) plane.close();
    for (const texture of this.#images.values()) gl.deleteTexture(texture);
    this.#target.close();
    gl.deleteFramebuffer(this.#framebuffer);
    gl.deleteVertexArray(this.#empty);
  }
}
