// HTMLMediaElement without a document: attributes, states, promises and events in the order of the HTML standard.

import { Meter } from "./meter.js";
import { Playout } from "./playout.js";
import { Ranges } from "./ranges.js";
import { LIVE } from "./timing.js";

export const NETWORK = { EMPTY: 0, IDLE: 1, LOADING: 2, NO_SOURCE: 3 };
export const READY = { NOTHING: 0, METADATA: 1, CURRENT_DATA: 2, FUTURE_DATA: 3, ENOUGH_DATA: 4 };
/** What Media announces, beside "frame". */
export const MEDIA_EVENTS = (
  "abort canplay canplaythrough durationchange emptied ended error loadeddata loadedmetadata loadstart pause play playing " +
  "progress ratechange seeked seeking stalled suspend timeupdate waiting"
).split(" ");
const ERROR = { NETWORK: 2, DECODE: 3, SOURCE_NOT_SUPPORTED: 4 };
const NETWORK_CODES = ["io", "changed", "reconnect", "truncated"];

/** The state without a source. */
const INITIAL_STATE = {
  readyState: READY.NOTHING,
  networkState: NETWORK.EMPTY,
  error: null,
  duration: NaN,
  frame: null,
  seeking: false,
  atEnd: false,
};

/** Like MediaError. cause: FvvError or another Error. playable: part of the source could be played. */
function mediaError(cause, playable) {
  const code = !playable
    ? ERROR.SOURCE_NOT_SUPPORTED
    : NETWORK_CODES.includes(cause.code)
      ? ERROR.NETWORK
      : ERROR.DECODE;
  return Object.freeze({ code, message: cause.message, cause });
}

/** Dispatches events like media elements do, after the current code has run; forget cancels them. */
class DelayedEvents extends EventTarget {
  #turn = 0;

  announce(...types) {
    const turn = this.#turn;
    queueMicrotask(() => {
      if (turn === this.#turn) for (const type of types) this.dispatchEvent(new Event(type));
    });
  }
  /** Cancels events that have not been dispatched yet. */
  forget() {
    this.#turn++;
  }
}

/** The promises of play() that are not settled yet. */
class PendingPlays {
  #pending = [];

  add() {
    const promise = new Promise((resolve, reject) => this.#pending.push({ resolve, reject }));
    // A rejection is not an error if the caller ignores the promise.
    promise.catch(() => {});
    return promise;
  }
  resolveAll() {
    for (const { resolve } of this.#pending.splice(0)) resolve();
  }
  rejectAll(name, message) {
    for (const { reject } of this.#pending.splice(0)) reject(new DOMException(message, name));
  }
}

const STALLED_MS = 3000;

/** Calls back if awaited data has not arrived for a while. */
class StallWatch {
  #stalled;
  #timer = null;

  constructor(stalled) {
    this.#stalled = stalled;
  }
  /** Data has arrived, or is awaited from now on. */
  begin() {
    this.end();
    this.#timer = setTimeout(this.#stalled, STALLED_MS);
    this.#timer.unref?.();
  }
  end() {
    clearTimeout(this.#timer);
  }
}

/** A screen that shows at once what is drawn. */
const INSTANT = { delay: 0, refresh: 8 };

const TIME_UPDATE_MS = 250;
const MAX_RATE = 16;

export class Media extends DelayedEvents {
  #open;
  #show;
  #vacate;
  #now;
  #wake;
  #screen;
  #source = null;
  #playout = null;
  #plays = new PendingPlays();
  #rate = 1;
  #loop = false;
  #range = null;
  #suspended = false;
  #startAt = null;
  #autoplaying = true;
  #initial = true; // there is nothing to reset
  #updated = -Infinity;
  #stallWatch = new StallWatch(() => this.#stall());
  #sawData = false;
  #opening = null;
  #reopened = false;
  #liveCatchUp = LIVE;
  paused = true;
  autoplay = false;
  live = false;
  meter = new Meter();

  /**
   * open(source): resolves to a decoder. show(frame): resolves when the frame may be closed. vacate(): empties the stage.
   * wake(): requests a tick. now(): milliseconds. screen(): {delay, refresh}, milliseconds from show to the screen and
   * between its pictures.
   */
  constructor({
    open,
    show,
    vacate = () => {},
    wake = () => {},
    now = () => performance.now(),
    screen = () => INSTANT,
  }) {
    super();
    Object.assign(this, INITIAL_STATE);
    this.#open = open;
    this.#show = show;
    this.#vacate = vacate;
    this.#wake = wake;
    this.#now = now;
    this.#screen = screen;
  }

  /** The synchronous part of load: later calls, including play(), apply to the next source. */
  reset() {
    this.forget();
    const former = this.networkState;
    this.#release();
    if (former === NETWORK.LOADING || former === NETWORK.IDLE) this.announce("abort");
    if (former !== NETWORK.EMPTY) {
      this.announce("emptied");
      this.paused = true;
      this.#range = null;
    }
    this.#plays.rejectAll("AbortError", "another source was set");
    Object.assign(this, INITIAL_STATE);
    this.#startAt = null;
    this.#autoplaying = this.#initial = true;
    this.#reopened = this.#sawData = false;
  }

  /** source: as createDecoder takes it, or null. at: first position, {seconds} or {frame}. */
  load(source, { live = false, at = null } = {}) {
    if (!this.#initial) this.reset();
    this.#initial = false;
    this.live = live;
    this.#source = source;
    // A position that was set after reset stays.
    if (at) this.#startAt = at;
    if (source === null || source === undefined) return;
    this.networkState = NETWORK.LOADING;
    this.announce("loadstart");
    this.#begin();
  }

  async #begin() {
    const opening = (this.#opening = Symbol());
    const began = this.#now();
    let decoder;
    try {
      decoder = await this.#open(this.#source, this.#reopened);
    } catch (error) {
      if (opening === this.#opening) this.fail(error);
      return;
    }
    if (opening !== this.#opening) return decoder.close();
    this.meter.begin();
    const playout = new Playout({
      decoder,
      show: this.#show,
      vacate: this.#vacate,
      now: this.#now,
      screen: this.#screen,
      meter: this.meter,
      live: this.live,
      began,
      host: {
        metadata: (frame) => this.#learn(frame),
        duration: () => this.#changeDuration(),
        ready: (state) => this.readyState >= READY.METADATA && this.#setReady(state),
        shown: (shown) => this.#shown(shown),
        seeking: () => this.#beginSeek(),
        sought: () => this.#endSeek(),
        plays: () => !this.paused || (this.autoplay && this.#autoplaying),
        liveCatchUp: () => this.liveCatchUp,
        behind: (seconds) => seconds > this.liveCatchUp.jumpAfter && this.goLive(),
        drained: () => this.#drain(),
        ended: () => this.#end(),
        failed: (error) => this.fail(error),
        wake: () => this.#wake(),
      },
    });
    this.#playout = playout;
    Object.assign(playout, { loop: this.#loop, range: this.#range, rate: this.#rate });
    this.#stallWatch.begin();
    const at = this.#startAt;
    this.#startAt = null;
    if (at && decoder.seekable) playout.seek(this.#place(at), at.seconds ?? 0);
    else playout.begin();
    this.#updateRunning();
  }

  #place({ seconds, frame }) {
    if (frame === undefined) return { seconds: Math.max(seconds, 0) };
    return { frame: Math.min(Math.max(Math.round(frame), 0), (this.decoder.frameCount ?? Infinity) - 1) };
  }

  #release() {
    this.#opening = null;
    this.#playout?.close();
    this.#playout = null;
    this.#stallWatch.end();
  }

  /** Playback cannot continue. */
  fail(error) {
    const playable = this.readyState !== READY.NOTHING;
    this.error = mediaError(error, playable);
    this.networkState = playable ? NETWORK.IDLE : NETWORK.NO_SOURCE;
    this.seeking = false;
    this.#release();
    this.#plays.rejectAll("NotSupportedError", error.message);
    this.announce("error");
  }

  #learn(frame) {
    this.#stallWatch.begin();
    if (this.readyState >= READY.METADATA) return;
    this.duration = this.#playout.end;
    this.frame = { number: frame.number, seconds: frame.seconds, duration: frame.duration };
    this.announce("durationchange");
    this.#setReady(READY.METADATA);
    if (this.seeking) this.announce("seeking");
  }

  #changeDuration() {
    if (this.readyState < READY.METADATA || this.duration === this.#playout.end) return;
    this.duration = this.#playout.end;
    this.announce("durationchange");
  }

  #shown(shown) {
    this.frame = shown;
    this.#stallWatch.begin();
    if (this.readyState < READY.CURRENT_DATA && !this.seeking) this.#setReady(READY.CURRENT_DATA);
    if (this.#reopened) this.#endSeek();
    this.#reopened = false;
    this.dispatchEvent(new Event("frame"));
  }

  #setReady(state) {
    const former = this.readyState;
    if (state === former) return;
    this.readyState = state;
    if (former === READY.NOTHING) this.announce("loadedmetadata");
    if (state >= READY.CURRENT_DATA && !this.#sawData) {
      this.#sawData = true;
      this.announce("loadeddata");
    }
    if (former >= READY.FUTURE_DATA && state <= READY.CURRENT_DATA && !this.paused && !this.atEnd)
      this.announce("timeupdate", "waiting");
    if (former <= READY.CURRENT_DATA && state >= READY.FUTURE_DATA) {
      this.announce("canplay");
      if (!this.paused) this.#notifyPlaying();
      this.announce("canplaythrough");
      if (this.autoplay && this.#autoplaying && this.paused) this.#startPlaying();
    }
  }

  #notifyPlaying() {
    this.announce("playing");
    queueMicrotask(() => !this.paused && this.#plays.resolveAll());
  }

  get ended() {
    return this.atEnd && !this.#loop;
  }
  get running() {
    return !this.paused && !this.ended && !this.#suspended && this.#playout !== null;
  }
  #updateRunning() {
    if (this.#playout) Object.assign(this.#playout, { watched: !this.#suspended, running: this.running });
    if (this.running) this.#wake();
  }

  play() {
    if (this.networkState === NETWORK.NO_SOURCE)
      return Promise.reject(new DOMException(this.error.message, "NotSupportedError"));
    const promise = this.#plays.add();
    if (this.atEnd) this.#rewind();
    if (this.paused) this.#startPlaying();
    else if (this.readyState >= READY.FUTURE_DATA) this.#notifyPlaying();
    this.#autoplaying = false;
    return promise;
  }
  #startPlaying() {
    this.paused = false;
    this.#autoplaying = false;
    this.announce("play");
    if (this.readyState >= READY.FUTURE_DATA) this.#notifyPlaying();
    else this.announce("waiting");
    this.#updateRunning();
  }
  #rewind() {
    if (this.#playout?.decoder.seekable) this.currentTime = this.seekable.start(0);
    else this.#reopen();
  }

  pause() {
    this.#autoplaying = false;
    if (this.paused) return;
    this.paused = true;
    this.announce("timeupdate", "pause");
    this.#plays.rejectAll("AbortError", "pause was called");
    this.#updateRunning();
  }

  /** While the page is hidden nothing is decoded, and time stands still. */
  set suspended(suspended) {
    this.#suspended = suspended;
    this.#updateRunning();
  }

  #end() {
    this.atEnd = true;
    if (this.#loop) return this.#rewind();
    this.announce("timeupdate");
    if (!this.paused) {
      this.paused = true;
      this.announce("pause");
      this.#plays.rejectAll("AbortError", "the end was reached");
    }
    this.announce("ended");
    this.#updateRunning();
  }

  /** All of the stream has been read. */
  #drain() {
    if (this.networkState !== NETWORK.LOADING) return;
    this.networkState = NETWORK.IDLE;
    this.announce("suspend");
  }

  /** Opens a source without seeking again: from its beginning, or at the live edge. */
  #reopen() {
    this.#release();
    this.#reopened = true;
    this.#beginSeek();
    this.#begin();
  }

  #beginSeek() {
    this.atEnd = false;
    this.seeking = true;
    this.networkState = NETWORK.LOADING;
    // Before metadata is available, the event is dispatched later.
    if (this.readyState >= READY.METADATA) this.announce("seeking");
  }
  #endSeek() {
    this.seeking = false;
    this.announce("timeupdate", "seeked");
    this.#updateRunning();
  }
  get currentTime() {
    return this.#playout ? this.#playout.position : (this.#startAt?.seconds ?? 0);
  }
  set currentTime(seconds) {
    if (!Number.isFinite(seconds)) throw new TypeError(`currentTime: expected a number of seconds, found ${seconds}`);
    if (this.readyState === READY.NOTHING) {
      this.#startAt = { seconds };
      return;
    }
    this.#seek({ seconds: Math.min(Math.max(seconds, this.#playout.start), this.#playout.end) });
  }
  /** Number of the frame on screen; setting it seeks. */
  get currentFrame() {
    return this.frame?.number ?? 0;
  }
  set currentFrame(number) {
    if (this.readyState === READY.NOTHING) this.#startAt = { frame: number };
    else this.#seek({ frame: number });
  }
  #seek(place) {
    const playout = this.#playout;
    if (!playout?.decoder.seekable) return;
    const { start, shown } = playout;
    const at = this.#place(place);
    playout.seek(at, at.seconds ?? start + at.frame * (shown?.duration ?? 0));
  }
  /** Another rung is wanted: a frame that stays on screen is shown in it at once. */
  improve() {
    this.#playout?.improve();
  }
  /** The viewer acts: a first frame that is covered is seen as it is. */
  uncover() {
    this.#playout?.uncover();
  }
  /** Other tracks were selected: frames that are decoded already lack them. */
  refetch() {
    this.#playout?.refetch();
  }
  /** Pauses, and shows the frame count frames further on. */
  step(count) {
    this.pause();
    return this.#playout?.step(count) ?? false;
  }

  get playbackRate() {
    return this.#rate;
  }
  set playbackRate(rate) {
    if (rate === this.#rate) return;
    if (!(rate >= 0 && rate <= MAX_RATE))
      throw new DOMException(`playbackRate: expected 0 to ${MAX_RATE}, found ${rate}`, "NotSupportedError");
    this.#rate = rate;
    if (this.#playout) this.#playout.rate = rate;
    this.announce("ratechange");
  }
  get loop() {
    return this.#loop;
  }
  set loop(loop) {
    this.#loop = loop;
    this.#changeLoop();
  }
  /** {from, to} in seconds: the range that is played in a loop, or null. */
  get loopRange() {
    return this.#range;
  }
  set loopRange(range) {
    if (range && !(range.to > range.from)) throw new RangeError("loopRange: expected to > from");
    this.#range = range && { from: range.from, to: range.to };
    this.#changeLoop();
  }
  #changeLoop() {
    if (!this.#playout) return;
    Object.assign(this.#playout, { loop: this.#loop, range: this.#range });
    this.#playout.unwrap();
  }

  /** Moves to the live edge by another connection, which begins with the latest group. */
  goLive() {
    if (!this.live || this.#reopened || this.readyState === READY.NOTHING) return;
    this.#reopen();
    if (this.paused) this.play();
  }
  /** {delay, maxRate, jumpAfter}: see LIVE. What is not given has its default. */
  get liveCatchUp() {
    return this.#liveCatchUp;
  }
  set liveCatchUp(given) {
    const found = { ...LIVE, ...given };
    const unknown = Object.keys(found).find((name) => !(name in LIVE));
    if (unknown) throw new TypeError(`liveCatchUp: expected ${Object.keys(LIVE).join(", ")}, found ${unknown}`);
    const { delay, maxRate, jumpAfter } = found;
    if (!(delay >= 0 && jumpAfter > delay && maxRate >= 1 && maxRate <= MAX_RATE))
      throw new RangeError(`liveCatchUp: expected 0 <= delay < jumpAfter and maxRate from 1 to ${MAX_RATE}`);
    this.#liveCatchUp = Object.freeze(found);
  }
  /** Seconds behind the live edge. */
  get behind() {
    return this.#playout?.behind ?? 0;
  }

  /** How playback proceeds at now(): {running, position, rate}. */
  get motion() {
    return this.#playout?.motion ?? { running: false, position: 0, rate: 1 };
  }
  get frameCount() {
    return this.#playout?.decoder.frameCount ?? 0;
  }
  get groups() {
    return this.#playout?.groups ?? [];
  }
  get decoder() {
    return this.#playout?.decoder ?? null;
  }
  get openFrames() {
    return this.#playout?.openFrames ?? 0;
  }
  get seekable() {
    return new Ranges(this.#playout?.seekable);
  }
  get buffered() {
    return new Ranges(this.#playout?.buffered);
  }

  /** Called for each picture of the screen. Returns whether another tick is needed. */
  tick() {
    if (!this.running) return false;
    this.#playout.tick();
    if (!this.running) return false;
    const now = this.#now();
    if (now - this.#updated >= TIME_UPDATE_MS && !this.seeking) {
      this.#updated = now;
      this.dispatchEvent(new Event("timeupdate"));
    }
    return true;
  }

  /** Updates statistics and buffered times from the decoder. */
  async measure() {
    const { decoder } = this;
    const [stats, cached] = (await Promise.all([decoder?.stats(), decoder?.buffered()]).catch(() => null)) ?? [];
    if (!stats || decoder !== this.decoder) return;
    this.#playout.cachedTimes = cached;
    if (this.meter.decoder(this.#now(), stats)) this.announce("progress");
  }

  #stall() {
    if (this.readyState < READY.FUTURE_DATA && this.networkState === NETWORK.LOADING) this.announce("stalled");
  }
}
