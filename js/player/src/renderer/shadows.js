// Shadows of the mesh on the environment: a shadow map for each lamp of the stream that casts shadows, drawn once per frame
// of the stream.

import { lampProjection, sphereOf } from "./matrices.js";
import { Layers } from "./resources.js";

/** Maximum number of lamps; those that cast shadows come first. */
export const MAX_LIGHTS = 8;
export const MAX_SHADOWS = 4;
const SIDE = 1024;

const shaders = {
  vertex: /* glsl */ `
layout(location = 0) in vec3 position;
uniform mat4 worldToLamp;
void main() { gl_Position = worldToLamp * vec4(position, 1.0); }
`,
  fragment: "void main() {}",
};

const kinds = ["directional", "point", "spot"];

/**
 * The fraction of the light that reaches a point of the environment. Its pictures include the light, so a shadow removes the
 * part of the hidden lamps, relative to all lamps and ambient light, which files do not describe.
 */
export const lighting = /* glsl */ `
const int MAX_LIGHTS = ${MAX_LIGHTS}, MAX_SHADOWS = ${MAX_SHADOWS};
const float AMBIENT = 0.6; // relative to the light of all lamps
uniform highp sampler2DArrayShadow shadowMaps;
uniform float nearPlane; // lamps are no nearer
uniform int lightCount;
uniform vec4 lightPlaces[MAX_LIGHTS]; // and kind
uniform vec4 lightDirections[MAX_LIGHTS]; // and range
uniform vec4 lightColours[MAX_LIGHTS]; // and layer of its shadow map, or -1
uniform vec4 lightCones[MAX_LIGHTS]; // cosines: inner, outer
uniform mat4 worldToLamps[MAX_SHADOWS];

vec3 irradiance(int i, vec3 point, vec3 normal) {
  vec4 place = lightPlaces[i], direction = lightDirections[i];
  vec3 colour = lightColours[i].rgb;
  if (place.w < 0.5) return colour * max(0.0, -dot(normal, direction.xyz));
  vec3 towards = place.xyz - point;
  float d = length(towards);
  towards /= d;
  float strength = max(0.0, dot(normal, towards)) / max(d * d, nearPlane * nearPlane);
  if (direction.w > 0.0) strength *= clamp(1.0 - pow(d / direction.w, 4.0), 0.0, 1.0);
  if (place.w > 1.5) strength *= smoothstep(lightCones[i].y, lightCones[i].x, -dot(towards, direction.xyz));
  return colour * strength;
}

// The visible fraction of a lamp; edges are soft over a few texels of the map.
float lit(int layer, vec3 point) {
  vec4 at = worldToLamps[layer] * vec4(point, 1.0);
  if (!(at.w > 0.0)) return 1.0;
  vec3 place = 0.5 + 0.5 * at.xyz / at.w;
  if (any(lessThan(place.xy, vec2(0.0))) || any(greaterThan(place.xy, vec2(1.0)))) return 1.0;
  float sum = 0.0;
  for (int y = -2; y <= 2; y++)
    for (int x = -2; x <= 2; x++)
      sum += texture(shadowMaps, vec4(place.xy + 1.5 * vec2(x, y) / ${SIDE}.0, layer, min(place.z, 1.0)));
  return sum / 25.0;
}

vec3 arriving(vec3 point, vec3 normal) {
  vec3 all = vec3(0.0), left = vec3(0.0);
  for (int i = 0; i < lightCount; i++) {
    vec3 light = irradiance(i, point, normal);
    int layer = int(lightColours[i].w);
    all += light;
    left += light * (layer < 0 || light == vec3(0.0) ? 1.0 : lit(layer, point));
  }
  return (AMBIENT * all + left + 1e-6) / (AMBIENT * all + all + 1e-6);
}
`;

export class Shadows {
  #gl;
  #programs;
  #counters;
  #layers;
  #lights = [];
  #drawn = false;
  #uniforms = { lightCount: 0 };

  constructor(gl, programs, counters) {
    this.#gl = gl;
    this.#programs = programs;
    this.#counters = counters;
    this.#layers = new Layers(gl, {
      internal: gl.DEPTH_COMPONENT24,
      attachment: gl.DEPTH_ATTACHMENT,
      comparison: true,
    });
  }

  get texture() {
    return this.#layers.texture;
  }
  get uniforms() {
    return this.#uniforms;
  }

  setLights(lights) {
    const casting = lights.filter((light) => light.castsShadows);
    this.#lights = [...casting, ...lights.filter((light) => !light.castsShadows)].slice(0, MAX_LIGHTS);
    this.forget();
  }

  /** The mesh has changed. */
  forget() {
    this.#drawn = false;
  }

  /** mesh: MeshBuffers, or null; bounds: of the mesh; origin: what these and the environment count from. */
  prepare(mesh, bounds, origin) {
    if (this.#drawn) return;
    this.#drawn = true;
    const matrices = [];
    const place = ({ position, ...light }) => ({ ...light, position: position.map((x, k) => x - origin[k]) });
    const lights = this.#lights.map(place);
    const layerOf = lights.map((light) => {
      if (!mesh || !light.castsShadows || matrices.length === MAX_SHADOWS) return -1;
      const matrix = lampProjection(light, sphereOf(bounds));
      return matrix ? matrices.push(matrix) - 1 : -1;
    });
    this.#setUniforms(lights, layerOf, matrices);
    if (!matrices.length) return;
    const gl = this.#gl;
    this.#layers.resize({ width: SIDE, height: SIDE, layers: MAX_SHADOWS });
    const program = this.#programs.get(shaders);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 2);
    this.#layers.draw(matrices.keys(), (layer) => {
      program.use({ worldToLamp: matrices[layer] });
      mesh.draw();
      this.#counters.shadowPasses++;
    });
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }

  #setUniforms(lights, layerOf, matrices) {
    const table = (row) => new Float32Array(lights.flatMap(row));
    const all = new Float32Array(16 * MAX_SHADOWS);
    matrices.forEach((matrix, i) => all.set(matrix, 16 * i));
    this.#uniforms = {
      lightCount: lights.length,
      lightPlaces: table((light) => [...light.position, kinds.indexOf(light.type)]),
      lightDirections: table((light) => [...light.direction, light.range]),
      lightColours: table((light, i) => [...light.colour.map((value) => value * light.intensity), layerOf[i]]),
      lightCones: table((light) => [Math.cos(light.innerCone), Math.cos(light.outerCone), 0, 0]),
      worldToLamps: all,
    };
    if (!lights.length) this.#uniforms = { lightCount: 0 };
  }

  close() {
    this.#layers.close();
  }
}
