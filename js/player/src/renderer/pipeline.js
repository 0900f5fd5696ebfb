// Everything that belongs to one WebGL context. After the loss of the context another pipeline is created.

import { Environment } from "./environment.js";
import { clippingOf, joined, projectionOf, raysOf } from "./matrices.js";
import { Overlay } from "./overlay.js";
import { PictureTexture } from "./pictures.js";
import { Programs } from "./programs.js";
import { Shadows } from "./shadows.js";
import { Surface } from "./surface.js";
import { eyeOf } from "../view.js";

export class Pipeline {
  #gl;
  #programs;
  #counters;
  #pictures;
  #surface;
  #shadows;
  #environment;
  #overlay;
  #content = null;

  constructor(gl, counters, { depthTexels }) {
    this.#gl = gl;
    this.#counters = counters;
    this.#programs = new Programs(gl);
    this.#pictures = new PictureTexture(gl, this.#programs, counters.uploads);
    this.#surface = new Surface(gl, this.#programs, counters, depthTexels);
    this.#shadows = new Shadows(gl, this.#programs, counters);
    this.#environment = new Environment(gl, this.#programs, counters);
    this.#overlay = new Overlay(gl, this.#programs, counters);
  }

  /** pictures: the loaded pictures of the content. */
  show(content, pictures) {
    this.#content = content;
    this.#pictures.show(pictures, content.layout);
    if (content.mesh) this.#surface.show(content);
    this.#shadows.forget();
    this.#overlay.forget();
  }

  clear() {
    this.#content = null;
    this.#shadows.forget();
    this.#overlay.forget();
  }

  setEnvironments(environments) {
    this.#environment.show(environments);
    this.#shadows.setLights(environments.flatMap(({ lights }) => lights));
  }

  draw(view, options) {
    const gl = this.#gl;
    const content = this.#content;
    const surface = content?.mesh ? this.#surface : null;
    const around = options.environment && !this.#environment.empty ? this.#environment : null;
    surface?.prepare(options);
    if (around) this.#shadows.prepare(surface?.mesh ?? null, content?.bounds);
    this.#overlay.prepare(options, content?.views ?? []);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, view.width, view.height);
    gl.clearColor(...options.clearColour);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const viewer = this.#viewer(view, joined(content?.bounds ?? null, around?.bounds ?? null), options);
    if (surface) surface.draw(this.#pictures, viewer, options);
    if (around) around.draw(viewer, options.shadows ? this.#shadows : { ...noShadows, texture: this.#shadows.texture });
    this.#overlay.draw(viewer, this.#pictures);
  }

  #viewer(view, bounds, { frusta, grid }) {
    const clipping = clippingOf(joined(bounds, overlayBounds(frusta, grid)), view);
    const own = clippingOf(this.#content?.bounds ?? null, view);
    return {
      worldToClip: projectionOf(view, clipping),
      pixelToRay: raysOf(view),
      depthRange: [own.near, own.far],
      eye: eyeOf(view),
    };
  }

  close() {
    this.#overlay.close();
    this.#environment.close();
    this.#shadows.close();
    this.#surface.close();
    this.#pictures.close();
    this.#programs.close();
  }
}

const noShadows = { uniforms: { lightCount: 0 } };

function overlayBounds(frusta, grid) {
  let bounds = null;
  const add = (centre, radius) => {
    const box = { min: centre.map((x) => x - radius), max: centre.map((x) => x + radius) };
    bounds = joined(bounds, box);
  };
  for (const camera of frusta?.cameras ?? []) if (camera.calibrated) add(camera.centre, 3 * (frusta.length ?? 0.35));
  if (grid) add(grid.centre, 1.5 * (grid.extent ?? 3));
  return bounds;
}
