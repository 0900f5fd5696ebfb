// The canvas, its renderer, and when they draw. Nothing is drawn, and no animation frame is requested, while nothing
// changes.

import { dot, mix, originOf, pointsOf } from "@fvv/shading";

import { contexts } from "./contexts.js";
import { Renderer } from "./renderer/index.js";
import { sheetCells } from "./renderer/sheet.js";
import { Resolution } from "./resolution.js";
import { ScreenDelay } from "./screen_delay.js";

/** Milliseconds without movement after which the picture is drawn at full resolution. */
const REST = 180;
/** Milliseconds without drawing after which another player may take the context, and after which a player asks again. */
const IDLE = 1000;
const ASK_AGAIN = 500;
/** Milliseconds after which a lost context is given up. */
const LOST = 5000;
/** The colour of the sky: the background with a part of this blue. */
const BLUE = [0.46, 0.66, 0.9];
const BLUENESS = 0.16;
/** Length of frusta, relative to the scene's size. */
const FRUSTUM = 0.28;

/** The largest of 1, 2, 5, 10, 20, ... that is not greater than x. */
function roundDown(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [5, 2, 1].find((digit) => digit * power <= x * (1 + 1e-9));
}

/** "rgb(20, 24, 28)" as display values; null: transparent. */
function readColour(text) {
  const [r, g, b, alpha = 1] = (text.match(/[\d.]+/g) ?? []).map(Number);
  if (b === undefined || alpha === 0) return null;
  return [r / 255, g / 255, b / 255, 1];
}

export class Stage extends EventTarget {
  #canvas;
  #media;
  #navigator;
  #renderer;
  #asked = 0;
  #asker = null; // the window of the animation frame
  #settle = null;
  #visible = true;
  #drawnAt = -Infinity;
  #takenAt = -Infinity; // a context
  #owes = false; // a picture for that context, which may be taken before there is one
  #still = null; // a canvas with the last picture, while there is no context
  #waiting = null; // timer of the next attempt to get a context
  #losing = null; // timer after a loss
  #gone = false;
  #frame = null; // what is used of the frame on screen
  #ground = null;
  #empty = true;
  #immersed = false;
  #bare = true; // no mesh so far: the extent is a guess
  #outlined = { cameras: null, without: null, found: null };
  resolution = new Resolution();
  #delay = new ScreenDelay();
  environments = [];
  options = {
    mode: "textured",
    visibleBy: "auto",
    cameras: null,
    shadows: true,
    environment: true,
    grid: true,
    frusta: false,
    picturePlanes: false,
    selected: null,
    sheet: false,
    sheetBottom: 0,
  };
  #colours = { clear: [0, 0, 0, 1], sky: [0, 0, 0, 1], grid: [0.3, 0.3, 0.3, 1] };

  constructor(canvas, media, navigator) {
    super();
    this.#canvas = canvas;
    this.#media = media;
    this.#navigator = navigator;
    this.#renderer = new Renderer(canvas);
    this.#renderer.addEventListener("lost", () => this.#lose());
    this.#renderer.addEventListener("restored", () => this.#restored());
    if (!contexts.use(this)) this.giveBack();
  }

  /** The browser has taken the context, and may restore it. */
  #lose() {
    contexts.lost(this);
    clearTimeout(this.#losing);
    this.#losing = setTimeout(() => this.#giveUp(true), LOST);
  }
  #restored() {
    clearTimeout(this.#losing);
    this.#giveUp(false);
    this.wake();
  }
  #giveUp(gone) {
    if (this.#gone === gone) return;
    this.#gone = gone;
    if (gone) this.#canvas.classList.add("empty");
    this.dispatchEvent(new Event("gone"));
  }
  /** Whether the context was lost, and the browser does not restore it. */
  get gone() {
    return this.#gone;
  }

  /** Whether the user may see the canvas. Nothing is drawn while not. */
  get visible() {
    return this.#visible || this.#immersed;
  }
  set visible(visible) {
    this.#visible = visible;
    if (visible) this.wake();
  }
  /** Whether the context is spare if others need one. */
  get idle() {
    return !this.#immersed && performance.now() - Math.max(this.#drawnAt, this.#takenAt) > IDLE;
  }
  /** Gives the context back until there is something to draw. A copy of the picture stays. */
  giveBack() {
    if (this.#renderer.released) return;
    if (this.#drawnAt > 0 && !this.#renderer.lost) this.#keepStill();
    this.#renderer.release();
    if (this.#owes) this.#askAgain();
  }
  #keepStill() {
    const { width, height, data } = this.#renderer.readPixels();
    this.#still ??= this.#canvas.cloneNode();
    Object.assign(this.#still, { width, height });
    this.#still.getContext("2d").putImageData(new ImageData(data, width, height), 0, 0);
    this.#canvas.after(this.#still);
  }
  #dropStill() {
    this.#still?.remove();
    this.#still = null;
  }
  #askAgain() {
    clearTimeout(this.#waiting);
    this.#waiting = setTimeout(() => {
      this.#waiting = null;
      this.wake();
    }, ASK_AGAIN);
  }
  /** Returns whether there is a context to draw with. */
  #takeContext() {
    clearTimeout(this.#waiting);
    this.#waiting = null;
    if (!contexts.use(this)) {
      this.#askAgain();
      return false;
    }
    this.#owes = true;
    this.#takenAt = performance.now();
    this.#renderer.reclaim();
    return !this.#renderer.lost;
  }

  /** The canvas is in another document, whose window draws. */
  moved() {
    if (this.#asked === -1) return;
    this.#asker?.cancelAnimationFrame(this.#asked);
    this.#asked = 0;
    this.wake();
  }
  get #view() {
    return this.#canvas.ownerDocument.defaultView ?? globalThis;
  }

  get renderer() {
    return this.#renderer;
  }
  /** Cameras as they are in the frame on screen. */
  get cameras() {
    return this.#frame?.cameras ?? [];
  }
  get empty() {
    return this.#empty;
  }
  /** The frame on screen, whose pictures may be closed, and the view of it in CSS pixels of the canvas; null: none. */
  get shown() {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    if (this.#empty || !width || !height) return null;
    return { frame: this.#frame.whole, view: this.#navigator.view(width, height) };
  }
  /** Whether the stream on screen has pictures of cameras and no meshes. */
  get onlyPictures() {
    return this.#frame !== null && !this.#frame.hasMeshes && this.#renderer.tiles.length > 0;
  }
  /** Cells of the contact sheet: {camera, x, y, width, height}, in fractions of the canvas. */
  get sheetCells() {
    if (this.#empty) return [];
    const { clientWidth, clientHeight } = this.#canvas;
    const bottom = Math.min(0.4, this.options.sheetBottom / Math.max(1, clientHeight));
    return sheetCells(this.#renderer.tiles, Math.max(1, clientWidth), Math.max(1, clientHeight), bottom);
  }

  /** Whether a picture is about to be drawn. */
  get busy() {
    return this.#asked !== 0 || this.#settle !== null || this.#waiting !== null;
  }

  /** As Media takes it. */
  get screen() {
    return this.#delay.value;
  }

  async show(frame) {
    const taken = performance.now();
    const shown = await this.#renderer.show(frame);
    if (!shown) return false;
    const { tracks, scaleKnown } = frame.configuration;
    const hasMeshes = tracks.some(({ kind }) => kind === "mesh");
    this.#frame = { whole: frame, cameras: frame.cameras, hasMeshes, scaleKnown, floor: this.#frame?.floor ?? null };
    if (this.#empty || (this.#bare && frame.mesh)) this.#begin(frame);
    else this.#navigator.follow(frame.cameras);
    this.#delay.uploaded(taken);
    this.wake();
    return true;
  }

  /** The stage is empty until the next frame. */
  vacate() {
    this.#renderer.clear();
    this.wake();
  }

  #begin(frame) {
    this.#empty = false;
    this.#bare = !frame.mesh;
    // Of an element that is not displayed both are 0.
    this.#navigator.aspect = Math.max(1, this.#canvas.clientWidth) / Math.max(1, this.#canvas.clientHeight);
    this.#navigator.begin(frame);
    const { up } = this.#navigator.axes;
    const { centre, radius } = this.#navigator.extent;
    const points = frame.mesh ? pointsOf(frame.mesh) : [];
    let low = Infinity;
    for (let i = 0; i < points.length; i += 3) low = Math.min(low, dot(points.subarray(i, i + 3), up));
    low += dot(originOf(frame), up);
    const down = Number.isFinite(low) ? dot(centre, up) - low : 0;
    this.#frame.floor = Number.isFinite(low) ? low : null;
    const step = roundDown(radius / 3);
    const extent = step * Math.ceil((3 * radius) / step);
    this.#ground = { centre: centre.map((x, i) => x - down * up[i]), up, extent, step };
    this.dispatchEvent(new Event("begin"));
  }
  /** Another source: the next frame defines the first view. */
  forget() {
    this.#empty = true;
    this.#frame = null;
    // The canvas shows the former source.
    this.#canvas.classList.add("empty");
    this.#dropStill();
    this.setEnvironments([]);
  }

  async setEnvironments(environments) {
    this.environments = environments;
    if (await this.#renderer.setEnvironments(environments)) this.wake();
  }

  /** ground, sky, line: elements whose background colours are those of the empty scene, above it, and of the grid. */
  readColours(ground, sky, line) {
    const [clear, above, grid] = [ground, sky, line].map((node) =>
      readColour(this.#view.getComputedStyle(node).backgroundColor),
    );
    this.#colours = {
      clear: clear ?? [0, 0, 0, 1],
      sky: above ?? [...mix((clear ?? [0, 0, 0]).slice(0, 3), BLUE, BLUENESS), 1],
      grid: grid ?? [0.3, 0.3, 0.3, 1],
    };
    this.wake();
  }
  set(options) {
    Object.assign(this.options, options);
    this.dispatchEvent(new Event("options"));
    this.wake();
  }

  wake() {
    if (this.#immersed || this.#asked) return;
    this.#asker = this.#view;
    this.#asked = this.#asker.requestAnimationFrame((now) => this.#tick(now));
  }

  #tick(now) {
    this.#asked = 0;
    const plays = this.#media.tick();
    const moves = this.#navigator.step(now);
    const continues = plays || moves;
    this.resolution.observe(now, continues);
    this.#delay.draws(now, continues);
    if (!this.#empty) this.#draw(continues);
    if (continues) this.wake();
  }

  /** While it is set, somebody else calls drawEyes for each picture of the screen. */
  set immersed(immersed) {
    if (this.#asked === -1) return;
    this.#asker?.cancelAnimationFrame(this.#asked);
    clearTimeout(this.#settle);
    this.#asked = 0;
    this.#settle = null;
    this.#immersed = immersed;
    if (immersed) this.#takeContext();
    this.wake();
  }
  /** What a Placement needs of the scene. */
  get place() {
    const { extent, axes, pose } = this.#navigator;
    const { floor, scaleKnown } = this.#frame ?? { floor: null, scaleKnown: false };
    return { extent, axes, eye: pose.eye, floor, scaleKnown };
  }
  /** views: as Renderer.drawViews takes them. overWorld: without anything around the scene. */
  drawEyes(views, framebuffer, overWorld) {
    this.#delay.draws(performance.now(), this.#media.tick());
    if (this.#empty) return;
    // In a headset the room is real to the viewer: nothing of it fades.
    const drawing = { ...this.#drawing(), sheet: null, fade: false };
    const bare = { environment: false, sky: null, grid: null, clearColour: [0, 0, 0, 0] };
    this.#renderer.drawViews(views, overWorld ? { ...drawing, ...bare } : drawing, framebuffer);
  }

  #draw(moving) {
    clearTimeout(this.#settle);
    this.#settle = null;
    if (!this.#visible) return;
    const { clientWidth, clientHeight } = this.#canvas;
    const { devicePixelRatio } = this.#view;
    const finest = this.resolution.ratio(devicePixelRatio, false);
    const ratio = this.resolution.ratio(devicePixelRatio, moving);
    const surfaceScale = this.resolution.surfaceScale(moving);
    const width = Math.max(1, Math.round(clientWidth * ratio));
    const height = Math.max(1, Math.round(clientHeight * ratio));
    this.#navigator.aspect = width / height;
    if (this.#renderer.released && !this.#takeContext()) return;
    // At full resolution the renderer knows how it is fastest.
    const drawing = surfaceScale < 1 ? { ...this.#drawing(), surfaceScale } : this.#drawing();
    if (this.#renderer.draw(this.#navigator.view(width, height), drawing)) {
      contexts.use(this);
      this.#drawnAt = performance.now();
      this.#owes = false;
      this.#dropStill();
      this.#canvas.classList.remove("empty");
      // Until the end of this task the canvas can be read.
      this.dispatchEvent(new Event("drawn"));
    }
    // Another picture at full resolution after a while without movement.
    if (moving && (ratio < finest || surfaceScale < 1)) this.#settle = setTimeout(() => this.wake(), REST);
  }

  #drawing() {
    const { frusta, picturePlanes, selected, grid, environment, sheet, ...others } = this.options;
    delete others.sheetBottom;
    const { radius } = this.#navigator.extent;
    const bare = !environment || !this.environments.length;
    return {
      ...others,
      environment,
      clearColour: this.#colours.clear,
      sky: this.#colours.sky,
      up: this.#navigator.axes.up,
      sheet: sheet ? this.sheetCells : null,
      grid: grid && bare ? { ...this.#ground, colour: this.#colours.grid } : null,
      frusta: frusta
        ? { cameras: this.#outlines(), selected, picturePlanes, only: this.#only, length: FRUSTUM * radius }
        : null,
    };
  }

  /** Identifier of the camera whose picture alone fills the view; null: none. */
  get #only() {
    return this.onlyPictures && this.#navigator.arrived ? this.#navigator.camera : null;
  }

  /** Without the camera of the view, whose frustum would enclose the picture. The same array while nothing changes. */
  #outlines() {
    const { cameras } = this;
    const without = this.#navigator.camera;
    const former = this.#outlined;
    if (former.cameras === cameras && former.without === without) return former.found;
    const found = cameras.filter(({ id, calibrated }) => calibrated && id !== without);
    this.#outlined = { cameras, without, found };
    return found;
  }

  close() {
    this.#asker?.cancelAnimationFrame(this.#asked);
    for (const timer of [this.#settle, this.#waiting, this.#losing]) clearTimeout(timer);
    this.#asked = -1;
    contexts.leave(this);
    this.#dropStill();
    // Otherwise the browser counts it until it collects its garbage.
    this.#renderer.release();
    this.#renderer.close();
  }
}
