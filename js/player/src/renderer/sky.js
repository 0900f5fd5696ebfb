// What is around the scene: the colour of the empty scene at the horizon and below, which changes smoothly to that of the
// zenith.

/** Cells of a grid over the viewport, per side. Colours are computed at their corners, which is exact to a fraction of a step. */
const CELLS = 16;

const shaders = {
  vertex: /* glsl */ `
uniform mat3 pixelToRay; // of gl_FragCoord
uniform vec4 viewport;
uniform vec3 up, horizon, zenith; // colours: display values
out vec3 vColour;
const float LOWEST = -0.05;
// The sine of the elevation.
float rise(vec2 place) {
  return dot(normalize(pixelToRay * vec3(viewport.xy + place / ${CELLS}.0 * viewport.zw, 1.0)), up);
}
void main() {
  int cell = gl_VertexID / 6, corner = gl_VertexID % 6;
  vec2 first = vec2(cell % ${CELLS}, cell / ${CELLS});
  vec2 place = first + vec2(corner % 2, corner > 1 && corner < 5);
  float highest = max(max(rise(first), rise(first + 1.0)), max(rise(first + vec2(1, 0)), rise(first + vec2(0, 1))));
  vColour = mix(horizon, zenith, smoothstep(LOWEST, 1.0 + LOWEST, rise(place)));
  gl_Position = vec4(2.0 * place / ${CELLS}.0 - 1.0, 1.0, 1.0);
  // Cells below the horizon have their colour already.
  if (highest < LOWEST) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
`,
  fragment: /* glsl */ `
in vec3 vColour;
layout(location = 0) out highp vec4 outColour;
void main() {
  // Without noise of half a step, eight bits show bands.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  outColour = vec4(vColour + noise / 255.0, 1.0);
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

  /** Draws where nothing else has been drawn: farther away than everything. The viewport has the colour clearColour. */
  draw({ x = 0, y = 0, width, height }, pixelToRay, { clearColour, sky, up }) {
    const gl = this.#gl;
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    const [horizon, zenith] = [clearColour, sky].map((colour) => colour.slice(0, 3));
    this.#programs.get(shaders).use({ pixelToRay, viewport: [x, y, width, height], up, horizon, zenith });
    gl.bindVertexArray(this.#empty);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * CELLS * CELLS);
    gl.bindVertexArray(null);
    this.#counters.drawCalls++;
  }

  close() {
    this.#gl.deleteVertexArray(this.#empty);
  }
}
