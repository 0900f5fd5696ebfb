// Everything that belongs to one WebGL context. After the loss of the context another pipeline is created.

import { viewFrom } from "@fvv/shading";

import { Environment } from "./environment.js";
import { clippingOf, joined, moved, projectionOf, raysOf } from "./matrices.js";
import { Overlay, sizedOverlays } from "./overlay.js";
import { PictureTexture } from "./pictures.js";
import { Programs } from "./programs.js";
import { Shadows } from "./shadows.js";
import { Sheet } from "./sheet.js";
import { Sky } from "./sky.js";
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
  #sky;
  #sheet;
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
    this.#sky = new Sky(gl, this.#programs, counters);
    this.#sheet = new Sheet(gl, this.#programs, counters);
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

  /** framebuffer: null for the canvas. Only the viewport of the view is changed. */
  draw(given, options, framebuffer = null) {
    const content = this.#content;
    // Whatever reaches the GPU counts from the origin of the stream: its floats do not hold coordinates of maps.
    const origin = content?.origin ?? this.#environment.origin ?? [0, 0, 0];
    const view = viewFrom(origin, given);
    const surface = content?.mesh ? this.#surface : null;
    const around = options.environment && !this.#environment.empty ? this.#environment : null;
    if (options.sheet) return this.#drawSheet(view, options, framebuffer);
    surface?.prepare(options);
    if (around) this.#shadows.prepare(surface?.mesh ?? null, content?.bounds, origin);
    const drawn = joined(content?.bounds ?? null, around?.bounds ?? null);
    const overlays = sizedOverlays(options, content?.bounds ?? drawn);
    this.#overlay.prepare(overlays, content?.views ?? [], origin);
    this.#clear(view, options, framebuffer);
    const viewer = this.#viewer(view, joined(drawn, overlayBounds(overlays, origin)));
    if (surface) surface.draw(this.#pictures, viewer, options, { framebuffer, view });
    const shadows = options.shadows ? this.#shadows : { ...noShadows, texture: this.#shadows.texture };
    const fading = around && options.fade ? around.fading(viewer.eye, options.up, content?.bounds ?? null) : null;
    if (around) around.draw(viewer, shadows, fading);
    if (options.sky) this.#sky.draw(view, viewer.pixelToRay, options);
    if (fading) around.drawFaded(viewer, shadows, fading);
    this.#overlay.draw(viewer, this.#pictures);
  }

  /** All pictures beside each other, instead of the scene. */
  #drawSheet(view, options, framebuffer) {
    this.#clear(view, options, framebuffer);
    this.#sheet.draw(this.#content?.tiles ?? [], options.sheet, this.#pictures);
  }

  #clear({ x = 0, y = 0, width, height }, { clearColour }, framebuffer) {
    const gl = this.#gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(x, y, width, height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(x, y, width, height);
    gl.clearColor(...clearColour);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.disable(gl.SCISSOR_TEST);
  }

  #viewer(view, bounds) {
    // What is around a small object does not hide it from a viewer who is close to it.
    const nearPlane = this.#content?.nearPlane ?? undefined;
    const clipping = clippingOf(bounds, view, nearPlane);
    const own = clippingOf(this.#content?.bounds ?? null, view);
    return {
      nearPlane: nearPlane ?? clipping.near,
      worldToClip: projectionOf(view, clipping),
      pixelToRay: raysOf(view),
      depthRange: [own.near, own.far],
      eye: eyeOf(view),
    };
  }

  close() {
    this.#overlay.close();
    this.#sheet.close();
    this.#sky.close();
    this.#environment.close();
    this.#shadows.close();
    this.#surface.close();
    this.#pictures.close();
    this.#programs.close();
  }
}

const negated = (offset) => offset.map((x) => -x);

const noShadows = { uniforms: { lightCount: 0 } };

/** Relative to origin. */
function overlayBounds({ frusta, grid }, origin) {
  let bounds = null;
  const add = (centre, radius) => {
    const box = { min: centre.map((x) => x - radius), max: centre.map((x) => x + radius) };
    bounds = joined(bounds, box);
  };
  for (const camera of frusta?.cameras ?? []) if (camera.calibrated) add(camera.centre, 3 * frusta.length);
  if (grid) add(grid.centre, 1.5 * grid.extent);
  return bounds && moved(bounds, negated(origin));
}
