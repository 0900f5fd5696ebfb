// Layers of one array texture that are drawn into, with a depth buffer.

/** formats: {internal, attachment} of the texture; depth: format of a depth buffer beside it, or null. */
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

  /** Draws into one after the other; each is cleared to zeros, and its depth to the farthest. */
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
