// The part of the element with the interface of HTMLMediaElement: attributes, properties, events.

import { Media, MEDIA_EVENTS, NETWORK, READY } from "./playback/media.js";
import { groupAt, Ranges } from "./playback/ranges.js";

/** Environments without a document, such as servers that import the package, have no HTMLElement. */
const Base = globalThis.HTMLElement ?? class {};

export class MediaElement extends Base {
  #media;
  #source = null; // srcObject
  #muted = false;
  #volume = 1;
  #defaultPlaybackRate = 1;

  static NETWORK_EMPTY = NETWORK.EMPTY;
  static NETWORK_IDLE = NETWORK.IDLE;
  static NETWORK_LOADING = NETWORK.LOADING;
  static NETWORK_NO_SOURCE = NETWORK.NO_SOURCE;
  static HAVE_NOTHING = READY.NOTHING;
  static HAVE_METADATA = READY.METADATA;
  static HAVE_CURRENT_DATA = READY.CURRENT_DATA;
  static HAVE_FUTURE_DATA = READY.FUTURE_DATA;
  static HAVE_ENOUGH_DATA = READY.ENOUGH_DATA;

  /** open, show, wake: as Media takes them. */
  _makeMedia(parts) {
    const media = new Media(parts);
    this.#media = media;
    for (const type of MEDIA_EVENTS)
      media.addEventListener(type, () => {
        const isError = type === "error" && media.error;
        this.dispatchEvent(isError ? new CustomEvent(type, { detail: media.error.cause }) : new Event(type));
        // Updates buffered times and rates.
        if (type === "timeupdate" || type === "canplay") media.measure();
      });
    media.addEventListener("frame", () => this.dispatchEvent(new Event("framechange")));
    media.loop = this.hasAttribute("loop");
    media.autoplay = this.hasAttribute("autoplay");
    this.#muted = this.hasAttribute("muted");
    return media;
  }

  get src() {
    const src = this.getAttribute("src");
    return src ? new URL(src, this.baseURI).href : "";
  }
  set src(src) {
    this.setAttribute("src", src);
  }
  /** Any source of a decoder: a Blob, bytes, a stream, {url, headers}. Takes precedence over src. */
  get srcObject() {
    return this.#source;
  }
  set srcObject(source) {
    this.#source = source ?? null;
    this.load();
  }
  get currentSrc() {
    const source = this.#source ?? this.src;
    return typeof source === "string" ? source : String(source?.url ?? "");
  }
  /** The source for createDecoder, or null. */
  get _source() {
    return this.#source ?? (this.src || null);
  }

  play() {
    return this.#media.play();
  }
  pause() {
    this.#media.pause();
  }
  /** Pauses, and shows the frame count frames further on. Returns false if that is impossible. */
  step(count = 1) {
    return this.#media.step(count);
  }
  canPlayType(type) {
    return /^model\/vnd\.fvv\s*(;|$)/i.test(type) ? "maybe" : "";
  }

  get currentTime() {
    return this.#media.currentTime;
  }
  set currentTime(seconds) {
    this.#media.currentTime = seconds;
  }
  fastSeek(seconds) {
    this.currentTime = seconds;
  }
  get currentFrame() {
    return this.#media.currentFrame;
  }
  set currentFrame(number) {
    this.#media.currentFrame = number;
  }
  get frameCount() {
    return this.#media.frameCount;
  }
  /** Groups of frames, as far as known: {start, end} in seconds, and the number of the first frame. */
  get groups() {
    return this.#media.groups;
  }
  /** The number of the frame at a time; null: not known. */
  frameAt(seconds) {
    const { groups, frame, frameCount } = this.#media;
    const group = groups[groupAt(groups, seconds)];
    if (!group || !frame?.duration) return null;
    const number = group.firstFrame + Math.floor((seconds - group.start) / frame.duration + 1e-6);
    return Math.min(Math.max(number, 0), frameCount - 1);
  }
  get duration() {
    return this.#media.duration;
  }
  get paused() {
    return this.#media.paused;
  }
  get ended() {
    return this.#media.ended;
  }
  get seeking() {
    return this.#media.seeking;
  }
  get readyState() {
    return this.#media.readyState;
  }
  get networkState() {
    return this.#media.networkState;
  }
  get error() {
    return this.#media.error;
  }
  get seekable() {
    return this.#media?.seekable ?? new Ranges();
  }
  get buffered() {
    return this.#media?.buffered ?? new Ranges();
  }
  get playbackRate() {
    return this.#media.playbackRate;
  }
  set playbackRate(rate) {
    this.#media.playbackRate = rate;
  }
  get defaultPlaybackRate() {
    return this.#defaultPlaybackRate;
  }
  set defaultPlaybackRate(rate) {
    this.#defaultPlaybackRate = rate;
    this.dispatchEvent(new Event("ratechange"));
  }
  /** {from, to} in seconds, or null. */
  get loopRange() {
    return this.#media.loopRange;
  }
  set loopRange(range) {
    this.#media.loopRange = range;
    this.dispatchEvent(new Event("optionschange"));
  }

  get autoplay() {
    return this.hasAttribute("autoplay");
  }
  set autoplay(autoplay) {
    this.toggleAttribute("autoplay", autoplay);
  }
  get loop() {
    return this.hasAttribute("loop");
  }
  set loop(loop) {
    this.toggleAttribute("loop", loop);
  }
  get controls() {
    return this.hasAttribute("controls");
  }
  set controls(controls) {
    this.toggleAttribute("controls", controls);
  }
  get poster() {
    return this.getAttribute("poster") ?? "";
  }
  set poster(poster) {
    this.setAttribute("poster", poster);
  }
  get muted() {
    return this.#muted;
  }
  set muted(muted) {
    if (this.#muted === Boolean(muted)) return;
    this.#muted = Boolean(muted);
    this.dispatchEvent(new Event("volumechange"));
  }
  /** 0 to 1. */
  get volume() {
    return this.#volume;
  }
  set volume(volume) {
    if (!Number.isFinite(volume)) throw new TypeError(`volume: expected a number, found ${volume}`);
    if (volume < 0 || volume > 1) throw new DOMException(`volume: expected 0 to 1, found ${volume}`, "IndexSizeError");
    if (volume === this.#volume) return;
    this.#volume = volume;
    this.dispatchEvent(new Event("volumechange"));
  }
  get defaultMuted() {
    return this.hasAttribute("muted");
  }
  set defaultMuted(muted) {
    this.toggleAttribute("muted", muted);
  }

  /** ws: and wss: are live; for other URLs the attribute decides. */
  get live() {
    return this.hasAttribute("live") || /^wss?:/.test(this.currentSrc);
  }
  goLive() {
    this.#media.goLive();
  }
  get liveCatchUp() {
    return this.#media.liveCatchUp;
  }
  set liveCatchUp(given) {
    this.#media.liveCatchUp = given;
  }
  /** Seconds behind the live edge. */
  get liveLatency() {
    return this.#media.behind;
  }
}
