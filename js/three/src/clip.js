// A clip in a scene: a stream that plays by itself, with the properties and events of media elements.

import { createDecoder } from "@fvv/decoder";
import { Media, MEDIA_EVENTS, Sound } from "@fvv/player/playback";

import { ClipAudio } from "./audio.js";
import { EnvironmentGroup } from "./environment.js";
import { FrameObject } from "./object.js";

/** Those after which sound may be another one. */
const AUDIBLE = ["playing", "pause", "seeking", "seeked", "waiting", "ratechange", "ended"];
/** Frames that are decoded ahead, beside the one that is shown and the one that waits. */
const QUEUE = 1;

/** FvvClip for any renderer: Surface is the class of its Drawing. */
export class ClipObject extends FrameObject {
  #renderer;
  #media;
  #sound;
  #audio;
  #environment = new EnvironmentGroup();
  #showsEnvironment;
  #src = null;
  #rung;
  #playedRung = null;
  #options;
  #volume = 1;
  #muted = false;
  #isAwaited = false; // a picture of the screen
  #ended = new AbortController();
  #first; // {promise, resolve, reject} of the first frame

  constructor(options, Surface) {
    const { src, loop, autoplay, volume, muted, rung, listener, environment, decoderOptions, ...drawn } = options;
    super(drawn, Surface);
    this.#renderer = drawn.renderer;
    this.#rung = rung ?? "auto";
    this.#options = decoderOptions ?? {};
    this.#showsEnvironment = environment ?? true;
    this.#audio = new ClipAudio(this, listener ?? null);
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.add(this.#environment);
    this.#sound = new Sound({
      motion: () => this.#media.motion,
      device: () => this.#audio.open(),
      changed: () => this.dispatchEvent({ type: "soundchange" }),
    });
    this.#media = new Media({
      now: () => this.#sound.now(),
      open: (source, isKnown) => this.#open(source, isKnown),
      show: (frame) => this.#present(frame),
      vacate: () => this.vacate(),
      wake: () => this.#wake(),
    });
    this.#listen();
    this.#media.loop = loop ?? false;
    this.#media.autoplay = autoplay ?? false;
    if (volume !== undefined) this.volume = volume;
    this.muted = muted ?? false;
    this.src = src ?? null;
  }

  #listen() {
    const { signal } = this.#ended;
    for (const type of MEDIA_EVENTS)
      this.#media.addEventListener(type, () => {
        if (AUDIBLE.includes(type)) this.#sound.update();
        if (type === "error") this.#first.reject(this.#media.error.cause);
        const isError = type === "error" && this.#media.error;
        this.dispatchEvent(isError ? { type, error: this.#media.error.cause } : { type });
      });
    this.#media.addEventListener("frame", () => {
      this.#audio.settle();
      this.#first.resolve(this);
      this.dispatchEvent({ type: "framechange" });
    });
    // What cannot be seen is not decoded.
    const attend = () => {
      this.#media.suspended = document.hidden;
      this.#sound.update();
    };
    document.addEventListener("visibilitychange", attend, { signal });
    for (const type of ["sessionstart", "sessionend"]) {
      const restart = () => {
        this.#isAwaited = false;
        this.#wake();
      };
      this.#renderer.xr?.addEventListener?.(type, restart);
      signal.addEventListener("abort", () => this.#renderer.xr?.removeEventListener?.(type, restart));
    }
  }

  async #open(source, isKnown) {
    const live = typeof source === "string" && /^wss?:/.test(source);
    const decoder = await createDecoder({
      video: "decoded",
      sound: "decoded",
      rung: this.#rung,
      ...this.#options,
      ...(isKnown && { network: { ...this.#options.network, openBudgetMs: Number.MAX_SAFE_INTEGER } }),
      source: live ? { url: source, reconnect: true } : source,
      normals: true,
      queue: QUEUE,
    });
    this.#sound.follow(decoder);
    decoder.addEventListener("environment", ({ detail }) => this.#showsEnvironment && this.#environment.show(detail));
    decoder.addEventListener("rung", ({ detail }) => {
      this.#playedRung = detail.rung;
      this.dispatchEvent({ type: "rungchange", rung: detail });
    });
    decoder.addEventListener("warning", ({ detail }) => this.dispatchEvent({ type: "warning", error: detail }));
    return decoder;
  }

  async #present(frame) {
    if (!this.#ended.signal.aborted) await this.show(frame);
  }

  /** Requests a tick with the next picture of the screen, or of the headset. */
  #wake() {
    if (this.#isAwaited || this.#ended.signal.aborted) return;
    this.#isAwaited = true;
    const session = this.#renderer.xr?.isPresenting ? this.#renderer.xr.getSession?.() : null;
    (session ?? globalThis).requestAnimationFrame(() => {
      this.#isAwaited = false;
      this.#audio.move();
      if (this.#media.tick()) this.#wake();
    });
  }

  viewedBy(camera) {
    this.#audio.follow(camera);
  }

  /** As createDecoder takes a source, or null. */
  get src() {
    return this.#src;
  }
  set src(src) {
    this.#first?.reject(new DOMException("another source was set", "AbortError"));
    this.#first = Promise.withResolvers();
    // The event "error" has the reason as well.
    this.#first.promise.catch(() => {});
    this.#src = src;
    this.#playedRung = null;
    this.#media.reset();
    this.#sound.reset();
    this.#audio.close();
    this.#environment.show([]);
    this.#media.load(src, { live: typeof src === "string" && /^wss?:/.test(src) });
  }

  /** Resolves to the clip when its first frame is shown. */
  get ready() {
    return this.#first.promise;
  }

  play() {
    return this.#media.play();
  }
  pause() {
    this.#media.pause();
  }
  /** Resolves when the frame of that time is shown; rejects when an error, another source or dispose() comes first. */
  seek(seconds) {
    this.#media.currentTime = seconds;
    if (!this.#media.seeking) return Promise.resolve();
    const done = new Promise((resolve, reject) => {
      const settled = new AbortController();
      const outcomes = {
        seeked: resolve,
        error: () => reject(this.#media.error.cause),
        emptied: () => reject(new DOMException("the source was taken away", "AbortError")),
      };
      for (const [type, settle] of Object.entries(outcomes)) {
        const listener = (event) => {
          settled.abort();
          settle(event);
        };
        this.#media.addEventListener(type, listener, { signal: settled.signal });
      }
    });
    // As with play(), a rejection is not an error if the caller ignores the promise.
    done.catch(() => {});
    return done;
  }
  /** Pauses, and shows the frame count frames further on. */
  step(count = 1) {
    return this.#media.step(count);
  }

  get currentTime() {
    return this.#media.currentTime;
  }
  set currentTime(seconds) {
    this.#media.currentTime = seconds;
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
  get error() {
    return this.#media.error;
  }
  get loop() {
    return this.#media.loop;
  }
  set loop(loop) {
    this.#media.loop = loop;
  }
  get autoplay() {
    return this.#media.autoplay;
  }
  set autoplay(autoplay) {
    this.#media.autoplay = autoplay;
  }
  get playbackRate() {
    return this.#media.playbackRate;
  }
  set playbackRate(rate) {
    this.#media.playbackRate = rate;
  }

  /** 0 to 1. */
  get volume() {
    return this.#volume;
  }
  set volume(volume) {
    if (!(volume >= 0 && volume <= 1)) throw new RangeError(`volume: expected 0 to 1, found ${volume}`);
    this.#volume = this.#sound.volume = volume;
    this.dispatchEvent({ type: "volumechange" });
  }
  get muted() {
    return this.#muted;
  }
  set muted(muted) {
    this.#muted = this.#sound.muted = Boolean(muted);
    this.dispatchEvent({ type: "volumechange" });
  }
  get hasSound() {
    return this.#sound.present;
  }
  /** The PositionalAudio objects of the tracks that are heard. */
  get audio() {
    return this.#audio.sources;
  }

  /** Rungs of the stream's ladder, best first; one or none without a ladder. */
  get rungs() {
    return this.#media.decoder?.rungs ?? [];
  }
  get playedRung() {
    return this.rungs.length > 1 ? this.#playedRung : null;
  }
  /** "auto", or the number of a rung. */
  get rung() {
    return this.#rung;
  }
  set rung(rung) {
    this.#rung = rung;
    this.#media.decoder?.setRung(rung).then(
      () => this.#media.improve(),
      () => {},
    );
  }

  /** A Group of three with the static environment. */
  get environment() {
    return this.#environment;
  }

  dispose() {
    if (this.#ended.signal.aborted) return;
    this.#ended.abort();
    this.#first.reject(new DOMException("the clip was disposed of", "AbortError"));
    this.#media.load(null);
    this.#sound.close();
    this.#audio.close();
    this.#environment.dispose();
    super.dispose();
  }
}
