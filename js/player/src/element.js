// The element <fvv-player>: connects playback, picture, navigation and controls.

import { createDecoder } from "@fvv/decoder";

import { PointerControls } from "./navigation/pointer.js";
import { Bookmarks } from "./navigation/view_text.js";
import { shownScale } from "./view.js";
import { Sound } from "./playback/sound.js";
import { ViewpointTracks } from "./playback/viewpoint_tracks.js";
import { Stage } from "./stage.js";
import { Surroundings } from "./surroundings.js";
import { TOOLS, ToolsEntry } from "./tools/entry.js";
import { Interface } from "./ui/interface.js";
import { styleSheets } from "./ui/style.js";
import { element } from "./ui/widgets.js";
import { VIEW_ATTRIBUTES, ViewpointElement } from "./viewpoint_element.js";
import { Immersive } from "./xr/entry.js";

/** Frames that are decoded ahead. The renderer keeps one picture, shows one, and one is in the queue: four are open. */
const QUEUE = 1;
const TOUCH_ACTIONS = ["pan-y", "pan-x", "none"];
/** Milliseconds within which an element that was taken out of its document may come back as it was. */
const ABSENCE = 1000;
/** budgetMs bounds it. */
const UNBOUNDED = Number.MAX_SAFE_INTEGER;
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
    "controlslist",
    "theme",
    "navigation",
    "view-mode",
    "pixel-ratio",
    "quality",
    "rung",
    "tools",
    "marks",
    "aria-label",
    ...VIEW_ATTRIBUTES,
  ];

  #media;
  #sound;
  #playedRung = null;
  #onScreen = null; // {cameras, tracks, rung, configuration, group} of the frame on screen
  #choosesTracks = true; // the page does not
  #viewpoint = null; // {decoder, tracks} of the stream that is played
  #looking = false;
  #told = null; // number of the group for which the decoder knows how large pictures are shown
  #interface = null;
  #pointer = null;
  #poster;
  #surface;
  #parts;
  #connected = null; // AbortController of listeners while the element is in a document
  #surroundings = new Surroundings(this);
  #leaving = null; // timer while the element is in no document
  #unavailable = null; // why nothing can be drawn
  #keptPose = null; // for a new stage
  #loading = false;
  #bookmarks = null;
  #immersive = null;
  #tools = null;
  #unsupported = false; // a codec of the source
  #lost = []; // codecs of videos without a picture
  #outage = null;
  /** Further options for createDecoder, of all players. */
  static decoderOptions = {};
  /** The same of this one. */
  decoderOptions = {};
  /** What starts a worker where the attribute names none; undefined: as createDecoder does. */
  static _startWorker = undefined;

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open", delegatesFocus: true });
    root.adoptedStyleSheets = styleSheets(this.#surroundings.view);
    this.#sound = new Sound({
      motion: () => this.#media.motion,
      listener: () => (this._stage?.empty === false ? this._navigator.pose : null),
      scale: () => this._navigator.extent.radius,
      changed: () => this.dispatchEvent(new Event("optionschange")),
    });
    this.#media = this._makeMedia({
      now: () => this.#sound.now(),
      open: (source, isKnown) => this.#open(source, isKnown),
      show: (frame) => this.#show(frame),
      vacate: () => this._stage.vacate(),
      wake: () => this._stage?.wake(),
      screen: () => this._stage.screen,
    });
    this._navigator.addEventListener("change", () => {
      const { source } = this._navigator;
      this.dispatchEvent(new CustomEvent("camera-change", { detail: { source } }));
      if (this.paused) this.#lookAround();
    });
    this.#sound.muted = this.muted;
    this.addEventListener("volumechange", () => {
      this.#sound.volume = this.volume;
      this.#sound.muted = this.muted;
      this.dispatchEvent(new Event("optionschange"));
    });
    for (const type of ["playing", "pause", "seeking", "seeked", "waiting", "ratechange", "ended"])
      this.addEventListener(type, () => this.#sound.update());
    // After a seek, a step or a movement nothing covers the picture.
    for (const type of ["playing", "seeked"]) this.addEventListener(type, () => (this.wasUsed = true));
    this.addEventListener("camera-change", ({ detail }) => {
      this.wasUsed ||= detail.source === "user";
      if (detail.source === "user") this.#media.uncover();
    });
    this.addEventListener("framechange", () => this.#uncover());
    this.addEventListener("emptied", () => (this.wasUsed = false));
    this.addEventListener("loadeddata", () => this._beginMoves());
    this.addEventListener("error", () => this._abandonMoves());
  }

  connectedCallback() {
    clearTimeout(this.#leaving);
    if (this.#connected) return this.#settleIn();
    this.#connected = new AbortController();
    const { signal } = this.#connected;
    this.#build(signal);
    this.#listen(signal);
    this.#settleIn();
    this.#immersive = new Immersive(signal);
    this.#immersive.addEventListener("change", () => {
      if (this.immersive) this.setAttribute("immersive", this.immersive);
      else this.removeAttribute("immersive");
      this.#attend();
      this.dispatchEvent(new Event("optionschange"));
    });
    this.#bookmarks = new Bookmarks(this, signal);
    this.#tools = new ToolsEntry(
      { player: this, root: this.#parts, surface: this.#surface, scene: this.#scene },
      signal,
    );
    this.#apply("tools");
    this.load();
  }

  /** An element that is moved, also one that is taken out for a moment, keeps its place and view and goes on playing. */
  disconnectedCallback() {
    if (!this.#connected) return;
    queueMicrotask(() => this.#attend());
    clearTimeout(this.#leaving);
    this.#leaving = setTimeout(() => this.#leave(), ABSENCE);
  }

  /** Constructed style sheets are valid in one document. */
  adoptedCallback() {
    const { defaultView: view } = this.ownerDocument;
    if (view) this.shadowRoot.adoptedStyleSheets = styleSheets(view);
    this.#tools?.open?.adopt();
  }

  #leave() {
    this.#media.load(null);
    this.#sound.close();
    this.#connected.abort();
    this.#surroundings.leave();
    this._stage?.close();
    this.#connected = this._stage = this.#interface = null;
    this.#parts.remove();
  }

  /** The element is in a document, which may be another one. */
  #settleIn() {
    if (this.#surroundings.enter()) {
      this._stage?.moved();
      this.#readColours();
    }
    this.#attend();
  }
  #listen(signal) {
    const on = (type, listener) => this.#surroundings.addEventListener(type, listener, { signal });
    on("visible", () => this.#attend());
    on("density", () => this._stage?.wake());
    on("colours", () => this.#readColours());
    on("calm", () => (this._navigator.calm = this.#surroundings.calm));
    on("fullscreen", () => this.dispatchEvent(new Event("optionschange")));
    on("resize", () => {
      this._stage?.wake();
      if (this.contactSheet.length) this.dispatchEvent(new Event("optionschange"));
    });
  }
  /** What cannot be seen is neither decoded nor drawn. */
  #attend() {
    if (!this.#connected) return;
    const visible = this.#surroundings.visible || this.immersive !== null;
    this.#media.suspended = !visible;
    if (this._stage) this._stage.visible = visible;
    this.#sound.update();
  }

  #build(signal) {
    const ground = element("div", { class: "ground" });
    const sky = element("div", { class: "sky" });
    const line = element("div", { class: "line" });
    this.#surface = element("div", {
      class: "surface",
      part: "surface",
      role: "application",
      tabIndex: 0,
      "aria-roledescription": "free viewpoint",
    });
    this.#poster = element("img", { class: "poster", part: "poster", alt: "", hidden: true });
    this.#parts = element("div", { class: "frame" }, ground, sky, line, this.#surface, this.#poster);
    this.shadowRoot.append(this.#parts);
    this.#updateLabel();
    this.#interface = new Interface(this, this.#parts, this.#surface, this._navigator, signal);
    this.#pointer = new PointerControls(this.#surface, this._navigator, (event) => this.#click(event), signal);
    this.#surface.addEventListener("dblclick", () => this.controls && this.toggleFullscreen(), { signal });
    this.#apply("navigation");
    this.#makeStage();
  }

  #makeStage() {
    const canvas = element("canvas", { "aria-hidden": "true" });
    this.#surface.replaceChildren(canvas);
    this.#unavailable = null;
    try {
      this._stage = new Stage(canvas, this.#media, this._navigator);
    } catch (error) {
      this.#unavailable = error;
      return;
    }
    this._stage.addEventListener("begin", () => this.#begin());
    this._stage.addEventListener("options", () => this.#lookAround());
    this._stage.addEventListener("drawn", () => this.#interface.keepPreview(canvas));
    this._stage.addEventListener("drawn", () => this.#tools?.open?.draw());
    this._stage.addEventListener("gone", () => this.dispatchEvent(new Event("optionschange")));
    for (const name of ["view-mode", "pixel-ratio"]) this.#apply(name);
    this.#readColours();
  }

  /** Whether the browser has taken the WebGL context, and does not give it back. */
  get contextLost() {
    return this._stage?.gone ?? false;
  }
  /** Draws with another context; place, view and pause stay. */
  renewContext() {
    if (!this._stage) return;
    if (!this._stage.empty) this.#keptPose = this.getPose();
    this._stage.close();
    this._stage = null;
    this.#makeStage();
    this.#attend();
    if (!this._stage) return this.#media.fail(this.#unavailable);
    // The frame on screen is shown once more.
    if (this.seekable.length) this.currentFrame = this.currentFrame;
    this.dispatchEvent(new Event("optionschange"));
  }

  #updateLabel() {
    this.#surface?.setAttribute("aria-label", `${this.getAttribute("aria-label") ?? "Scene"}, free viewpoint. H: keys`);
  }
  #readColours() {
    const nodes = [".ground", ".sky", ".line"].map((name) => this.shadowRoot.querySelector(name));
    this._stage?.readColours(...nodes);
  }
  #click(event) {
    if (this.#tools.open?.takesClicks) return;
    if (this.controls && event.pointerType === "mouse" && this.readyState >= 2) this.#interface.commands.togglePlay();
  }

  attributeChangedCallback(name, before, after) {
    // As with media elements, src loads again also with the same value.
    if (before === after && name !== "src") return;
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
    else if (name === "view-mode" || name === "controls") this._chooseDrawing();
    else if (name === "rung") this.#chooseRung();
    else if (name === "tools" || name === "marks") this.#chooseTools();
    else if (name === "pixel-ratio" || name === "quality") {
      if (name === "quality" && value !== null)
        console.warn("<fvv-player>: the attribute quality is now pixel-ratio: auto, or a number");
      if (this._stage) {
        this._stage.resolution.pixelRatio = this.pixelRatio;
        this._stage.wake();
      }
    } else if (VIEW_ATTRIBUTES.includes(name)) {
      if (this._stage?.empty === false) this._navigator.goTo(this._firstPose, JOURNEY);
    }
    this.dispatchEvent(new Event("optionschange"));
  }

  /** What tools see of the scene. */
  get #scene() {
    return {
      shown: () => (this.contactSheet.length || this.immersive ? null : (this._stage?.shown ?? null)),
      size: () => this._navigator.extent.radius,
      up: () => this._navigator.axes.up,
      floor: () => this._stage?.place.floor ?? null,
      carry: (by) => this._navigator.carry(by),
    };
  }
  #chooseTools() {
    const names = this.tools.toLowerCase().split(/\s+/);
    this.#tools
      ?.choose(
        TOOLS.filter((name) => names.includes(name)),
        this.marks,
      )
      .catch(({ message }) => {
        if (this.#connected) this.#interface.notify(`The tools cannot be loaded: ${message}`);
      });
  }
  /** Which tools are offered over the picture, with spaces: "measure", "mark", "follow". */
  get tools() {
    return this.getAttribute("tools") ?? "";
  }
  set tools(names) {
    this.setAttribute("tools", names);
  }
  /** URL of a document of marks that is shown, with or without tools; "": none. */
  get marks() {
    const marks = this.getAttribute("marks");
    return marks ? new URL(marks, this.baseURI).href : "";
  }
  set marks(url) {
    this.setAttribute("marks", url);
  }
  /** The document of the marks that are shown. */
  getMarks() {
    return this.#tools?.open?.document ?? { fvv_marks: 1, marks: [] };
  }
  /** Shows a document of marks in place of the former. TypeError: it is not one. */
  async setMarks(document) {
    const tools = await this.#tools?.load();
    if (!tools) throw new DOMException("the player is not in a page", "InvalidStateError");
    tools.document = document;
  }
  /** The view keeps an object in its place: its name or its identifier; null: none. RangeError: the stream names no such object. */
  async follow(object) {
    await (await this.#tools?.load())?.follow(object);
  }
  /** What was measured with the tools. */
  get measurements() {
    return this.#tools?.open?.measurements ?? [];
  }

  /** Loads src or srcObject, after the current code has set all attributes. */
  load() {
    if (this.#loading || !this.#connected) return;
    this.#loading = true;
    if (this._stage?.empty === false) this._forgetCameras();
    if (this.networkState !== FvvPlayer.NETWORK_EMPTY) this._abandonMoves();
    this.#lost = [];
    this.#onScreen = null;
    this.#unsupported = false;
    this.#outage = null;
    this.#media.reset();
    this.#sound.reset();
    this.#media.playbackRate = this.defaultPlaybackRate;
    queueMicrotask(() => {
      this.#loading = false;
      if (!this.#connected) return;
      if (!this._stage) return this.#media.fail(this.#unavailable);
      this._stage.forget();
      this.#surface.classList.remove("covered");
      this.#showPoster();
      this.#media.load(this._source, { live: this.live, at: this.#bookmarks.place });
    });
  }
  #showPoster() {
    const { poster } = this;
    if (!this.#poster || this.readyState >= FvvPlayer.HAVE_CURRENT_DATA) return;
    this.#poster.hidden = !poster;
    this.#poster.classList.remove("gone");
    if (poster) this.#poster.src = poster;
  }

  /** isKnown: it has been open before, so that its address is right, and a host that is away may come back. */
  async #open(source, isKnown) {
    const { worker } = this;
    const described = this.live && typeof source === "string" ? { url: source, reconnect: true } : source;
    const { tracks, look, network } = { ...FvvPlayer.decoderOptions, ...this.decoderOptions };
    this.#choosesTracks = !tracks && !look;
    const decoder = await createDecoder({
      // Also without WebCodecs: JPEG needs none, and the decoder then reports what it cannot decode.
      video: "decoded",
      sound: "decoded",
      rung: this.rung,
      worker: FvvPlayer._startWorker,
      ...FvvPlayer.decoderOptions,
      ...this.decoderOptions,
      onOutage: (outage) => this.#takeOutage(outage),
      renewAddress: (expired) => this.#renewAddress(expired),
      ...(worker && { worker: worker === "none" ? false : new URL(worker, this.baseURI) }),
      ...(isKnown && { network: { ...network, openBudgetMs: UNBOUNDED } }),
      source: described,
      normals: true,
      queue: QUEUE,
    });
    this.#sound.follow(decoder);
    decoder.addEventListener("rung", ({ detail }) => this.#takeRung(detail));
    decoder.addEventListener("environment", ({ detail }) => this._stage?.setEnvironments(detail));
    decoder.addEventListener("warning", ({ detail }) => {
      this.dispatchEvent(new CustomEvent("warning", { detail }));
      this.#takeWarning(detail);
    });
    return decoder;
  }

  /** Requests fail and are tried again; null: bytes come again. What is buffered is played meanwhile. */
  #takeOutage(outage) {
    this.#outage = outage;
    const type = outage ? "stalled" : "recovered";
    this.dispatchEvent(new CustomEvent(type, { detail: outage }));
  }
  /** Why requests fail, {url, reason, offline, attempt, retryMs}; null: they do not. */
  get outage() {
    return this.#outage;
  }
  /** A listener of the event calls respondWith with the address, or its promise. */
  async #renewAddress(expired) {
    let answer = null;
    const respondWith = (address) => (answer = address);
    this.dispatchEvent(new CustomEvent("addressexpired", { detail: { ...expired, respondWith } }));
    return answer;
  }

  #chooseRung() {
    const { decoder } = this.#media;
    decoder?.setRung(this.rung).then(
      () => this.#media.improve(),
      () => {},
    );
    this.dispatchEvent(new Event("optionschange"));
  }
  #takeRung(detail) {
    this.#playedRung = detail.rung;
    this.dispatchEvent(new CustomEvent("rungchange", { detail }));
    this.dispatchEvent(new Event("optionschange"));
  }
  /** Rungs of the stream's ladder, best first; one or none without a ladder. */
  get rungs() {
    return this.#media.decoder?.rungs ?? [];
  }
  /** The rung that is played; null: there is no ladder. */
  get playedRung() {
    return this.rungs.length > 1 ? this.#playedRung : null;
  }
  /** Tells the decoder how large the cameras' pictures are shown, once for each group. */
  #tellScale({ group, cameras }) {
    const { decoder } = this.#media;
    if (!(decoder?.rungs.length > 1) || this.#told === group.sequence) return;
    this.#told = group.sequence;
    decoder
      .setShownScale(shownScale(this._navigator.pose, this.#surface.querySelector("canvas")?.height ?? 0, cameras))
      .catch(() => {});
  }

  /** Fetches the tracks of video that the viewer needs. frame: on screen. */
  async #lookAround() {
    const { decoder } = this.#media;
    if (!decoder || !this.#onScreen || !this._stage || this.#looking || !this.#choosesTracks) return;
    if (this.#viewpoint?.decoder !== decoder) this.#viewpoint = { decoder, tracks: new ViewpointTracks(decoder) };
    this.#looking = true;
    try {
      const pose = this._navigator.pose;
      const { tracks } = this.#viewpoint;
      const lacks = await tracks.follow(this.#onScreen, pose, performance.now(), this.#viewerAloneDecides);
      if (lacks && decoder === this.#media.decoder) this.#media.refetch();
    } catch {
      // The decoder was closed, or reports why with its next frame.
    } finally {
      this.#looking = false;
    }
  }
  /** Whether no picture is shown but for the surface that the viewer sees. */
  get #viewerAloneDecides() {
    const { mode, sheet, picturePlanes, cameras } = this._stage.options;
    return mode === "textured" && !sheet && !picturePlanes && !cameras && !this.immersive && !this._stage.onlyPictures;
  }

  async #show(frame) {
    // Media decides when the first frame of a ladder is good enough to be seen.
    if (this.readyState < FvvPlayer.HAVE_CURRENT_DATA && frame.rung > 0) this.#surface.classList.add("covered");
    if (!(await this._stage.show(frame))) return;
    this.#tellScale(frame);
    const { cameras, tracks, rung, configuration, group } = frame;
    this.#onScreen = { cameras, tracks, rung, configuration, group };
    this.#lookAround();
    const coded = new Set(frame.samples.map(({ track }) => track));
    const lost = frame.configuration.videos.filter(({ track }) => coded.has(track) && !frame.picture(track));
    const codecs = new Set(lost.map(({ codec }) => codec));
    if (codecs.size === this.#lost.length) return;
    this.#lost = [...codecs];
    if (this.#unsupported) this.dispatchEvent(new Event("optionschange"));
  }
  #takeWarning({ code }) {
    if (code !== "unsupported" || this.#unsupported) return;
    this.#unsupported = true;
    this.dispatchEvent(new Event("optionschange"));
  }
  /** Codecs of the frame on screen that this browser does not decode: "avc1", "hvc1", "vp09", "av01". */
  get unsupportedCodecs() {
    return this.#unsupported ? this.#lost : [];
  }

  /** A frame is on screen, and good enough to be seen. */
  #uncover() {
    this.#surface.classList.remove("covered");
    this.#poster.classList.add("gone");
  }

  #begin() {
    const kept = this.#keptPose;
    this.#keptPose = null;
    if (kept) {
      this.setPose(kept);
      this._chooseDrawing();
      return;
    }
    if (VIEW_ATTRIBUTES.some((name) => this.hasAttribute(name))) this._navigator.goTo(this._firstPose);
    this.#bookmarks.look();
    this._chooseDrawing();
    this.dispatchEvent(new Event("optionschange"));
  }

  /** The direction in which a finger on the picture scrolls the page, as in <model-viewer>. */
  get touchAction() {
    const action = this.getAttribute("touch-action");
    return TOUCH_ACTIONS.includes(action) ? action : TOUCH_ACTIONS[0];
  }
  set touchAction(action) {
    this.setAttribute("touch-action", action);
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

  /** Which controls are left out, as in <video>: "nodownload", "nofullscreen". */
  get controlsList() {
    return this.getAttribute("controlslist") ?? "";
  }
  set controlsList(names) {
    this.setAttribute("controlslist", names);
  }
  /** Whether the source is a file: not live, nor segments, nor bytes of the page. */
  get canDownload() {
    const source = this._source;
    if (source instanceof Blob) return true;
    return typeof source === "string" && !this.live && !new URL(source).pathname.endsWith(".json");
  }
  /** Offers the source to the user as a download. */
  download() {
    if (!this.canDownload) throw new DOMException("the source is not a file", "InvalidStateError");
    const source = this._source;
    const isBlob = source instanceof Blob;
    const href = isBlob ? URL.createObjectURL(source) : source;
    const name = isBlob ? source.name : decodeURIComponent(new URL(source).pathname.split("/").at(-1));
    // From another origin the browser decides by the type, and pages must not replace this one.
    element("a", { href, download: name || "clip.fvv", target: "_blank", rel: "noopener" }).click();
    if (isBlob) setTimeout(() => URL.revokeObjectURL(href), 60000);
  }

  get isFullscreen() {
    return this.ownerDocument.fullscreenElement === this;
  }
  toggleFullscreen() {
    const done = this.isFullscreen ? this.ownerDocument.exitFullscreen() : this.requestFullscreen?.();
    done?.catch(() => this.#interface.notify("Full screen is not allowed here"));
  }

  /** What the browser offers: "vr", "ar". */
  get immersiveModes() {
    return this.#immersive?.modes ?? [];
  }
  /** The current mode, or null. */
  get immersive() {
    return this.#immersive?.mode ?? null;
  }
  /** Begins a WebXR session. Has to be called by a listener of a click or a key. */
  async enterImmersive(mode) {
    if (!this._stage || !this.#immersive) throw new DOMException("the player is not in a page", "InvalidStateError");
    this.wasUsed = true;
    await this.#immersive.enter(mode, { stage: this._stage, player: this, overlay: this });
  }
  async exitImmersive() {
    await this.#immersive?.exit();
  }
  /** Where the scene is in the room, while it is immersive. */
  get placement() {
    return this.#immersive?.placement ?? null;
  }
  toggleImmersive(mode) {
    const done = this.immersive ? this.exitImmersive() : this.enterImmersive(mode);
    done.catch(({ message }) => this.#interface.notify(`This is not possible here: ${message}`));
  }

  /** Whether the stream has sound. */
  get hasSound() {
    return this.#sound.present;
  }
  /** The AudioContext that plays it; null: none yet. For meters, and for tests. */
  get audioContext() {
    return this.#sound.context;
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
    await this.#tools?.open?.putMarks(this.id || "fvv");
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
