// Decodes pictures from video samples by WebCodecs, else by a fallback in wasm, and from JPEG files by createImageBitmap.
// The timestamp of a picture identifies its frame, not the order in which decoders return pictures.

import { unlessAborted } from "../abort.js";
import { FvvError } from "../errors.js";
import { SoftwareVideo } from "./software_video.js";

/** A picture is lost when this many later pictures have arrived. Less than the length of the decoder's queue. */
const OVERTAKEN_MAX = 3;
/** How long a decoder may return no picture while samples are pending. */
const TIMEOUT_MS = 2000;
/** The same until the first one: starting a decoder of the hardware takes long on a busy machine. */
const FIRST_MS = 5000;

/** The configuration for WebCodecs. */
const configurationOf = (layout) => ({
  codec: layout.codecString,
  codedWidth: layout.width,
  codedHeight: layout.height,
  description: layout.codec === "avc1" || layout.codec === "hvc1" ? layout.record : undefined,
  optimizeForLatency: true,
});

class VideoTrack {
  #layout;
  #fail;
  #replace;
  #decoder;
  #waiting = new Map(); // timestamp -> {resolve, overtaken, sample}
  #broken = false;
  #proven = false; // it has returned a picture
  #substitute = null; // promise of the track that takes over
  #closed = false;
  #needsKey = true;
  #timer;

  /** replace(error): of a decoder that fails before its first picture; returns the promise of another track, or null. */
  constructor(layout, fail, replace) {
    this.#layout = layout;
    this.#fail = fail;
    this.#replace = replace;
    this.#open();
  }
  #open() {
    this.#needsKey = true;
    this.#decoder = new VideoDecoder({
      output: (picture) => this.#take(picture),
      error: (error) => this.#break(error),
    });
    this.#decoder.configure(configurationOf(this.#layout));
  }
  #take(picture) {
    const entry = this.#waiting.get(picture.timestamp);
    if (!entry) return picture.close();
    this.#proven = true;
    this.#waiting.delete(picture.timestamp);
    entry.resolve(picture);
    for (const [timestamp, other] of this.#waiting)
      if (timestamp < picture.timestamp && ++other.overtaken >= OVERTAKEN_MAX) this.#lose(timestamp);
    this.#watch();
  }
  /** Decoders drop pictures without an error, and frames would wait for them forever. */
  #lose(timestamp) {
    const { resolve } = this.#waiting.get(timestamp);
    this.#waiting.delete(timestamp);
    this.#fail(new Error(`the picture of ${timestamp} us was dropped`), this.#layout);
    resolve(null);
  }
  #watch() {
    clearTimeout(this.#timer);
    if (!this.#waiting.size) return;
    const late = () => {
      if (!this.#proven) return this.#break(new Error(`no picture came for ${FIRST_MS / 1000} s`));
      this.#lose(Math.min(...this.#waiting.keys()));
      this.#watch();
    };
    this.#timer = setTimeout(late, this.#proven ? TIMEOUT_MS : FIRST_MS);
  }
  #break(error) {
    if (this.#broken || this.#closed) return;
    this.#broken = true;
    if (this.#decoder.state !== "closed") this.#decoder.close();
    // What a browser says it supports may fail all the same, in each attempt.
    if (!this.#proven) this.#substitute = this.#replace(error);
    else this.#fail(error, this.#layout);
    if (this.#substitute) this.#handOver();
    this.#drop();
  }
  /** All samples since the key still wait, as no picture has come. */
  #handOver() {
    for (const [timestamp, { resolve, sample }] of this.#waiting) resolve(this.#substituted(sample, timestamp));
    this.#waiting.clear();
  }
  async #substituted(sample, timestamp) {
    const track = await this.#substitute;
    return track && !this.#closed ? track.submit(sample, timestamp) : null;
  }
  #drop() {
    for (const { resolve } of this.#waiting.values()) resolve(null);
    this.#waiting.clear();
    clearTimeout(this.#timer);
  }
  submit(sample, timestamp) {
    if (this.#substitute) return this.#substituted(sample, timestamp);
    if (this.#broken && !sample.key) return Promise.resolve(null);
    if (!this.#broken && this.#needsKey && !sample.key) return Promise.resolve(null);
    const picture = new Promise((resolve) => this.#waiting.set(timestamp, { resolve, overtaken: 0, sample }));
    try {
      if (this.#broken) {
        this.#broken = false;
        this.#open();
      }
      this.#needsKey = false;
      this.#watch();
      const type = sample.key ? "key" : "delta";
      this.#decoder.decode(new EncodedVideoChunk({ type, timestamp, data: sample.data }));
    } catch (error) {
      this.#break(error);
    }
    return picture;
  }
  async flush() {
    if (this.#substitute) return (await this.#substitute)?.flush();
    if (this.#decoder.state !== "configured" || !this.#waiting.size) return;
    await this.#decoder.flush().catch(() => {});
    if (this.#substitute) return (await this.#substitute)?.flush();
    this.#needsKey = true;
    if (this.#decoder.state === "configured") for (const timestamp of [...this.#waiting.keys()]) this.#lose(timestamp);
    this.#drop();
  }
  close() {
    this.#closed = true;
    this.#drop();
    if (this.#decoder.state !== "closed") this.#decoder.close();
    this.#substitute?.then((track) => track?.close());
  }
}

async function isSupported(layout) {
  if (typeof VideoDecoder !== "function") return false;
  return (await VideoDecoder.isConfigSupported(configurationOf(layout))).supported;
}

class JpegTrack {
  async submit(sample) {
    return createImageBitmap(new Blob([sample.data], { type: "image/jpeg" }), { colorSpaceConversion: "none" });
  }
  async flush() {}
  close() {}
}

/** A track whose decoder is not known yet. When it is closed, pictures that are awaited are null. */
class PendingTrack {
  #found;
  #closing = new AbortController();
  constructor(found) {
    this.#found = found;
  }
  /** What call(track) returns; null: there is no decoder, or it is closed. */
  async #ask(call) {
    const { signal } = this.#closing;
    const answer = this.#found.then((track) => (track && !signal.aborted ? call(track) : null));
    // A picture that comes too late has no other owner.
    answer.then(
      (picture) => signal.aborted && picture?.close(),
      () => {},
    );
    return unlessAborted(answer, signal).catch((error) => {
      if (signal.aborted) return null;
      throw error;
    });
  }
  async submit(sample, timestamp) {
    return this.#ask((track) => track.submit(sample, timestamp));
  }
  async flush() {
    await this.#ask((track) => track.flush());
  }
  close() {
    this.#closing.abort();
    this.#found.then((track) => track?.close());
  }
}

class Pictures {
  #emit;
  #software;
  #tracks = new Map();
  #shape = ""; // of the configured tracks
  #timeBase;
  #last = -1; // timestamp
  #rung = null; // of the last frame
  #failing = new Set(); // codecs, by their string, whose decoder of the browser failed before its first picture

  /** emit(type, error); fallback(): returns the compiled module of decoders; or null. */
  constructor({ emit, fallback, memoryBytes }) {
    this.#emit = emit;
    const corrupt = (error, layout) => this.#corrupt(error, layout);
    this.#software = fallback && new SoftwareVideo({ load: fallback, memoryBytes, corrupt });
  }
  #fail(code, error, layout) {
    const message = `video track ${layout.track} (${layout.codecString || layout.codec}): ${error.message}`;
    this.#emit("warning", FvvError.warning(code, message, error));
  }
  #corrupt(error, { track, codecString }) {
    const message = `video track ${track} (${codecString}): ${error.message}`;
    this.#emit("warning", new FvvError({ code: "invalid", chunk: "VPKT", fatal: false, message, cause: error }));
  }
  configure({ videos, timeBase }) {
    this.#timeBase = timeBase;
    const shape = JSON.stringify(videos, (_, value) => (value instanceof Uint8Array ? Array.from(value) : value));
    if (shape === this.#shape) return;
    this.#shape = shape;
    this.close();
    for (const layout of videos) this.#tracks.set(layout.track, new PendingTrack(this.#find(layout)));
  }
  /** Returns a track, or null after a warning. */
  async #find(layout) {
    try {
      if (layout.codec === "jpeg" && typeof createImageBitmap === "function") return new JpegTrack();
      const { codecString } = layout;
      const isUsable = !(this.#software && this.#failing.has(codecString));
      if (codecString && isUsable && (await isSupported(layout)))
        return new VideoTrack(
          layout,
          (error) => this.#fail("video", error, layout),
          (error) => this.#replace(error, layout),
        );
      if (codecString && this.#software) return await this.#software.open(layout);
      throw new Error("no decoder is available; frames have the samples");
    } catch (error) {
      this.#fail("unsupported", error, layout);
      return null;
    }
  }
  /** Returns the promise of a track in place of one whose decoder failed before its first picture, or null. */
  #replace(error, layout) {
    const { codecString } = layout;
    // Once, not after each seek.
    if (!this.#software && this.#failing.has(codecString)) return null;
    this.#failing.add(codecString);
    const why = new Error(`the browser's decoder fails at its first picture: ${error.message}`, { cause: error });
    this.#fail(this.#software ? "video" : "unsupported", why, layout);
    return this.#software && this.#find(layout);
  }
  /** Decoding continues at another place of the stream. */
  restart() {
    this.#shape = "";
    this.close();
  }
  /** Decoders of another rung's tracks may keep their last pictures until they are flushed. */
  #finishOthers({ rung, tracks }) {
    this.#rung = rung;
    for (const [id, track] of this.#tracks) if (!tracks?.includes(id)) track.flush().catch(() => {});
  }
  /** The pictures of a frame, [{track, picture}], without those that could not be decoded. */
  async submit(frame) {
    if (frame.rung !== this.#rung) this.#finishOthers(frame);
    const { numerator, denominator } = this.#timeBase;
    // In microseconds and unique, because they identify pictures.
    const rounded = Math.round((Number(frame.time) * 1e6 * numerator) / denominator);
    const timestamp = (this.#last = Math.max(this.#last + 1, rounded));
    const all = frame.samples.map(async (sample) => {
      const track = this.#tracks.get(sample.track);
      if (!track) return null;
      try {
        const picture = await track.submit(sample, timestamp);
        return picture && { track: sample.track, picture };
      } catch (error) {
        this.#fail("video", error, { track: sample.track, codec: "" });
        return null;
      }
    });
    return (await Promise.all(all)).filter((picture) => picture !== null);
  }
  async flush() {
    await Promise.all(Array.from(this.#tracks.values(), (track) => track.flush()));
  }
  close() {
    for (const track of this.#tracks.values()) track.close();
    this.#tracks.clear();
  }
}

const none = {
  configure() {},
  restart() {},
  submit: async () => [],
  flush: async () => {},
  close() {},
};

/** video: "decoded" or "encoded". */
export function createPictures(video, options) {
  return video === "decoded" ? new Pictures(options) : none;
}
