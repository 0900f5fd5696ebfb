// The public decoder: events, frames, seeking. The engine does the work, in a worker or in the caller's thread.

import { onAbort, reasonOf, unlessAborted } from "./abort.js";
import { Camera, camerasFor, Projector, tracksOf } from "./camera.js";
import { Engine } from "./engine.js";
import { FvvError } from "./errors.js";
import { rungsOf } from "./ladder.js";
import { Frame } from "./frame.js";
import { compileEnvironment, compileCodec, compileCore, compileProjection } from "./modules.js";
import { connect } from "./worker_rpc.js";
import { SoundDecoders } from "./media/sound.js";
import { createProjection } from "./wasm.js";

/** How long a worker may take to start. */
const WORKER_TIMEOUT_MS = 10000;

export class FvvEvent extends Event {
  constructor(type, detail) {
    super(type);
    this.detail = detail;
  }
}

function startWorker(given) {
  const made = typeof given === "function" ? given() : given;
  // In one expression: bundlers look for exactly this text.
  const worker =
    made instanceof Worker
      ? made
      : made instanceof URL || typeof made === "string"
        ? new Worker(made, { type: "module" })
        : new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  return new Promise((resolve, reject) => {
    const fail = (why) => {
      worker.terminate();
      reject(new Error(why));
    };
    const timer = setTimeout(() => fail("it does not respond"), WORKER_TIMEOUT_MS);
    worker.addEventListener("error", (event) => {
      clearTimeout(timer);
      event.preventDefault?.();
      fail(event.message || "its script cannot be loaded");
    });
    worker.addEventListener("message", function ready({ data }) {
      if (data.result !== "ready") return;
      clearTimeout(timer);
      worker.removeEventListener("message", ready);
      resolve(worker);
    });
    // A worker that the page started earlier has announced itself already; one that still loads may miss this question.
    worker.postMessage({ id: 0, name: "ready" });
  });
}

function checkedRung(rung) {
  if (rung === "auto" || (Number.isInteger(rung) && rung >= 0)) return rung;
  const message = `rung: expected "auto" or the number of a rung, found ${rung}`;
  throw new FvvError({ code: "argument", fatal: false, message });
}

const closedError = () => new FvvError({ code: "state", message: "the decoder was closed" });

/** In this thread: functions can't be sent to workers, but the compiled module can. */
async function loadFallback(find) {
  const found = await find();
  return found instanceof WebAssembly.Module ? found : found.compile();
}

export class Decoder extends EventTarget {
  #call;
  #worker = null;
  #pendingWarning = null;
  #projector;
  #cameras = [];
  #latestCameras = []; // as they were in the frame that was taken last
  #view = null;
  #finish = [];
  #taking = Promise.resolve();
  #givenRungs = null; // by a manifest or a server
  #rung = null; // that was reported last
  #ended = false;
  #closing = new AbortController();
  #sounds = null; // decoders of sound
  #configured = {}; // a promise, and what fulfils it with the first configuration
  #heard = 0; // generation of sounds that are wanted; those of former ones were read before a seek

  /** Use createDecoder. */
  static async create(options) {
    const decoder = new Decoder();
    options.signal?.throwIfAborted();
    try {
      await decoder.#open(options);
    } catch (error) {
      decoder.close();
      throw options.signal?.aborted ? reasonOf(options.signal) : error;
    }
    return decoder;
  }

  get #closed() {
    return this.#closing.signal.aborted;
  }
  /** Calls finish when the decoder is closed, at once if it is already. */
  #atClose(finish) {
    if (this.#closed) finish();
    else this.#finish.push(finish);
  }

  async #open(options) {
    const { source, feed, signal } = options;
    this.#atClose(onAbort(signal, () => this.close()));
    const module = await compileCore();
    this.#projector = new Projector(await createProjection(await compileProjection()));
    this.configuration = null;
    this.#configured.promise = new Promise((fulfil) => (this.#configured.fulfil = fulfil));
    this.environments = [];
    this.writable = feed?.writable ?? null;
    const pull = () => feed?.pull() ?? null;
    if (feed) this.#atClose(() => feed.cancel());
    const fallback = options.videoFallback && (() => loadFallback(options.videoFallback));
    const served = {
      pull,
      codec: compileCodec,
      environment: compileEnvironment,
      fallback,
      outage: async (detail) => this.#reportOutage(detail, options.onOutage),
      renew: options.renewAddress,
    };
    await this.#connect(options.worker, served);
    if (this.#closed) throw closedError();
    const { limits, normals, visibility, video, sound, queue, tracks, look, rung, network } = options;
    const decoded = { normals, visibility, video, sound: sound !== false };
    const wanted = { limits, ...decoded, queue, tracks, rung, network };
    this.rung = checkedRung(rung);
    const modes = {
      hasFallback: Boolean(fallback),
      hasRenewal: Boolean(options.renewAddress),
      waitsForSelection: look !== null,
    };
    const opening = this.#call("open", { source, module, ...wanted, ...modes });
    const opened = await unlessAborted(opening, this.#closing.signal);
    this.#givenRungs = opened.rungs;
    Object.assign(this, opened, { rungs: opened.rungs ?? [] });
    if (sound !== false) this.#listen(sound === "encoded", options.soundFallback);
    if (look) await this.#lookAtOnce(look, tracks);
  }

  async #connect(wanted, served) {
    if (wanted !== false && typeof Worker === "function")
      try {
        this.#worker = await startWorker(wanted);
        const { call, fail } = connect(this.#worker, served);
        this.#call = call;
        this.#worker.addEventListener("error", ({ message }) => {
          fail(new FvvError({ code: "worker", message: `the worker failed: ${message}` }));
        });
        this.#atClose(() => {
          this.#worker.terminate();
          fail(closedError());
        });
        return;
      } catch (error) {
        const message = `no worker could be started (${error.message}): this thread decodes`;
        this.#pendingWarning = FvvError.warning("worker", message);
      }
    const engine = new Engine(served);
    this.#call = async (name, argument) => engine[name](argument);
    this.#atClose(() => engine.close());
  }

  /** Sound is read ahead of the frames, and dispatched as soon as it is decoded. */
  async #listen(encoded, fallback) {
    const emit = (block) => this.dispatchEvent(new FvvEvent("sound", block));
    const warn = (error) => this.dispatchEvent(new FvvEvent("warning", error));
    if (!encoded) this.#sounds = new SoundDecoders({ emit, warn, fallback });
    this.#atClose(() => this.#sounds?.close());
    try {
      while (!this.#closed) {
        const sounds = await this.#call("soundsAhead");
        // Reports of damage may come before the configuration does; sound does not.
        await this.#configured.promise;
        if (!sounds || this.#closed) return;
        const { generation, configured, chunks } = sounds;
        if (configured) this.#sounds?.configure(configured);
        if (generation < this.#heard) continue;
        if (this.#sounds) this.#sounds.take(chunks);
        else chunks.forEach(emit);
      }
    } catch {
      // The next call of next() reports why.
    }
  }

  get inWorker() {
    return this.#worker !== null;
  }

  #configure(configuration) {
    configuration.cameras = configuration.cameras.map((fields) => new Camera(fields, this.#projector));
    this.configuration = configuration;
    this.#configured.fulfil();
    this.rungs = this.#givenRungs ?? rungsOf(configuration);
    this.#cameras = this.#latestCameras = configuration.cameras;
    // Track numbers may have changed. The next call reports a failure.
    if (this.#view) this.look(this.#view).catch(() => {});
    this.dispatchEvent(new FvvEvent("configuration", configuration));
  }

  /** Before anything is played, if the source has its configuration by then; else as soon as it arrives. */
  async #lookAtOnce(view, tracks) {
    const configuration = await this.#call("peek");
    this.#view = view;
    if (!configuration) return this.#call("select", { tracks });
    const cameras = configuration.cameras.map((fields) => new Camera(fields, this.#projector));
    await this.#aim(cameras, configuration);
  }

  /** By the stream's own rule, where the caller names none. */
  async #aim(cameras, { videos, texturing }) {
    const needed = camerasFor(cameras, { texturing, ...this.#view });
    const tracks = needed.length
      ? tracksOf(
          videos,
          needed.map(({ camera }) => camera),
        )
      : videos.map(({ track }) => track);
    await this.#call("select", { tracks: needed.length ? tracks : null });
    return { cameras: needed, tracks };
  }

  /** Tracks of video in frames from the next group on; null: all. Ends the selection by look. */
  async select({ tracks = null }) {
    if (tracks !== null && !(Array.isArray(tracks) && tracks.every(Number.isInteger)))
      throw new FvvError({ code: "argument", fatal: false, message: "tracks: expected a list of numbers, or null" });
    this.#view = null;
    await this.#call("select", { tracks });
  }

  /** "auto", or the number of a rung, 0 for the best; from the next group on at the latest. */
  async setRung(rung) {
    this.rung = checkedRung(rung);
    await this.#call("setRung", { rung });
  }
  /** Pixels on the screen for a pixel of the cameras' pictures: "auto" takes no rung with more. null: not known. */
  async setShownScale(scale) {
    await this.#call("setShownScale", { scale });
  }

  /**
   * The rung that is worth fetching for a frame that stays on screen, by a seek to the same frame: the wanted one, else the best
   * that is shown and that the network carries, at half the speed of playback unless the frame plays on. null: there is no
   * ladder, or nothing is known of the network.
   */
  lastingRung({ plays = false } = {}) {
    return this.#call("lastingRung", { plays });
  }

  /** Selects the tracks whose cameras a picture from eye towards target needs. See camerasFor. */
  async look(view) {
    camerasFor([], view);
    this.#view = view;
    if (!this.configuration) return { cameras: [], tracks: [] };
    return this.#aim(this.#latestCameras, this.configuration);
  }

  /** The source was opened again, or more of it is known. */
  #update({ seekable, frameCount, groups }) {
    Object.assign(this, { seekable, frameCount, groups });
    this.dispatchEvent(new FvvEvent("groups", groups));
  }

  /** Another environment of the current configuration; null: the configuration has changed. */
  #addEnvironment(environment) {
    this.environments = environment ? [...this.environments, environment] : [];
    this.dispatchEvent(new FvvEvent("environment", this.environments));
  }

  #makeFrame(raw) {
    const moving = new Map(raw.moving.map((fields) => [fields.id, fields]));
    const cameras = this.#cameras.map((camera) =>
      moving.has(camera.id) ? new Camera({ ...moving.get(camera.id), name: camera.name }, this.#projector) : camera,
    );
    this.#latestCameras = cameras;
    return new Frame(raw, this.configuration, cameras);
  }

  /** The next frame, or null at the end. Throws an FvvError that is fatal. */
  next() {
    const taken = this.#taking.then(() => this.#take());
    this.#taking = taken.catch(() => {});
    return taken;
  }

  async #take() {
    // Listeners can only be added after the decoder was created.
    if (this.#pendingWarning) this.dispatchEvent(new FvvEvent("warning", this.#pendingWarning));
    this.#pendingWarning = null;
    while (!this.#closed && !this.#ended) {
      const item = await this.#call("next").catch((error) => {
        if (!this.#closed) throw error;
      });
      if (this.#closed) {
        item?.frame?.pictures.forEach(({ picture }) => picture.close?.());
        break;
      }
      const { type } = item;
      if (type === "frame") {
        return this.#makeFrame(item.frame);
      }
      const detail = this.#revive(item.detail);
      if (type === "configuration") this.#configure(detail);
      else if (type === "opened") this.#update(detail);
      else if (type === "environment") this.#addEnvironment(detail);
      else if (type === "end") this.#ended = true;
      else if (type === "rung") this.#changeRung(detail);
      else if (type === "rungs") this.#givenRungs = detail;
      else this.dispatchEvent(new FvvEvent(type, detail));
      if (type === "error") {
        this.#ended = true;
        throw detail;
      }
    }
    if (this.#ended && !this.#closed) this.dispatchEvent(new FvvEvent("end", null));
    return null;
  }

  /** Requests fail and are tried again; null: bytes come again. At once: the queue of events may be what waits for them. */
  #reportOutage(detail, listener) {
    if (this.#closed) return;
    listener?.(detail);
    this.dispatchEvent(new FvvEvent(detail ? "stalled" : "recovered", detail));
  }

  /** Playback reports the rung after each seek. */
  #changeRung(detail) {
    if (detail.rung === this.#rung) return;
    this.#rung = detail.rung;
    this.dispatchEvent(new FvvEvent("rung", detail));
  }

  #revive(detail) {
    if (!this.#worker || !detail) return detail;
    return detail.severity ? FvvError.fromPlain(detail) : detail;
  }

  async *[Symbol.asyncIterator]() {
    for (;;) {
      const frame = await this.next();
      if (!frame) return;
      yield frame;
    }
  }
  frames() {
    return this[Symbol.asyncIterator]();
  }

  /**
   * Playback continues with this frame. {frame: number}, {time: ticks as bigint} or {seconds}. rung: that the frame's group comes in;
   * those after it come as setRung says.
   */
  async seek({ frame, time, seconds, rung = null }) {
    if (!this.seekable) throw new FvvError({ code: "state", fatal: false, message: "this source cannot be sought in" });
    let place;
    if (frame !== undefined) {
      if (!(Number.isInteger(frame) && frame >= 0 && frame < (this.frameCount ?? Infinity)))
        throw new FvvError({
          code: "argument",
          fatal: false,
          message: `frame: expected 0 to ${this.frameCount === null ? "the end" : this.frameCount - 1}, found ${frame}`,
        });
      place = { frame };
    } else if (time !== undefined) {
      place = { time: BigInt(time) };
    } else {
      const { numerator, denominator } = (await this.#firstConfiguration()).timeBase;
      place = { time: BigInt(Math.floor((seconds * denominator) / numerator + 1e-6)) };
    }
    const former = this.#heard;
    this.#heard = Infinity;
    this.#sounds?.restart();
    try {
      this.#heard = await this.#call("seek", rung === null ? place : { ...place, rung: checkedRung(rung) });
    } catch (error) {
      this.#heard = former;
      throw error;
    }
    this.dispatchEvent(new FvvEvent("soundrestart", null));
    this.#ended = false;
  }

  /** Times in seconds need the configuration, which arrives before the first frame. */
  async #firstConfiguration() {
    if (!this.configuration) (await this.next())?.close();
    if (!this.configuration)
      throw new FvvError({ code: "state", fatal: false, message: "the stream has no configuration" });
    return this.configuration;
  }

  /** Statistics since the beginning: frames, decodeMs, memoryBytes, bytesRead, requests, ... */
  async stats() {
    const stats = await this.#call("status");
    this.dispatchEvent(new FvvEvent("stats", stats));
    return stats;
  }

  /** [{start, end}] in ticks: times that can be played without the network. */
  buffered() {
    return this.#call("bufferedTimes");
  }

  /** Stops everything; a running iteration ends without an error. Frames that were returned stay valid. */
  close() {
    if (this.#closed) return;
    this.#closing.abort();
    for (const finish of this.#finish.splice(0)) finish();
    this.#configured.fulfil?.();
  }
}
