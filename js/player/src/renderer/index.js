// Draws frames of free-viewpoint video from any viewpoint in WebGL 2, as specified in docs/tools/fvvrender.md. Depth and shadow
// maps are drawn once per frame, and a picture is not drawn again if it would be the same.

import {
  checkTexturing,
  closePictures,
  keepPictures,
  layoutOf,
  loadKept,
  loadPictures,
  MAX_BEST,
  MAX_VIEWS,
  nearPlaneOf,
  originOf,
  pointsOf,
  viewsOf,
} from "@fvv/shading";

import { decodeEnvironments } from "./environment.js";
import { boundsOf, moved } from "./matrices.js";
import { Pipeline } from "./pipeline.js";
import { Uploads } from "./resources.js";
import { MAX_LIGHTS, MAX_SHADOWS } from "./shadows.js";
import { tilesOf } from "./sheet.js";
import { MODES } from "./surface.js";

/**
 * The content of a frame that the renderer keeps, also to draw it again after the loss of a context: everything but its
 * pictures, which the caller closes. Pictures are kept as bytes or as clones.
 */
class Content {
  #kept = false;

  /** Loads the pictures of a frame. */
  static async of(frame) {
    const pictures = await loadPictures(frame);
    return new Content(frame, pictures);
  }

  constructor(frame, pictures) {
    const { mesh, configuration } = frame;
    this.frame = frame;
    this.pictures = pictures;
    this.mesh = mesh?.faceCount ? mesh : null;
    this.layout = layoutOf(pictures);
    // The views, bounds and points of what is drawn count from here.
    this.origin = originOf(frame);
    this.views = viewsOf(frame, this.layout.places);
    this.tiles = tilesOf(frame, this.layout.places);
    this.bounds = this.mesh && boundsOf(pointsOf(mesh));
    this.nearPlane = this.bounds && nearPlaneOf(this.bounds);
    const atlas = configuration.videos.find(({ shows, track }) => shows === "atlas" && this.layout.places.has(track));
    const place = atlas && this.layout.places.get(atlas.track);
    // A texture atlas is used if there are no cameras.
    this.atlas = place && mesh?.uvs && !this.views.length ? [place.x, place.y, atlas.width, atlas.height] : null;
  }

  /** Replaces the frame's pictures by copies that this object owns. */
  keep() {
    this.#kept = true;
    this.pictures = keepPictures(this.pictures, this.frame);
  }

  close() {
    if (this.#kept) closePictures(this.pictures);
  }
}

const defaults = {
  mode: "textured",
  visibleBy: "auto",
  cameras: null,
  // Defaults of these four: the stream's values (clause 17.5).
  blend: undefined,
  threshold: undefined,
  best: undefined,
  unseen: undefined,
  shadows: true,
  environment: true,
  fade: true,
  clearColour: [0, 0, 0, 1],
  sky: null,
  up: [0, 1, 0],
  sheet: null,
  frusta: null,
  grid: null,
};

/** Whether the processor draws. */
function isSoftware(gl) {
  const name = gl.getParameter(gl.RENDERER);
  // Chromium has the name in an extension, for which Firefox warns.
  const names = name === "WebKit WebGL" ? gl.getExtension("WEBGL_debug_renderer_info") : null;
  const renderer = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : name;
  return /swiftshader|llvmpipe|softpipe|basic render/i.test(renderer);
}

/** Options with defaults; cameras as a Set. surfaceScale: the default of the context. */
function complete(given = {}, surfaceScale) {
  const options = { ...defaults, surfaceScale };
  for (const [name, value] of Object.entries(given)) if (value !== undefined) options[name] = value;
  if (!(options.mode in MODES)) throw new TypeError(`mode: expected one of ${Object.keys(MODES).join(", ")}`);
  const { surfaceScale: scale } = options;
  if (scale !== null && !(scale > 0 && scale <= 1))
    throw new RangeError(`surfaceScale: expected more than 0, up to 1, found ${scale}`);
  checkTexturing(options);
  options.cameras = options.cameras && new Set(options.cameras);
  return options;
}

/** The same text for the same picture of the same content; the cameras of frusta are compared by identity. */
function keyOf(view, { cameras, frusta, ...others }) {
  const { cameras: drawn, ...outlines } = frusta ?? {};
  return JSON.stringify([view, cameras && [...cameras].sort(), frusta && outlines, others]);
}

export { cameraColour } from "./surface.js";

const noCounters = {
  drawCalls: 0,
  samplers: 0,
  bytesUploadedPerContentFrame: 0,
  bytesUploadedPerDrawnFrame: 0,
  depthPasses: 0,
  shadowPasses: 0,
  contentFrames: 0,
  drawnFrames: 0,
};

/** Texels of all depth maps: three samples along a pixel for 20 cameras of 1024x768. */
const DEPTH_TEXELS = 2 ** 26;

export class Renderer extends EventTarget {
  static limits = Object.freeze({ views: MAX_VIEWS, best: MAX_BEST, lights: MAX_LIGHTS, shadows: MAX_SHADOWS });

  #canvas;
  #surfaceScale; // null: coloured directly
  #limits;
  #gl;
  #counters = { ...noCounters, uploads: new Uploads() };
  #pipeline;
  #content = null;
  #environments = [];
  #turn = 0;
  #environmentTurn = 0;
  #changed = true;
  #last = null; // {view, options, key, outlined} of the last picture
  #loser; // WEBGL_lose_context
  #released = false;
  #restorable = false; // the event of the loss was dispatched
  #listeners = { webglcontextlost: (event) => this.#lose(event), webglcontextrestored: () => this.#restore() };

  constructor(canvas, { contextAttributes = {}, depthTexels = DEPTH_TEXELS } = {}) {
    super();
    this.#canvas = canvas;
    this.#limits = { depthTexels };
    this.#gl = canvas.getContext("webgl2", {
      alpha: false,
      antialias: true,
      powerPreference: "high-performance",
      ...contextAttributes,
    });
    if (!this.#gl) throw new Error("WebGL 2 is not available");
    this.#surfaceScale = isSoftware(this.#gl) ? 1 : null;
    for (const [type, listener] of Object.entries(this.#listeners)) canvas.addEventListener(type, listener);
    this.#loser = this.#gl.getExtension("WEBGL_lose_context");
    this.#pipeline = this.#gl.isContextLost() ? null : new Pipeline(this.#gl, this.#counters, this.#limits);
  }

  get lost() {
    return this.#pipeline === null;
  }
  /** Whether the context was given back, and is not wanted. */
  get released() {
    return this.#released;
  }

  /** Gives the context back to the browser, which has few, until reclaim(). What is shown is kept, the canvas is not. */
  release() {
    if (this.#released || !this.#loser) return;
    this.#released = true;
    if (this.lost) return;
    this.#pipeline = null;
    this.#restorable = false;
    this.#loser.loseContext();
  }
  /** Takes a context again. The event "restored" follows. */
  reclaim() {
    if (!this.#released) return;
    this.#released = false;
    if (this.#restorable) this.#loser.restoreContext();
  }

  /** A copy of the counters; uploads and draw calls are those of the last frame. */
  get counters() {
    const { uploads, ...counters } = this.#counters;
    return counters;
  }

  /** The frame that is shown, {number, seconds, viewCount}; null: none yet. */
  get frame() {
    const { frame, views } = this.#content ?? {};
    return frame ? { number: frame.number, seconds: frame.seconds, viewCount: views.length } : null;
  }

  /** The pictures of cameras that a contact sheet shows. */
  get tiles() {
    return this.#content?.tiles ?? [];
  }

  /** Bounds of the mesh that is shown, {min, max}; null: no mesh. */
  get bounds() {
    const { bounds, origin } = this.#content ?? {};
    return bounds ? moved(bounds, origin) : null;
  }

  async show(frame) {
    if (frame.mesh && !frame.mesh.normals)
      throw new TypeError("the mesh has no normals: create the decoder with normals: true");
    const turn = ++this.#turn;
    const content = await Content.of(frame);
    if (turn !== this.#turn) return false;
    this.#content?.close();
    this.#content = content;
    this.#upload(content.pictures);
    content.keep();
    this.#counters.contentFrames++;
    return true;
  }

  /** Draws no frame until the next call of show. */
  clear() {
    this.#turn++;
    this.#content?.close();
    this.#content = null;
    this.#pipeline?.clear();
    this.#changed = true;
  }

  #upload(pictures) {
    const { uploads } = this.#counters;
    const former = uploads.bytes;
    this.#pipeline?.show(this.#content, pictures);
    this.#counters.bytesUploadedPerContentFrame = uploads.bytes - former;
    this.#changed = true;
  }

  /** environments: of the decoder. Of several concurrent calls the last one wins. */
  async setEnvironments(found) {
    const turn = ++this.#environmentTurn;
    const environments = await decodeEnvironments(found);
    const late = turn !== this.#environmentTurn;
    closeImages(late ? environments : this.#environments);
    if (late) return false;
    this.#environments = environments;
    this.#pipeline?.setEnvironments(environments);
    this.#changed = true;
    return true;
  }

  #complete(options) {
    return complete(options, this.#surfaceScale);
  }

  /** Whether draw() would draw. */
  needsDraw(view, options) {
    return this.#drawingFor(view, this.#complete(options)) !== null;
  }

  #drawingFor(view, options) {
    if (this.lost) return null;
    const key = keyOf(view, options);
    const outlined = options.frusta?.cameras ?? null;
    const same = !this.#changed && this.#last?.key === key && this.#last.outlined === outlined;
    return same ? null : { view, options, key, outlined };
  }

  /** Returns whether anything was drawn. */
  draw(view, options) {
    const drawing = this.#drawingFor(view, this.#complete(options));
    if (!drawing) return false;
    this.#last = drawing;
    this.#draw();
    return true;
  }

  #draw() {
    const { view, options } = this.#last;
    if (this.#canvas.width !== view.width) this.#canvas.width = view.width;
    if (this.#canvas.height !== view.height) this.#canvas.height = view.height;
    this.#drawAll([view], options, null);
    this.#changed = false;
  }

  #drawAll(views, options, framebuffer) {
    const counters = this.#counters;
    const former = counters.uploads.bytes;
    counters.drawCalls = 0;
    for (const view of views) this.#pipeline.draw(view, options, framebuffer);
    counters.bytesUploadedPerDrawnFrame = counters.uploads.bytes - former;
    counters.drawnFrames++;
  }

  /**
   * Draws the views of one picture, such as those of two eyes, each into its viewport {x, y, width, height} of a framebuffer;
   * null: that of the canvas. Returns false if the context is lost.
   */
  drawViews(views, options, framebuffer = null) {
    if (this.lost) return false;
    this.#drawAll(views, this.#complete(options), framebuffer);
    this.#changed = true; // The canvas no longer has the last picture of draw().
    return true;
  }

  /** The layer of a WebXR session that this renderer draws into. */
  async layerFor(session) {
    await this.#gl.makeXRCompatible?.();
    return new XRWebGLLayer(session, this.#gl);
  }

  /** The last picture, RGBA, top row first. It is drawn again, because browsers need not keep it. */
  readPixels() {
    if (!this.#last || this.lost) throw new Error("nothing has been drawn");
    this.#draw();
    const gl = this.#gl;
    const { width, height } = this.#canvas;
    const rows = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rows);
    const data = new Uint8ClampedArray(rows.length);
    for (let y = 0; y < height; y++)
      data.set(rows.subarray(4 * width * y, 4 * width * (y + 1)), 4 * width * (height - 1 - y));
    return { width, height, data };
  }

  #lose(event) {
    // Otherwise the context is never restored.
    event.preventDefault();
    const isOwn = this.#pipeline === null;
    this.#pipeline = null;
    // A context can be restored after this event.
    setTimeout(() => {
      this.#restorable = true;
      if (isOwn && !this.#released) this.#loser.restoreContext();
    });
    if (!isOwn) this.dispatchEvent(new Event("lost"));
  }

  async #restore() {
    this.#restorable = false;
    if (this.#released) return this.#loser.loseContext();
    const pipeline = new Pipeline(this.#gl, this.#counters, this.#limits);
    pipeline.setEnvironments(this.#environments);
    this.#pipeline = pipeline;
    this.#changed = true;
    const content = this.#content;
    const pictures = content ? await loadKept(content.pictures) : [];
    // Meanwhile there may have been another frame or another loss.
    if (content && content === this.#content && pipeline === this.#pipeline) this.#upload(pictures);
    this.dispatchEvent(new Event("restored"));
  }

  close() {
    this.#turn++;
    this.#environmentTurn++;
    for (const [type, listener] of Object.entries(this.#listeners)) this.#canvas.removeEventListener(type, listener);
    this.#pipeline?.close();
    this.#pipeline = null;
    this.#content?.close();
    this.#content = null;
    closeImages(this.#environments);
    this.#environments = [];
  }
}

function closeImages(environments) {
  for (const { images } of environments) for (const image of images) image.close();
}
