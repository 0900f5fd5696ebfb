// HTMLMediaElement without a document: attributes, states, promises and events in the order of the HTML standard.

import { Meter } from "./meter.js";
import { Playout } from "./playout.js";
import { Ranges } from "./ranges.js";

export const NETWORK = { EMPTY: 0, IDLE: 1, LOADING: 2, NO_SOURCE: 3 };
export const READY = { NOTHING: 0, METADATA: 1, CURRENT_DATA: 2, FUTURE_DATA: 3, ENOUGH_DATA: 4 };
const ERROR = { NETWORK: 2, DECODE: 3, SOURCE_NOT_SUPPORTED: 4 };
const NETWORK_CODES = ["io", "changed", "reconnect", "truncated"];

/** What a media element is before it has a source. */
const NOTHING_YET = {
  readyState: READY.NOTHING,
  networkState: NETWORK.EMPTY,
  error: null,
  duration: NaN,
  frame: null,
  seeking: false,
  atEnd: false,
};

/** As MediaError. cause: FvvError, or what else was thrown. playable: something of the source was. */
function mediaError(cause, playable) {
  const code = !playable
    ? ERROR.SOURCE_NOT_SUPPORTED
    : NETWORK_CODES.includes(cause.code)
      ? ERROR.NETWORK
      : ERROR.DECODE;
  return Object.freeze({ code, message: cause.message, cause });
}

class Announcer extends EventTarget {
  #turn = 0;

  announce(...types) {
    const turn = this.#turn;
    queueMicrotask(() => {
      if (turn === this.#turn) for (const type of types) this.dispatchEvent(new Event(type));
    });
  }
  /** What has not been told yet is not told. */
  forget() {
    this.#turn++;
  }
}

class PendingPlays {
  #pending = [];

  add() {
    const promise = new Promise((resolve, reject) => this.#pending.push({ resolve, reject }));
    // Nobody has to wait for it.
    promise.catch(() => {});
    return promise;
  }
  keep() {
    for (const { resolve } of this.#pending.splice(0)) resolve();
  }
  break(name, message) {
    for (const { reject } of this.#pending.splice(0)) reject(new DOMException(message, name));
  }
}

const STALLED_MS = 3000;

class StallWatch {
  #stalled;
  #timer = null;

  constructor(stalled) {
    this.#stalled = stalled;
  }
  /** Something has come, or is waited for from now on. */
  begin() {
    this.end();
    this.#timer = setTimeout(this.#stalled, STALLED_MS);
    this.#timer.unref?.();
  }
  end() {
    clearTimeout(this.#timer);
  }
}

const TIME_UPDATE_MS = 250;
const FASTEST = 16;

export class Media extends Announcer {
  #open;
  #show;
  #now;
  #wake;
  #source = null;
  #playout = null;
  #plays = new PendingPlays();
  #rate = 1;
  #loop = false;
  #range = null;
  #suspended = false;
  #startAt = null;
  #autoplaying = true;
  #blank = true; // nothing is to be reset
  #updated = -Infinity;
  #stallWatch = new StallWatch(() => this.#stall());
  #sawData = false;
  #opening = null;
  #reopened = false;
  paused = true;
  autoplay = false;
  live = false;
  leapSeconds = 5; // behind the live edge
  meter = new Meter();

  /** open(source): a decoder. show(frame): when it may be closed. wake(): tick is wanted. now(): milliseconds. */
  constructor({ open, show, wake = () => {}, now = () => performance.now() }) {
    super();
    Object.assign(this, NOTHING_YET);
    this.#open = open;
    this.#show = show;
    this.#wake = wake;
    this.#now = now;
  }

  /** What load does at once: what is asked for from here on is asked of the next source, play() too. */
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
    this.#plays.break("AbortError", "another source was set");
    Object.assign(this, NOTHING_YET);
    this.#autoplaying = this.#blank = true;
    this.#reopened = this.#sawData = false;
  }

  /** source: as createDecoder takes it, or null. at: {seconds} or {frame} to begin with. */
  load(source, { live = false, at = null } = {}) {
    if (!this.#blank) this.reset();
    this.#blank = false;
    this.live = live;
    this.#source = source;
    this.#startAt = at;
    if (source === null || source === undefined) return;
    this.networkState = NETWORK.LOADING;
    this.announce("loadstart");
    this.#begin();
  }

  async #begin() {
    const opening = (this.#opening = Symbol());
    let decoder;
    try {
      decoder = await this.#open(this.#source);
    } catch (error) {
      if (opening === this.#opening) this.fail(error);
      return;
    }
    if (opening !== this.#opening) return decoder.close();
    this.meter.begin();
    const playout = new Playout({
      decoder,
      show: this.#show,
      now: this.#now,
      meter: this.meter,
      live: this.live,
      host: {
        metadata: (frame) => this.#learn(frame),
        duration: () => this.#changeDuration(),
        ready: (state) => this.readyState >= READY.METADATA && this.#setReady(state),
        shown: (shown) => this.#shown(shown),
        seeking: () => this.#beginSeek(),
        sought: () => this.#endSeek(),
        behind: (seconds) => seconds > this.leapSeconds && this.goLive(),
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
    this.#run();
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

  /** Nothing can be shown any more. */
  fail(error) {
    const playable = this.readyState !== READY.NOTHING;
    this.error = mediaError(error, playable);
    this.networkState = playable ? NETWORK.IDLE : NETWORK.NO_SOURCE;
    this.seeking = false;
    this.#release();
    this.#plays.break("NotSupportedError", error.message);
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
    queueMicrotask(() => !this.paused && this.#plays.keep());
  }

  get ended() {
    return this.atEnd && !this.#loop;
  }
  get running() {
    return !this.paused && !this.ended && !this.#suspended && this.#playout !== null;
  }
  #run() {
    if (this.#playout) this.#playout.running = this.running;
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
    this.#run();
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
    this.#plays.break("AbortError", "pause was called");
    this.#run();
  }

  /** Nobody sees it: nothing is decoded, and time stands still. */
  set suspended(suspended) {
    this.#suspended = suspended;
    this.#run();
  }

  #end() {
    this.atEnd = true;
    if (this.#loop) return this.#rewind();
    this.announce("timeupdate");
    if (!this.paused) {
      this.paused = true;
      this.announce("pause");
      this.#plays.break("AbortError", "the end was reached");
    }
    this.announce("ended");
    this.#run();
  }

  /** All of the stream has been read. */
  #drain() {
    if (this.networkState !== NETWORK.LOADING) return;
    this.networkState = NETWORK.IDLE;
    this.announce("suspend");
  }

  /** A source that can't be sought in, from its beginning, or from where it is live. */
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
    // A place that was asked for before there was anything: told when there is.
    if (this.readyState >= READY.METADATA) this.announce("seeking");
  }
  #endSeek() {
    this.seeking = false;
    this.announce("timeupdate", "seeked");
    this.#run();
  }
  get currentTime() {
    return this.#playout ? this.#playout.position : (this.#startAt?.seconds ?? 0);
  }
  set currentTime(seconds) {
    if (!Number.isFinite(seconds)) throw new TypeError(`${seconds} is no time`);
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
  /** Shows the frame so many further on, paused. */
  step(count) {
    this.pause();
    return this.#playout?.step(count) ?? false;
  }

  get playbackRate() {
    return this.#rate;
  }
  set playbackRate(rate) {
    if (rate === this.#rate) return;
    if (!(rate >= 0 && rate <= FASTEST))
      throw new DOMException(`${rate} is no rate from 0 to ${FASTEST}`, "NotSupportedError");
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
  /** {from, to} in seconds between which it plays again and again, or null. */
  get loopRange() {
    return this.#range;
  }
  set loopRange(range) {
    if (range && !(range.to > range.from)) throw new RangeError("a loop has to end after it begins");
    this.#range = range && { from: range.from, to: range.to };
    this.#changeLoop();
  }
  #changeLoop() {
    if (!this.#playout) return;
    Object.assign(this.#playout, { loop: this.#loop, range: this.#range });
    this.#playout.unwrap();
  }

  /** To where the stream is now: by another connection, which begins with its newest group. */
  goLive() {
    if (!this.live || this.#reopened || this.readyState === READY.NOTHING) return;
    this.#reopen();
    if (this.paused) this.play();
  }
  /** Seconds behind the live edge. */
  get behind() {
    return this.#playout?.behind ?? 0;
  }

  get frameCount() {
    return this.#playout?.decoder.frameCount ?? 0;
  }
  get decoder() {
    return this.#playout?.decoder ?? null;
  }
  get heldFrames() {
    return this.#playout?.heldFrames ?? 0;
  }
  get seekable() {
    return new Ranges(this.#playout?.seekable);
  }
  get buffered() {
    return new Ranges(this.#playout?.buffered);
  }

  /** For each picture of the screen. Answers whether another tick is wanted. */
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

  /** Asks the decoder for its figures, and for what it holds. */
  async measure() {
    const { decoder } = this;
    const [figures, held] = (await Promise.all([decoder?.stats(), decoder?.buffered()]).catch(() => null)) ?? [];
    if (!figures || decoder !== this.decoder) return;
    this.#playout.held = held;
    if (this.meter.decoder(this.#now(), figures)) this.announce("progress");
  }

  #stall() {
    if (this.readyState < READY.FUTURE_DATA && this.networkState === NETWORK.LOADING) this.announce("stalled");
  }
}
