// The pictures of a frame in one texture of display values.

import {
  conversionOf,
  copyFragment,
  LEVELS,
  planesFragment,
  replicatedFragment,
  Replication,
  replicationFragment,
  replicationOf,
} from "@fvv/shading";

import { DataTexture, newTexture } from "./resources.js";

const wholeVertex = /* glsl */ `
void main() {
  // A triangle that covers the viewport.
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
`;
const planes = { vertex: wholeVertex, fragment: planesFragment };
const copy = { vertex: wholeVertex, fragment: copyFragment };
const replicated = { vertex: wholeVertex, fragment: replicatedFragment };
const replication = { vertex: wholeVertex, fragment: replicationFragment };

export class PictureTexture {
  #gl;
  #programs;
  #uploads;
  #planes = new Map(); // "track plane" -> DataTexture
  #images = new Map(); // track -> texture
  #target;
  #framebuffer;
  #empty;
  #replication = new Replication();
  #hasLevels = false;

  constructor(gl, programs, uploads) {
    this.#gl = gl;
    this.#programs = programs;
    this.#uploads = uploads;
    const formats = { internal: gl.RGBA8, filter: gl.LINEAR_MIPMAP_LINEAR, levels: LEVELS };
    this.#target = new DataTexture(gl, uploads, formats);
    this.#framebuffer = gl.createFramebuffer();
    this.#empty = gl.createVertexArray();
  }

  /** Only level 0 is valid, unless makeLevels() was called after show(). */
  get texture() {
    return this.#target.texture;
  }
  get size() {
    return [this.#target.width, this.#target.height];
  }

  /** layout: the result of layoutOf. */
  show(pictures, { places, width, height }) {
    const gl = this.#gl;
    const max = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (width > max || height > max)
      throw new RangeError(
        `the pictures of a frame need ${width}x${height} texels; textures have at most ${max} per side`,
      );
    this.#target.resize(Math.max(1, width), Math.max(1, height));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.#target.texture, 0);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.#empty);
    for (const picture of pictures) this.#draw(picture, places.get(picture.video.track));
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.#hasLevels = false;
    // Software samples two levels if the filter has them, even of pictures that are magnified.
    this.#filter(gl.LINEAR);
  }

  makeLevels() {
    if (this.#hasLevels) return;
    const gl = this.#gl;
    gl.bindTexture(gl.TEXTURE_2D, this.#target.texture);
    gl.generateMipmap(gl.TEXTURE_2D);
    this.#hasLevels = true;
    this.#filter(gl.LINEAR_MIPMAP_LINEAR);
  }

  #filter(filter) {
    const gl = this.#gl;
    gl.bindTexture(gl.TEXTURE_2D, this.#target.texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  }

  #draw(picture, { x, y }) {
    const gl = this.#gl;
    const { track, width, height, colour } = picture.video;
    gl.viewport(x, y, width, height);
    const draw = (shaders, uniforms, textures) => {
      this.#programs.get(shaders).use({ place: [x, y], ...conversionOf(colour), ...uniforms }, textures);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    };
    if (picture.planes) {
      const [Y, U, V] = picture.planes.map((plane, i) => this.#plane(`${track} ${i}`, plane));
      draw(planes, {}, { Y, U, V });
      return;
    }
    const source = { picture: this.#image(track, picture.picture) };
    const undone = replicationOf(picture);
    const isReplicated = this.#replication.isSeenIn(picture, () => {
      draw(replication, undone, source);
      const pixels = new Uint8Array(4 * width * height);
      gl.readPixels(x, y, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      return pixels;
    });
    draw(isReplicated ? replicated : copy, undone, source);
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
    // Tiles are addressed by rows from the top, and colours are those of the file.
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
