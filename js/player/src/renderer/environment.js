// The static environment: meshes in one colour or with one picture, and the shadows on them.

import { pointsOf } from "@fvv/shading";

import { boundsOf, joined } from "./matrices.js";
import { hides, isBelow, obstruction, sightOf } from "./obstacles.js";
import { MeshBuffers, newTexture } from "./resources.js";
import { lighting } from "./shadows.js";

const shaders = {
  vertex: /* glsl */ `
layout(location = 0) in vec3 position;
layout(location = 2) in vec2 uv;
uniform mat4 worldToClip;
out vec3 vPoint;
out vec2 vUv;
void main() {
  vPoint = position;
  vUv = uv;
  gl_Position = worldToClip * vec4(position, 1.0);
}
`,
  fragment: /* glsl */ `
uniform sampler2D picture;
uniform vec3 colour; // linear light
in vec3 vPoint;
in vec2 vUv;
layout(location = 0) out highp vec4 outColour;
${lighting}
#ifdef OBSTACLES
${obstruction}
#endif

vec3 toLinear(vec3 v) { return mix(pow((v + 0.055) / 1.055, vec3(2.4)), v / 12.92, lessThanEqual(v, vec3(0.04045))); }
vec3 toDisplay(vec3 v) {
  return mix(1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, 12.92 * v, lessThanEqual(v, vec3(0.0031308)));
}

void main() {
  vec3 faceNormal = normalize(cross(dFdx(vPoint), dFdy(vPoint)));
  float alpha = 1.0;
#ifdef OBSTACLES
  alpha = opacity(vPoint, faceNormal, SINGLE_SIDED == 1 && !gl_FrontFacing);
#ifdef FADED
  if (alpha > 0.996 || alpha == 0.0) discard;
#else
  if (alpha <= 0.996) discard;
#endif
#endif
  vec3 light = colour * toLinear(texture(picture, vUv).rgb) * arriving(vPoint, faceNormal);
  outColour = vec4(toDisplay(light), alpha);
}
`,
};

/** Decodes the pictures of all environments. Returns [{parts, lights, images}]. */
export function decodeEnvironments(environments) {
  return Promise.all(
    environments.map(async ({ parts, lights, pictures }) => {
      const images = pictures.map(({ data, type }) =>
        createImageBitmap(new Blob([data], { type }), { colorSpaceConversion: "none", premultiplyAlpha: "none" }),
      );
      return { parts, lights, images: await Promise.all(images) };
    }),
  );
}

export class Environment {
  #gl;
  #programs;
  #counters;
  #parts = []; // {part, bounds, mesh, texture}
  #textures = [];
  #white;
  bounds = null;
  /** What its points and bounds count from, as those of the stream's meshes do; null: it is empty. */
  origin = null;

  constructor(gl, programs, counters) {
    this.#gl = gl;
    this.#programs = programs;
    this.#counters = counters;
    this.#white = newTexture(gl, gl.TEXTURE_2D, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([255, 255, 255, 255]));
  }

  get empty() {
    return this.#parts.length === 0;
  }

  /** environments: the result of decodeEnvironments. */
  show(environments) {
    this.#clear();
    for (const { parts, images } of environments)
      for (const part of parts) {
        if (!part.faceCount) continue;
        const mesh = new MeshBuffers(this.#gl, this.#counters.uploads);
        mesh.show(part);
        const texture = part.picture === null ? this.#white : this.#upload(images[part.picture], part.clamped);
        const bounds = boundsOf(pointsOf(part));
        this.#parts.push({ part, bounds, mesh, texture });
        this.bounds = joined(this.bounds, bounds);
        this.origin = part.origin ?? [0, 0, 0];
      }
  }

  #upload(image, clamped) {
    const gl = this.#gl;
    const wrap = clamped ? gl.CLAMP_TO_EDGE : gl.REPEAT;
    const texture = newTexture(gl, gl.TEXTURE_2D, gl.LINEAR_MIPMAP_LINEAR, wrap);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    const anisotropy = gl.getExtension("EXT_texture_filter_anisotropic");
    if (anisotropy) gl.texParameterf(gl.TEXTURE_2D, anisotropy.TEXTURE_MAX_ANISOTROPY_EXT, 8);
    this.#counters.uploads.add(4 * image.width * image.height);
    this.#textures.push(texture);
    return texture;
  }

  /** The parts that fade, for a viewer; action: the bounds of what must not be hidden, or null. Returns what draw takes. */
  fading(eye, up, action) {
    if (!action) return null;
    const below = isBelow(eye, up, action);
    const sight = sightOf(eye, action);
    const parts = this.#parts.filter(({ part, bounds }) => (below && !part.doubleSided) || hides(part, bounds, sight));
    if (!parts.length) return null;
    return { parts: new Set(parts), uniforms: { eye, up, actionMin: action.min, actionMax: action.max } };
  }

  /** fading: the result of the method, or null. */
  draw(viewer, shadows, fading) {
    const gl = this.#gl;
    gl.enable(gl.DEPTH_TEST);
    // At equal depth the mesh of the frame wins.
    gl.depthFunc(gl.LESS);
    for (const one of this.#parts) {
      if (!one.part.doubleSided) gl.enable(gl.CULL_FACE);
      const fades = fading?.parts.has(one);
      this.#drawPart(one, viewer, shadows, fades ? fading : null, {});
      gl.disable(gl.CULL_FACE);
    }
  }

  /** What fades, over all that has been drawn. */
  drawFaded(viewer, shadows, fading) {
    const gl = this.#gl;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.depthFunc(gl.LESS);
    for (const one of fading.parts) this.#drawPart(one, viewer, shadows, fading, { FADED: 1 });
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  #drawPart({ part, mesh, texture }, { worldToClip, nearPlane }, shadows, fading, more) {
    const defines = fading ? { OBSTACLES: 1, SINGLE_SIDED: part.doubleSided ? 0 : 1, ...more } : {};
    const uniforms = { worldToClip, nearPlane, colour: part.colour, lightCount: 0, ...shadows.uniforms };
    this.#programs
      .get(shaders, defines)
      .use({ ...uniforms, ...fading?.uniforms }, { picture: texture, shadowMaps: shadows.texture });
    mesh.draw();
    this.#counters.drawCalls++;
  }

  #clear() {
    for (const { mesh } of this.#parts) mesh.close();
    for (const texture of this.#textures) this.#gl.deleteTexture(texture);
    this.#parts = [];
    this.#textures = [];
    this.bounds = this.origin = null;
  }

  close() {
    this.#clear();
    this.#gl.deleteTexture(this.#white);
  }
}
