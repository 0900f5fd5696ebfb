// The canvas, its renderer, and when they draw. Nothing is drawn, and no animation frame is requested, while nothing
// changes.

import { Renderer } from "./renderer/index.js";
import { Resolution } from "./resolution.js";
import { dot } from "./vectors.js";

/** Milliseconds without movement after which the picture is drawn at full resolution. */
const REST = 180;
/** Length of frusta, relative to the scene's size. */
const FRUSTUM = 0.28;

/** The largest of 1, 2, 5, 10, 20, ... that is not greater than x. */
function roundDown(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [5, 2, 1].find((digit) => digit * power <= x * (1 + 1e-9));
}

/** "rgb(20, 24, 28)" as display values. */
function readColour(text) {
  const [r, g, b] = (text.match(/[\d.]+/g) ?? []).map(Number);
  return b === undefined ? [0, 0, 0, 1] : [r / 255, g / 255, b / 255, 1];
}

export class Stage extends EventTarget {
  #canvas;
  #media;
  #navigator;
  #renderer;
  #asked = 0;
  #settle = null;
  #frame = null; // {cameras} of the frame on screen
  #ground = null;
  #empty = true;
  #bare = true; // no mesh so far: the extent is a guess
  #outlined = { cameras: null, without: null, found: null };
  resolution = new Resolution();
  backgrounds = [];
  options = {
    mode: "textured",
    visibleBy: "auto",
    cameras: null,
    soft: 0,
    shadows: true,
    environment: true,
    grid: true,
    frusta: false,
    picturePlanes: false,
    selected: null,
  };
  #colours = { clear: [0, 0, 0, 1], grid: [0.3, 0.3, 0.3, 1] };

  constructor(canvas, media, navigator) {
    super();
    this.#canvas = canvas;
    this.#media = media;
    this.#navigator = navigator;
    this.#renderer = new Renderer(canvas);
    for (const type of ["lost", "restored"])
      this.#renderer.addEventListener(type, () => {
        this.dispatchEvent(new Event(type));
        this.wake();
      });
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

  /** Whether a picture is about to be drawn. */
  get busy() {
    return this.#asked !== 0 || this.#settle !== null;
  }

  async show(frame) {
    const shown = await this.#renderer.show(frame);
    if (!shown) return false;
    this.#frame = { cameras: frame.cameras };
    if (this.#empty || (this.#bare && frame.mesh)) this.#begin(frame);
    else this.#navigator.follow(frame.cameras);
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
    this.#navigator.aspect = this.#canvas.clientWidth / Math.max(1, this.#canvas.clientHeight);
    this.#navigator.begin(frame);
    const { up } = this.#navigator.axes;
    const { centre, radius } = this.#navigator.extent;
    const points = frame.mesh?.positions ?? [];
    let low = Infinity;
    for (let i = 0; i < points.length; i += 3) low = Math.min(low, dot(points.subarray(i, i + 3), up));
    const down = Number.isFinite(low) ? dot(centre, up) - low : 0;
    const step = roundDown(radius / 3);
    const extent = step * Math.ceil((3 * radius) / step);
    this.#ground = { centre: centre.map((x, i) => x - down * up[i]), up, extent, step };
    this.dispatchEvent(new Event("begin"));
  }
  /** Another source: the next frame defines the first view. */
  forget() {
    this.#empty = true;
    // The canvas shows the former source.
    this.#canvas.classList.add("empty");
    this.setBackgrounds([]);
  }

  async setBackgrounds(backgrounds) {
    this.backgrounds = backgrounds;
    if (await this.#renderer.setBackgrounds(backgrounds)) this.wake();
  }

  /** surface, line: elements whose background colours are those of the empty scene and of the grid. */
  readColours(surface, line) {
    this.#colours = {
      clear: readColour(getComputedStyle(surface).backgroundColor),
      grid: readColour(getComputedStyle(line).backgroundColor),
    };
    this.wake();
  }
  set(options) {
    Object.assign(this.options, options);
    this.dispatchEvent(new Event("options"));
    this.wake();
  }

  wake() {
    this.#asked ||= requestAnimationFrame((now) => this.#tick(now));
  }

  #tick(now) {
    this.#asked = 0;
    const plays = this.#media.tick();
    const moves = this.#navigator.step(now);
    const continues = plays || moves;
    this.resolution.observe(now, continues);
    if (!this.#empty) this.#draw(continues);
    if (continues) this.wake();
  }

  #draw(moving) {
    clearTimeout(this.#settle);
    this.#settle = null;
    const { clientWidth, clientHeight } = this.#canvas;
    const finest = this.resolution.ratio(devicePixelRatio, false);
    const ratio = moving ? this.resolution.ratio(devicePixelRatio, true) : finest;
    const width = Math.max(1, Math.round(clientWidth * ratio));
    const height = Math.max(1, Math.round(clientHeight * ratio));
    this.#navigator.aspect = width / height;
    if (this.#renderer.draw(this.#navigator.view(width, height), this.#drawing()))
      this.#canvas.classList.remove("empty");
    // Another picture at full resolution after a while without movement.
    if (moving && ratio < finest) this.#settle = setTimeout(() => this.wake(), REST);
  }

  #drawing() {
    const { frusta, picturePlanes, selected, grid, environment, ...others } = this.options;
    const { radius } = this.#navigator.extent;
    const bare = !environment || !this.backgrounds.length;
    return {
      ...others,
      environment,
      clearColour: this.#colours.clear,
      grid: grid && bare ? { ...this.#ground, colour: this.#colours.grid } : null,
      frusta: frusta ? { cameras: this.#outlines(), selected, picturePlanes, length: FRUSTUM * radius } : null,
    };
  }

  /** Without the camera of the view, whose frustum would enclose the picture. The same array while nothing changes. */
  #outlines() {
    const { cameras } = this.#frame;
    const without = this.#navigator.camera;
    const former = this.#outlined;
    if (former.cameras === cameras && former.without === without) return former.found;
    const found = cameras.filter(({ id, calibrated }) => calibrated && id !== without);
    this.#outlined = { cameras, without, found };
    return found;
  }

  close() {
    cancelAnimationFrame(this.#asked);
    clearTimeout(this.#settle);
    this.#asked = -1;
    this.#renderer.close();
  }
}
