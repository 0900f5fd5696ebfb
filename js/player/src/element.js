// The element <fvv-player>: connects playback, picture, navigation and controls.

import { createDecoder } from "@fvv/decoder";

import { PointerControls } from "./navigation/pointer.js";
import { Bookmarks } from "./navigation/view_text.js";
import { Stage } from "./stage.js";
import { Interface } from "./ui/interface.js";
import { styleSheets } from "./ui/style.js";
import { element } from "./ui/widgets.js";
import { VIEW_ATTRIBUTES, ViewpointElement } from "./viewpoint_element.js";

/** Frames that are decoded ahead. The renderer keeps one picture, shows one, and one is in the queue: four are open. */
const QUEUE = 1;
const RECONNECT = { attempts: 10, firstMs: 250, longestMs: 8000 };
/** Duration in seconds of a change of view by attributes. */
const JOURNEY = 0.5;

export class FvvPlayer extends ViewpointElement {
  static observedAttributes = [
    "src",
    "poster",
    "autoplay",
    "loop",
    "controls",
    "live",
    "theme",
    "navigation",
    "view-mode",
    "quality",
    "aria-label",
    ...VIEW_ATTRIBUTES,
  ];

  #media;
  #interface = null;
  #pointer = null;
  #poster;
  #surface;
  #parts;
  #connected = null; // AbortController of listeners while the element is in a document
  #loading = false;
  #bookmarks = null;
  /** Further options for createDecoder. */
  decoderOptions = {};
  hasPlayed = false;

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    root.adoptedStyleSheets = styleSheets();
    this.#media = this._makeMedia({
      open: (source) => this.#open(source),
      show: (frame) => this._stage.show(frame),
      vacate: () => this._stage.vacate(),
      wake: () => this._stage?.wake(),
    });
    this._navigator.addEventListener("change", () => {
      const { source } = this._navigator;
      this.dispatchEvent(new CustomEvent("camera-change", { detail: { source } }));
    });
    this.addEventListener("playing", () => (this.hasPlayed = true));
    this.addEventListener("emptied", () => (this.hasPlayed = false));
  }

  connectedCallback() {
    if (this.#connected) return;
    this.#connected = new AbortController();
    const { signal } = this.#connected;
    this.#build(signal);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const calm = matchMedia("(prefers-reduced-motion: reduce)");
    this._navigator.calm = calm.matches;
    calm.addEventListener("change", () => (this._navigator.calm = calm.matches), { signal });
    dark.addEventListener("change", () => this.#readColours(), { signal });
    document.addEventListener("visibilitychange", () => (this.#media.suspended = document.hidden), { signal });
    document.addEventListener("fullscreenchange", () => this.dispatchEvent(new Event("optionschange")), { signal });
    this.#media.suspended = document.hidden;
    this.#bookmarks = new Bookmarks(this, signal);
    this.load();
  }

  disconnectedCallback() {
    // An element that is moved within the document continues to play.
    queueMicrotask(() => {
      if (this.isConnected || !this.#connected) return;
      this.#media.load(null);
      this.#connected.abort();
      this._stage?.close();
      this.#connected = this._stage = this.#interface = null;
      this.#parts.remove();
    });
  }

  #build(signal) {
    const canvas = element("canvas", { "aria-hidden": "true" });
    const ground = element("div", { class: "ground" });
    const line = element("div", { class: "line" });
    this.#surface = element(
      "div",
      { class: "surface", part: "surface", role: "application", tabIndex: 0, "aria-roledescription": "free viewpoint" },
      canvas,
    );
    this.#poster = element("img", { class: "poster", part: "poster", alt: "", hidden: true });
    this.#parts = element("div", { class: "frame" }, ground, line, this.#surface, this.#poster);
    this.shadowRoot.append(this.#parts);
    this.#updateLabel();
    this.#interface = new Interface(this, this.#parts, this.#surface, this._navigator, signal);
    try {
      this._stage = new Stage(canvas, this.#media, this._navigator);
    } catch (error) {
      this.#media.fail(error);
      return;
    }
    this._stage.addEventListener("begin", () => this.#begin());
    this.#pointer = new PointerControls(this.#surface, this._navigator, (event) => this.#click(event), signal);
    this.#surface.addEventListener("dblclick", () => this.controls && this.toggleFullscreen(), { signal });
    const observer = new ResizeObserver(() => this._stage?.wake());
    observer.observe(this.#surface);
    signal.addEventListener("abort", () => observer.disconnect());
    for (const name of ["view-mode", "quality", "navigation"]) this.#apply(name);
    this.#readColours();
  }

  #updateLabel() {
    this.#surface?.setAttribute("aria-label", `${this.getAttribute("aria-label") ?? "Scene"}, free viewpoint. H: keys`);
  }
  #readColours() {
    const [ground, line] = [".ground", ".line"].map((name) => this.shadowRoot.querySelector(name));
    this._stage?.readColours(ground, line);
  }
  #click(event) {
    if (this.controls && event.pointerType === "mouse" && this.readyState >= 2) this.#interface.commands.togglePlay();
  }

  attributeChangedCallback(name, before, after) {
    if (before === after) return;
    if (name === "src" || name === "live") this.load();
    else this.#apply(name);
  }
  #apply(name) {
    const value = this.getAttribute(name);
    if (name === "autoplay" || name === "loop") this.#media[name] = value !== null;
    else if (name === "theme") this.#readColours();
    else if (name === "aria-label") this.#updateLabel();
    else if (name === "poster") this.#showPoster();
    else if (name === "navigation" && this.#pointer) this.#pointer.flying = value === "fly";
    else if (name === "view-mode") this._chooseDrawing();
    else if (name === "quality" && this._stage) {
      this._stage.resolution.quality = this.quality;
      this._stage.wake();
    } else if (VIEW_ATTRIBUTES.includes(name)) {
      if (this._stage?.empty === false) this._navigator.goTo(this._firstPose, JOURNEY);
    }
    this.dispatchEvent(new Event("optionschange"));
  }

  /** Loads src or srcObject, after the current code has set all attributes. */
  load() {
    if (this.#loading || !this.#connected) return;
    this.#loading = true;
    this.#media.reset();
    this.#media.playbackRate = this.defaultPlaybackRate;
    queueMicrotask(() => {
      this.#loading = false;
      if (!this._stage) return;
      this._stage.forget();
      this.#showPoster();
      this.#media.load(this._source, { live: this.live, at: this.#bookmarks.place });
    });
  }
  #showPoster() {
    const { poster } = this;
    if (!this.#poster || this._stage?.empty === false) return;
    this.#poster.hidden = !poster;
    if (poster) this.#poster.src = poster;
  }

  async #open(source) {
    const { worker } = this;
    const described = this.live && typeof source === "string" ? { url: source, reconnect: RECONNECT } : source;
    const decoder = await createDecoder({
      ...this.decoderOptions,
      ...(worker && { worker: worker === "none" ? false : new URL(worker, this.baseURI) }),
      source: described,
      normals: true,
      visibilityWeights: true,
      queue: QUEUE,
    });
    decoder.addEventListener("background", ({ detail }) => this._stage?.setBackgrounds(detail));
    for (const type of ["warning", "gap", "corrupt"])
      decoder.addEventListener(type, ({ detail }) => this.dispatchEvent(new CustomEvent(type, { detail })));
    return decoder;
  }

  #begin() {
    this.#poster.hidden = true;
    if (VIEW_ATTRIBUTES.some((name) => this.hasAttribute(name))) this._navigator.goTo(this._firstPose);
    this.#bookmarks.look();
    this.dispatchEvent(new Event("optionschange"));
  }

  get worker() {
    return this.getAttribute("worker");
  }
  set worker(url) {
    this.setAttribute("worker", url);
  }
  get keys() {
    return this.getAttribute("keyboard") !== "off";
  }

  get isFullscreen() {
    return document.fullscreenElement === this;
  }
  toggleFullscreen() {
    const done = this.isFullscreen ? document.exitFullscreen() : this.requestFullscreen?.();
    done?.catch(() => this.#interface.notify("Full screen is not allowed here"));
  }

  /** Whether the view moves, or is about to be drawn again. */
  get isMoving() {
    return this._stage?.busy ?? false;
  }
  /** The canvas as RGBA, top row first: {width, height, data}. */
  readPixels() {
    return this._stage.renderer.readPixels();
  }

  get showsStats() {
    return this.#interface?.showsStats ?? false;
  }
  /** Statistics of playback and drawing. */
  get stats() {
    const { meter, openFrames, currentTime, frameCount, currentFrame } = this.#media;
    const now = performance.now();
    const counters = this._stage?.renderer.counters ?? {};
    const canvas = this.#surface?.querySelector("canvas");
    return {
      framesShown: meter.framesShown,
      framesDropped: meter.framesDropped,
      framesPerSecond: meter.framesPerSecond(now),
      openVideoFrames: openFrames + meter.queued,
      decodeMs: meter.decodeMs,
      showMs: meter.showMs,
      bufferedSeconds: this.buffered.ahead(currentTime),
      bitrate: meter.bitrate(now),
      memoryBytes: meter.memoryBytes,
      frame: currentFrame,
      frameCount,
      width: canvas?.width ?? 0,
      height: canvas?.height ?? 0,
      ...counters,
    };
  }

  /** The current time and view, as text for the page's address. */
  get bookmark() {
    return this.#bookmarks?.text ?? "";
  }
  get bookmarks() {
    return this.hasAttribute("bookmarks");
  }
  /** Puts the bookmark into the page's address, and copies the address to the clipboard. */
  async copyBookmark() {
    const url = this.#bookmarks.put();
    try {
      await navigator.clipboard.writeText(url);
      this.#interface.notify("Link copied");
    } catch {
      this.#interface.notify("The link is in the address bar");
    }
    return url;
  }
}
