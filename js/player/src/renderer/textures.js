// Textures and buffers of one context, which grow when more has to go in, and the count of bytes that went there.

/** Room for a quarter more: meshes of other topology differ by less from frame to frame. */
const SPARE = 1.25;

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

/** A texture of data, as large as the largest that it held. */
export class DataTexture {
  #gl;
  #formats;
  #uploads;
  texture = null;
  width = 0;
  height = 0;

  /** formats: {internal, format, type, texelBytes, filter} */
  constructor(gl, uploads, formats) {
    this.#gl = gl;
    this.#uploads = uploads;
    this.#formats = formats;
    this.resize(1, 1);
  }

  /** What was in it is lost when the size changes. */
  resize(width, height) {
    if (width === this.width && height === this.height) return;
    const gl = this.#gl;
    gl.deleteTexture(this.texture);
    this.texture = newTexture(gl, gl.TEXTURE_2D, this.#formats.filter);
    gl.texStorage2D(gl.TEXTURE_2D, 1, this.#formats.internal, width, height);
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

/** A buffer that is written anew in every frame. */
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
