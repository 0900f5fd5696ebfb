// What is around the scene: the colour of the empty scene at the horizon and below, which changes smoothly to that of the
// zenith.

import { wholeVertex } from "./programs.js";

const shaders = {
  vertex: wholeVertex,
  fragment: /* glsl */ `
uniform mat3 pixelToRay; // of gl_FragCoord
uniform vec3 up, horizon, zenith; // colours: display values
layout(location = 0) out highp vec4 outColour;
void main() {
  float rise = dot(normalize(pixelToRay * vec3(gl_FragCoord.xy, 1.0)), up);
  vec3 colour = mix(horizon, zenith, smoothstep(-0.05, 0.95, rise));
  // Without noise of half a step, eight bits show bands.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  outColour = vec4(colour + noise / 255.0, 1.0);
}
`,
};

export class Sky {
  #gl;
  #programs;
  #counters;
  #empty;

  constructor(gl, programs, counters) {
    this.#gl = gl;
    this.#programs = programs;
    this.#counters = counters;
    this.#empty = gl.createVertexArray();
  }

  /** Draws over the whole viewport, at no depth. */
  draw({ pixelToRay }, { clearColour, sky, up }) {
    const gl = this.#gl;
    gl.disable(gl.DEPTH_TEST);
    const [horizon, zenith] = [clearColour, sky].map((colour) => colour.slice(0, 3));
    this.#programs.get(shaders).use({ pixelToRay, up, horizon, zenith });
    gl.bindVertexArray(this.#empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
    gl.enable(gl.DEPTH_TEST);
    this.#counters.drawCalls++;
  }

  close() {
    this.#gl.deleteVertexArray(this.#empty);
  }
}
