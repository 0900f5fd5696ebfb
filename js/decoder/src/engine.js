// Playback, pictures, and a bounded queue of frames. Runs in the worker, or without a worker in the caller's thread.

import { Cache } from "./sources/cache.js";
import { FvvError } from "./errors.js";
import { createPictures } from "./media/pictures.js";
import { Playback } from "./playback.js";
import { defaultLimits } from "./session.js";
import { openSource } from "./sources/open.js";
import { notAStream } from "./sources/network.js";

/** FVV-1001 */
const NO_SIGNATURE = 1001;
/** A file that changes more often is an error. */
const REOPEN_MAX = 3;
/** Seconds that are read ahead of the last frame in the queue if there is sound, which has to arrive before its time. */
const SOUND_AHEAD = 0.5;

export class Engine {
  #pull;
  #codec;
  #environment;
  #fallback;
  #report;
  #renew;
  #policy; // of the network
  #description; // of the source
  #limit; // of frames in the queue
  #settings;
  #tracks = null;
  #rung;
  #waitsForSelection = false;
  #pictures;
  #source;
  #cache;
  #playback;
  #generation = 0; // of seeks
  #read = []; // frames and events that are not in the queue yet; their pictures are not decoded
  #queue = [];
  #wantsSound = false; // whether sound is wanted
  #sounds = []; // what soundsAhead returns: {generation, configured, chunks}
  #soundConfiguration = ""; // the last one
  #listening = null; // resolves when that changes
  #soundTracks = 0;
  #tickSeconds = 0;
  #waiting = null; // resolves when something is in the queue
  #room = null; // resolves when there is room in the queue
  #running; // promise of the current generation
  #frames; // generator
  #abort;
  #last = null; // time of the last frame
  #closing = new AbortController();
  #stats = { frames: 0, skipped: 0, decodeMs: 0, pictures: 0 };

  get #closed() {
    return this.#closing.signal.aborted;
  }

  /** pull(): the next bytes of a stream, or null. codec(name), environment(), fallback(): return compiled modules. outage(detail),
   * renew({url, status}): report and renew of Network. */
  constructor({ pull, codec, environment, fallback, outage, renew }) {
    this.#report = outage;
    this.#renew = renew;
    this.#pull = pull;
    this.#codec = codec;
    this.#environment = environment;
    this.#fallback = fallback;
  }

  /** tracks: as of select. waitsForSelection: nothing is played before the first call of select. */
  async open(options) {
    const { source, module, limits, video, hasFallback, queue, tracks = null, rung = "auto", ...more } = options;
    const { waitsForSelection = false, sound = false, network = {}, hasRenewal = false, ...want } = more;
    this.#policy = network;
    if (!hasRenewal) this.#renew = null;
    this.#wantsSound = sound;
    this.#limit = Math.max(1, queue);
    this.#rung = rung;
    this.#description = source;
    this.#tracks = tracks;
    this.#waitsForSelection = waitsForSelection;
    this.#settings = { module, limits, want };
    this.#pictures = createPictures(video, {
      emit: (type, error) => this.#emit(type, error),
      fallback: hasFallback ? this.#fallback : null,
      memoryBytes: limits.memory ?? defaultLimits.memory,
    });
    await this.#openSource();
    if (!waitsForSelection) this.#play(undefined);
    return this.#playback.about;
  }

  async #openSource() {
    const warn = (error) => this.#emit("warning", error);
    this.#source?.close();
    const cache = (this.#cache = new Cache(() => this.#cacheRoom));
    const { signal } = this.#closing;
    const access = { signal, policy: this.#policy, report: this.#report, renew: this.#renew };
    const source = await openSource(this.#description, { pull: this.#pull, warn, cache, rung: this.#rung, ...access });
    this.#source = source;
    if (this.#closed) source.close();
    const opening = Playback.open(source, {
      ...this.#settings,
      codec: this.#codec,
      selection: this.#tracks,
      rung: this.#rung,
      frugal: this.#waitsForSelection,
      environment: this.#environment,
      emit: (type, detail) => this.#emit(type, detail),
    });
    this.#playback = await opening.catch((error) => {
      throw this.#explained(error);
    });
  }
  /** Names the address of a file that is no stream, and what the host sent. */
  #explained(error) {
    const { url } = this.#description;
    return url && error.issue === NO_SIGNATURE ? notAStream(url, this.#source.type, error) : error;
  }
  /** The cache may use the memory that decoding leaves. */
  get #cacheRoom() {
    const { memory, cacheBytes } = { ...defaultLimits, ...this.#settings.limits };
    return this.#closed ? 0 : Math.min(cacheBytes, memory - (this.#playback?.memoryBytes ?? 0));
  }

  /** Events are queued between frames, so that they are dispatched in order. */
  #emit(type, detail) {
    if (type === "sounds") return this.#wantsSound && this.#addSounds({ chunks: detail });
    if (type === "configuration") this.#configureSound(detail);
    this.#read.push({ type, detail });
    this.#fill();
  }
  #configureSound({ sounds, timeBase }) {
    this.#soundTracks = sounds.length;
    this.#tickSeconds = timeBase.numerator / timeBase.denominator;
    // A repetition of the configuration does not interrupt sound.
    const text = JSON.stringify(sounds, (_, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value));
    if (!this.#wantsSound || text === this.#soundConfiguration) return;
    this.#soundConfiguration = text;
    this.#addSounds({ configured: structuredClone(sounds) });
  }
  #addSounds({ configured = null, chunks = [] }) {
    const last = this.#sounds.at(-1);
    if (last && !configured) last.chunks.push(...chunks);
    else this.#sounds.push({ generation: this.#generation, configured, chunks: [...chunks] });
    this.#listening?.();
  }
  /** What was read since the last call, as soon as there is some: {generation, configured, chunks}; null at the end. */
  async soundsAhead() {
    while (!this.#sounds.length && !this.#closed) await new Promise((resolve) => (this.#listening = resolve));
    return this.#sounds.shift() ?? null;
  }

  /** Moves what was read into the queue as far as there is room, and starts the decoding of its pictures. */
  #fill() {
    while (this.#read.length) {
      const [{ type, detail, frame }] = this.#read;
      if (type === "frame" && !frame.skipped && this.#full) return;
      this.#read.shift();
      // The detail is transferred to another thread, with the records in it.
      if (type === "configuration") this.#pictures.configure(structuredClone(detail));
      if (type === "frame") this.#enqueue(frame);
      else this.#queue.push({ type, detail });
    }
    this.#wake();
  }
  #enqueue(frame) {
    const pictures = this.#pictures.submit(frame);
    pictures.catch(() => {});
    if (frame.skipped) {
      this.#stats.skipped++;
      pictures.then(closeAll, () => {});
      return;
    }
    this.#last = frame.time;
    this.#stats.frames++;
    this.#stats.decodeMs += frame.decodeMs;
    this.#queue.push({ type: "frame", frame, pictures });
  }
  /** Whether enough was read. */
  get #ahead() {
    if (!this.#wantsSound || !this.#soundTracks) return this.#full;
    const frames = this.#read.filter(({ type }) => type === "frame");
    return (
      frames.length > 0 && Number(frames.at(-1).frame.time - frames[0].frame.time) * this.#tickSeconds >= SOUND_AHEAD
    );
  }
  #wake() {
    const waiting = this.#waiting;
    this.#waiting = null;
    waiting?.();
  }
  get #full() {
    return this.#queue.reduce((n, item) => n + (item.type === "frame" ? 1 : 0), 0) >= this.#limit;
  }

  async #play(place) {
    const generation = ++this.#generation;
    this.#read = this.#read.filter(outlivesSeek);
    this.#sounds = this.#sounds.filter(({ configured }) => configured);
    for (const sounds of this.#sounds) Object.assign(sounds, { generation, chunks: [] });
    this.#queue.forEach((item) => item.type === "frame" && discard(item));
    this.#queue = this.#queue.filter(outlivesSeek);
    this.#room?.();
    this.#abort?.abort();
    this.#abort = new AbortController();
    // Two generators in one session would consume each other's bytes.
    const former = this.#running;
    let done;
    this.#running = new Promise((resolve) => (done = resolve));
    this.#frames?.return().catch(() => {});
    await former;
    try {
      if (generation === this.#generation) await this.#produceAcrossChanges(generation, place);
    } catch (error) {
      if (generation === this.#generation) this.#emit("error", this.#explained(FvvError.from(error)));
    } finally {
      done();
      this.#wake();
    }
  }

  /** A file that changes while it is read is opened again, and played from the same time on. */
  async #produceAcrossChanges(generation, place) {
    for (let times = 0; ; times++) {
      try {
        return await this.#produce(generation, place);
      } catch (error) {
        if (error.code !== "changed" || times === REOPEN_MAX || generation !== this.#generation) throw error;
        this.#emit("warning", FvvError.warning("changed", error.message));
        const last = this.#last;
        await this.#openSource();
        const { about } = this.#playback;
        this.#emit("opened", about);
        if (last !== null) place = { time: last };
        if (!about.seekable || place?.frame >= about.frameCount) place = undefined;
      }
    }
  }

  async #produce(generation, place) {
    this.#pictures.restart();
    this.#last = null;
    const current = () => generation === this.#generation;
    this.#frames = this.#playback.frames(place, this.#abort.signal);
    for await (const frame of this.#frames) {
      if (!current()) return;
      this.#cache.evict();
      this.#read.push({ type: "frame", frame });
      this.#fill();
      while (current() && this.#ahead) await new Promise((resolve) => (this.#room = resolve));
      if (!current()) return;
    }
    while (current() && this.#read.length) await new Promise((resolve) => (this.#room = resolve));
    if (!current()) return;
    await this.#pictures.flush();
    if (current()) this.#queue.push({ type: "end" });
  }

  /** The next frame or event: {type: "frame", frame}, {type: "warning", detail}, {type: "end"}, ... */
  async next() {
    for (;;) {
      const generation = this.#generation;
      if (!this.#queue.length) {
        if (this.#closed) return { type: "end" };
        await new Promise((resolve) => (this.#waiting = resolve));
        continue;
      }
      const item = this.#queue[0];
      const pictures = item.type === "frame" ? await item.pictures : [];
      if (generation !== this.#generation) {
        closeAll(pictures);
        continue;
      }
      this.#queue.shift();
      this.#fill();
      const room = this.#room;
      this.#room = null;
      room?.();
      if (item.type !== "frame") return item;
      this.#stats.pictures += pictures.length;
      return { type: "frame", frame: { ...item.frame, pictures, edge: this.#source.edge } };
    }
  }

  /** Returns the generation of sounds from there on. */
  seek(place) {
    if (!this.#playback.about.seekable)
      throw new FvvError({ code: "state", fatal: false, message: "this source cannot be sought in" });
    this.#play(place);
    return this.#generation;
  }

  /** [{start, end}] in ticks: times that can be played without the network. */
  bufferedTimes() {
    return this.#playback.bufferedTimes();
  }

  /** The configuration, if the source has it before playback begins. */
  peek() {
    return this.#playback.peek();
  }

  /** Tracks of video in frames; null: all. */
  select({ tracks }) {
    this.#tracks = tracks;
    this.#playback.select(tracks);
    if (this.#waitsForSelection) this.#play(undefined);
    this.#waitsForSelection = false;
  }

  /** "auto", or a rung. */
  setRung({ rung }) {
    this.#rung = rung;
    this.#playback.setRung(rung);
  }
  setShownScale({ scale }) {
    this.#playback.setShownScale(scale);
  }
  lastingRung({ plays }) {
    return this.#playback.lastingRung(plays);
  }

  status() {
    const [source, playback, cache] = [this.#source, this.#playback, this.#cache];
    return {
      ...this.#stats,
      queued: this.#queue.length,
      memoryBytes: playback.memoryBytes,
      bytesRead: source.bytesRead,
      requests: source.requests,
      cachedBytes: cache.bytes,
      cacheHits: cache.hits,
      bytesReused: cache.bytesReused,
      ...playback.network,
    };
  }

  /** Everything that waits settles: next and soundsAhead with the end, the others with an error. */
  close() {
    this.#generation++;
    this.#closing.abort();
    this.#room?.();
    this.#queue.forEach((item) => item.type === "frame" && discard(item));
    this.#read = [];
    this.#queue = [{ type: "end" }];
    this.#wake();
    this.#abort?.abort();
    this.#frames?.return().catch(() => {});
    this.#pictures?.close();
    this.#listening?.();
    this.#source?.close();
  }
}

/** Damage and gaps of frames that are not played any more are not reported. */
function outlivesSeek({ type, detail }) {
  return type === "environment" || (type === "warning" && detail.severity === "warning" && detail.code !== "gap");
}
function closeAll(pictures) {
  for (const { picture } of pictures) picture.close();
}
function discard(item) {
  item.pictures?.then(closeAll, () => {});
}
