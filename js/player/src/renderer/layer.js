// Colours the surface in a picture of its own, which may be smaller than the one that is drawn, and puts it into that where the
// mesh is drawn again: edges, and all around the surface, have full resolution.
//
// Software rasterisers run the shader of fragments that are hidden: here it finds out itself, and skips its work.

import { newTexture } from "./resources.js";

/** Of the fragment shader that colours. */
export const layerVisibility = /* glsl */ `
uniform highp sampler2D layerDepths;
bool isFirst() { return gl_FragCoord.z <= texelFetch(layerDepths, ivec2(gl_FragCoord.xy), 0).r + 1e-6; }
`;

/** The fragment shader that puts the layer into the picture, where the mesh is drawn. SCALED: if the layer is smaller. */
export const placedFragment = /* glsl */ `
uniform highp sampler2D layerColours, layerDepths;
uniform vec2 layerScale; // texels of the layer for a pixel
uniform vec2 layerSize;
uniform vec2 corner; // of the viewport
layout(location = 0) out highp vec4 outColour;

// How far the surface of a texel is from this one, in depth; 2: there is no surface.
float apart(ivec2 texel) {
  float depth = texelFetch(layerDepths, texel, 0).r;
  return depth < 1.0 ? abs(depth - gl_FragCoord.z) : 2.0;
}

void main() {
  vec2 at = (gl_FragCoord.xy - corner) * layerScale;
  ivec2 last = ivec2(layerSize) - 1;
  float alike = 2.0 * (abs(dFdx(gl_FragCoord.z)) + abs(dFdy(gl_FragCoord.z))) / min(layerScale.x, layerScale.y) + 1e-6;
  ivec2 own = min(ivec2(at), last);
#ifdef SCALED
  vec2 from = floor(at - 0.5), part = at - 0.5 - from;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < 4; i++) {
    ivec2 next = ivec2(i & 1, i >> 1);
    ivec2 texel = clamp(ivec2(from) + next, ivec2(0), last);
    vec2 weight = mix(1.0 - part, part, vec2(next));
    sum += (apart(texel) <= alike ? weight.x * weight.y : 0.0) * vec4(texelFetch(layerColours, texel, 0).rgb, 1.0);
  }
  vec3 colour = sum.rgb / max(sum.a, 1e-6);
  bool found = sum.a > 1e-3;
#else
  vec3 colour = texelFetch(layerColours, own, 0).rgb;
  bool found = apart(own) <= alike;
#endif
  // At edges the middle of the pixel may show something else: the texel around it whose depth is the most alike.
  float least = found ? 0.0 : 1.0;
  for (int i = found ? 9 : 0; i < 9; i++) {
    ivec2 texel = clamp(own + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
    float off = apart(texel);
    colour = off < least ? texelFetch(layerColours, texel, 0).rgb : colour;
    least = min(least, off);
  }
  if (least >= 1.0) discard;
  outColour = vec4(colour, 1.0);
}
`;

/** The textures of the layer, of one context. They grow, and are used in part. */
export class Layer {
  #gl;
  #depthOnly;
  #colourOnly;
  #size = { width: 0, height: 0 };
  #used = { width: 1, height: 1 };
  colours = null;
  depths = null;

  constructor(gl) {
    this.#gl = gl;
    this.#depthOnly = gl.createFramebuffer();
    this.#colourOnly = gl.createFramebuffer();
  }

  resize(width, height) {
    this.#used = { width, height };
    const former = this.#size;
    if (width <= former.width && height <= former.height) return;
    const gl = this.#gl;
    this.#delete();
    this.#size = { width: Math.max(width, former.width), height: Math.max(height, former.height) };
    const texture = (format, framebuffer, attachment) => {
      const made = newTexture(gl, gl.TEXTURE_2D, gl.NEAREST);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, this.#size.width, this.#size.height);
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, attachment, gl.TEXTURE_2D, made, 0);
      return made;
    };
    this.depths = texture(gl.DEPTH_COMPONENT24, this.#depthOnly, gl.DEPTH_ATTACHMENT);
    this.colours = texture(gl.RGBA8, this.#colourOnly, gl.COLOR_ATTACHMENT0);
  }

  /** What is drawn next are depths, which are cleared. */
  drawDepths() {
    this.#begin(this.#depthOnly);
    this.#gl.clear(this.#gl.DEPTH_BUFFER_BIT);
  }
  /** What is drawn next are colours. They are valid where there are depths, which can be read. */
  drawColours() {
    this.#begin(this.#colourOnly);
  }

  #begin(framebuffer) {
    const gl = this.#gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, this.#used.width, this.#used.height);
  }

  #delete() {
    for (const texture of [this.colours, this.depths]) this.#gl.deleteTexture(texture);
  }

  close() {
    this.#delete();
    for (const framebuffer of [this.#depthOnly, this.#colourOnly]) this.#gl.deleteFramebuffer(framebuffer);
  }
}
