// What runs in the worker, or without one beside the caller: playback, pictures, and a bounded queue of frames between
// them and who takes them.

import { Cache } from "./cache.js";
import { FvvError } from "./errors.js";
import { createPictures } from "./pictures.js";
import { Playback } from "./playback.js";
import { defaultLimits } from "./session.js";
import { openSource } from "./sources.js";

/** A file that changes more often than this is not worth it. */
const REOPEN_MOST = 3;

export class Engine {
  /** pull(): the next bytes of a source that is a stream, or null. codec(name), background(), fallback(): compiled modules. */
  constructor({ pull, codec, background, fallback }) {
    Object.assign(this, { pull, codec, background, fallback });
    Object.assign(this, { generation: 0, queue: [], waiting: null, room: null, error: null, closed: false });
    this.stats = { frames: 0, passed: 0, dropped: 0, decodeMs: 0, pictures: 0 };
  }

  /** tracks: as of select. held: nothing is played before the first call of that. */
  async open({ source, module, limits, video, hasFallback, queue, tracks = null, held = false, ...want }) {
    this.limit = Math.max(1, queue);
    this.description = source;
    Object.assign(this, { tracks, held });
    this.settings = { module, limits, want };
    this.pictures = createPictures(video, {
      tell: (type, error) => this.#tell(type, error),
      fallback: hasFallback ? this.fallback : null,
      memoryBytes: limits.memory ?? defaultLimits.memory,
    });
    await this.#openSource();
    if (!held) this.#run(undefined);
    return this.playback.about;
  }

  async #openSource() {
    const warn = (error) => this.#tell("warning", error);
    this.source?.close?.();
    const cache = (this.cache = new Cache(() => this.#cacheRoom));
    const source = await openSource(this.description, { pull: this.pull, warn, cache });
    this.source = source;
    if (this.closed) source.close?.();
    this.playback = await Playback.open(source, {
      ...this.settings,
      codec: this.codec,
      selection: this.tracks,
      frugal: this.held,
      background: this.background,
      emit: (type, detail) => this.#tell(type, detail),
    });
  }
  /** The cache gives way to what decoding takes. */
  get #cacheRoom() {
    const { memory, cacheBytes } = { ...defaultLimits, ...this.settings.limits };
    return this.closed ? 0 : Math.min(cacheBytes, memory - (this.playback?.session.memoryBytes ?? 0));
  }

  /** Events stand in the queue between frames, so that they are told in their place. */
  #tell(type, detail) {
    // What is told is handed over to another thread, with the records in it.
    if (type === "configuration") this.pictures.configure(structuredClone(detail));
    this.queue.push({ type, detail });
    this.#wake();
  }
  #wake() {
    const { waiting } = this;
    this.waiting = null;
    waiting?.();
  }
  get #full() {
    return this.queue.reduce((n, item) => n + (item.type === "frame" ? 1 : 0), 0) >= this.limit;
  }

  async #run(place) {
    const generation = ++this.generation;
    this.queue.forEach((item) => item.type === "frame" && discard(item));
    this.queue = this.queue.filter((item) => item.type === "warning" || item.type === "background");
    this.room?.();
    this.abort?.abort();
    this.abort = new AbortController();
    // Two generators in one session would take each other's bytes.
    const former = this.running;
    let done;
    this.running = new Promise((resolve) => (done = resolve));
    this.frames?.return().catch(() => {});
    await former;
    try {
      if (generation === this.generation) await this.#produceAnew(generation, place);
    } catch (error) {
      if (generation === this.generation) this.queue.push({ type: "error", detail: FvvError.from(error) });
    } finally {
      done();
      this.#wake();
    }
  }

  /** A file that changes while it is read is opened again, and played from the same time on. */
  async #produceAnew(generation, place) {
    for (let times = 0; ; times++) {
      try {
        return await this.#produce(generation, place);
      } catch (error) {
        if (error.code !== "changed" || times === REOPEN_MOST || generation !== this.generation) throw error;
        this.#tell(
          "warning",
          new FvvError({ code: "changed", severity: "warning", fatal: false, message: error.message }),
        );
        const { last } = this;
        await this.#openSource();
        const { about } = this.playback;
        this.#tell("opened", about);
        if (last !== null) place = { time: last };
        if (!about.seekable || place?.frame >= about.frameCount) place = undefined;
      }
    }
  }

  async #produce(generation, place) {
    this.pictures.restart();
    this.last = null;
    const current = () => generation === this.generation;
    this.frames = this.playback.frames(place, this.abort.signal);
    for await (const frame of this.frames) {
      if (!current()) return;
      this.cache.fit();
      const pictures = this.pictures.submit(frame);
      pictures.catch(() => {});
      if (frame.skipped) {
        this.stats.passed++;
        pictures.then(closeAll, () => {});
        continue;
      }
      this.last = frame.time;
      this.stats.frames++;
      this.stats.decodeMs += frame.decodeMs;
      this.queue.push({ type: "frame", frame, pictures });
      this.#wake();
      while (current() && this.#full) await new Promise((resolve) => (this.room = resolve));
      if (!current()) return;
    }
    await this.pictures.flush();
    if (current()) this.queue.push({ type: "end" });
  }

  /** The next frame or event: {type: "frame", frame}, {type: "gap", detail}, {type: "end"}, ... */
  async next() {
    for (;;) {
      const { generation } = this;
      if (!this.queue.length) {
        await new Promise((resolve) => (this.waiting = resolve));
        continue;
      }
      const item = this.queue[0];
      const pictures = item.type === "frame" ? await item.pictures : [];
      if (generation !== this.generation) {
        closeAll(pictures);
        continue;
      }
      this.queue.shift();
      const { room } = this;
      this.room = null;
      room?.();
      if (item.type !== "frame") return item;
      this.stats.pictures += pictures.length;
      return { type: "frame", frame: { ...item.frame, pictures } };
    }
  }

  seek(place) {
    if (!this.playback.about.seekable)
      throw new FvvError({ code: "state", fatal: false, message: "this source can't be sought in" });
    this.#run(place);
  }

  /** [{start, end}] in ticks: what plays without the network. */
  heldTimes() {
    return this.playback.heldTimes();
  }

  /** The configuration, as early as the source can tell. */
  peek() {
    return this.playback.peek();
  }

  /** Tracks of video that frames come with; null: all. */
  select({ tracks }) {
    this.tracks = tracks;
    this.playback.select(tracks);
    if (this.held) this.#run(undefined);
    this.held = false;
  }

  status() {
    const { source, playback, stats, cache } = this;
    return {
      ...stats,
      queued: this.queue.length,
      memoryBytes: playback.session.memoryBytes,
      bytesRead: source.bytesRead ?? null,
      requests: source.requests ?? null,
      cachedBytes: cache.bytes,
      cacheHits: cache.hits,
      bytesReused: cache.bytesReused,
    };
  }

  async close() {
    this.generation++;
    this.room?.();
    this.queue.forEach((item) => item.type === "frame" && discard(item));
    this.queue = [{ type: "end" }];
    this.#wake();
    this.abort?.abort();
    this.frames?.return().catch(() => {});
    this.pictures?.close();
    this.closed = true;
    this.source?.close?.();
  }
}

function closeAll(pictures) {
  for (const { image } of pictures) image.close();
}
function discard(item) {
  item.pictures?.then(closeAll, () => {});
}
