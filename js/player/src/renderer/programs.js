// Shader programs of one context, compiled at first use. Uniforms and samplers are set by name.

const HEADER = "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2DArray;\n";

function compile(gl, type, source) {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

/** Functions (location, value) that set uniforms, by type. */
function settersOf(gl) {
  return new Map([
    [gl.INT, (at, value) => gl.uniform1i(at, value)],
    [gl.FLOAT, (at, value) => gl.uniform1f(at, value)],
    [gl.FLOAT_VEC2, (at, value) => gl.uniform2fv(at, value)],
    [gl.FLOAT_VEC3, (at, value) => gl.uniform3fv(at, value)],
    [gl.FLOAT_VEC4, (at, value) => gl.uniform4fv(at, value)],
    [gl.FLOAT_MAT3, (at, value) => gl.uniformMatrix3fv(at, false, value)],
    [gl.FLOAT_MAT4, (at, value) => gl.uniformMatrix4fv(at, false, value)],
  ]);
}

class Program {
  #gl;
  #program;
  #setters;
  #uniforms = new Map(); // name -> {at, type}
  #units = new Map(); // name of a sampler -> {unit, target}

  constructor(gl, setters, vertex, fragment) {
    this.#gl = gl;
    this.#setters = setters;
    this.#program = gl.createProgram();
    const shaders = [compile(gl, gl.VERTEX_SHADER, vertex), compile(gl, gl.FRAGMENT_SHADER, fragment)];
    for (const shader of shaders) gl.attachShader(this.#program, shader);
    gl.linkProgram(this.#program);
    if (!gl.getProgramParameter(this.#program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = shaders.map((shader) => gl.getShaderInfoLog(shader));
      throw new Error(`a shader does not compile: ${[...logs, gl.getProgramInfoLog(this.#program)].join("\n").trim()}`);
    }
    for (const shader of shaders) gl.deleteShader(shader);
    this.#list();
  }

  #list() {
    const gl = this.#gl;
    const targets = new Map([
      [gl.SAMPLER_2D, gl.TEXTURE_2D],
      [gl.SAMPLER_2D_ARRAY, gl.TEXTURE_2D_ARRAY],
      [gl.SAMPLER_2D_ARRAY_SHADOW, gl.TEXTURE_2D_ARRAY],
    ]);
    gl.useProgram(this.#program);
    const count = gl.getProgramParameter(this.#program, gl.ACTIVE_UNIFORMS) ?? 0;
    for (let i = 0; i < count; i++) {
      const { name, type } = gl.getActiveUniform(this.#program, i);
      const at = gl.getUniformLocation(this.#program, name);
      const target = targets.get(type);
      if (!target) {
        this.#uniforms.set(name.replace("[0]", ""), { at, type });
        continue;
      }
      gl.uniform1i(at, this.#units.size);
      this.#units.set(name, { unit: this.#units.size, target });
    }
  }

  get samplers() {
    return this.#units.size;
  }

  /** uniforms: by name; textures: of samplers, by name. Names that the program does not have are ignored. */
  use(uniforms, textures = {}) {
    const gl = this.#gl;
    gl.useProgram(this.#program);
    for (const [name, value] of Object.entries(uniforms)) {
      const uniform = this.#uniforms.get(name);
      if (uniform) this.#setters.get(uniform.type)(uniform.at, value);
    }
    for (const [name, { unit, target }] of this.#units) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(target, textures[name]);
    }
    return this;
  }

  delete() {
    this.#gl.deleteProgram(this.#program);
  }
}

export class Programs {
  #gl;
  #setters;
  #made = new Map();

  constructor(gl) {
    this.#gl = gl;
    this.#setters = settersOf(gl);
  }

  /** Attributes: 0 position, 1 normal or colour, 2 texture coordinates. */
  get({ vertex, fragment }, defines = {}) {
    const head =
      HEADER +
      Object.entries(defines)
        .map(([name, value]) => `#define ${name} ${value}\n`)
        .join("");
    const key = head + vertex + fragment;
    let program = this.#made.get(key);
    if (!program) {
      program = new Program(this.#gl, this.#setters, head + vertex, head + fragment);
      this.#made.set(key, program);
    }
    return program;
  }

  close() {
    for (const program of this.#made.values()) program.delete();
    this.#made.clear();
  }
}
