// Packets of sound to samples, by WebCodecs. Each track has a decoder of its own, which goes on from group to group; where
// the sound does not continue it begins again with the packets that the group repeats for that.

import { FvvError } from "./errors.js";

const MICROSECONDS = 1e6;
/** Where the number of samples that an encoder puts before the sound is in the record of Opus. */
const PRE_SKIP = 10;

/** The sample rate by the record: Opus has 48 kHz, AAC says it (ISO/IEC 14496-3, clause 1.6). */
export function sampleRate({ codec, record }) {
  const rates = [96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000, 7350];
  return codec === "opus" ? 48000 : rates[((record[0] & 7) << 1) | (record[1] >> 7)];
}

function configOf({ codec, channels, record }) {
  const description = record.slice();
  // All samples are wanted: times have the delay of the encoder subtracted already.
  if (codec === "opus") description.fill(0, PRE_SKIP, PRE_SKIP + 2);
  const name = codec === "opus" ? "opus" : "mp4a.40.2";
  return { codec: name, sampleRate: sampleRate({ codec, record }), numberOfChannels: channels, description };
}

/** The samples of an AudioData, a Float32Array for each channel. */
function planesOf(data) {
  return Array.from({ length: data.numberOfChannels }, (_, planeIndex) => {
    const plane = new Float32Array(data.numberOfFrames);
    data.copyTo(plane, { planeIndex, format: "f32-planar" });
    return plane;
  });
}

class Track {
  #about;
  #rate;
  #emit;
  #fail;
  #decoder = null;
  #end = null; // sample after the last packet that was decoded
  #begin = 0; // sample from which on the output is right
  #positions = []; // {from, position} of chunks whose samples have not all arrived

  constructor(about, emit, fail) {
    this.#about = about;
    this.#rate = sampleRate(about);
    this.#emit = emit;
    this.#fail = fail;
  }

  take({ start, sizes, prerollCount, position, data }) {
    const { packetDuration, preroll, moves } = this.#about;
    const first = Number(start) + prerollCount * packetDuration;
    const continues = this.#decoder?.state === "configured" && first === this.#end;
    if (!continues) this.#restart(first - Math.max(0, prerollCount - preroll) * packetDuration);
    if (moves) this.#positions.push({ from: first, position });
    let [at, time] = [0, Number(start)];
    sizes.forEach((size, i) => {
      const skipped = continues && i < prerollCount;
      if (!skipped && this.#decoder)
        this.#decoder.decode(
          new EncodedAudioChunk({
            type: "key",
            timestamp: Math.round((time / this.#rate) * MICROSECONDS),
            duration: Math.round((packetDuration / this.#rate) * MICROSECONDS),
            data: data.subarray(at, at + size),
          }),
        );
      at += size;
      time += packetDuration;
    });
    this.#end = time;
  }

  #restart(begin) {
    this.close();
    this.#begin = begin;
    this.#positions = [];
    const decoder = new AudioDecoder({
      output: (data) => {
        if (decoder === this.#decoder) this.#output(data);
        data.close();
      },
      error: (error) => decoder === this.#decoder && this.#fail(error),
    });
    decoder.configure(configOf(this.#about));
    this.#decoder = decoder;
  }

  #output(data) {
    const { track, position } = this.#about;
    const rate = this.#rate;
    const time = Math.round((data.timestamp * rate) / MICROSECONDS);
    const late = Math.max(0, this.#begin - time);
    if (late >= data.numberOfFrames) return;
    const channels = planesOf(data).map((plane) => plane.subarray(late));
    const start = time + late;
    while (this.#positions.length > 1 && this.#positions[1].from <= start) this.#positions.shift();
    const place = this.#positions[0]?.position ?? position;
    this.#emit({ track, start, seconds: start / rate, rate, channels, position: place });
  }

  async flush() {
    await this.#decoder?.flush().catch(() => {});
  }

  close() {
    if (this.#decoder && this.#decoder.state !== "closed") this.#decoder.close();
    this.#decoder = null;
    this.#end = null;
  }
}

export class SoundDecoders {
  #emit;
  #warn;
  #tracks = new Map();
  #warned = new Set();

  /** emit(block): samples, as the event "sound" has them. warn(error): of a track that cannot be decoded. */
  constructor({ emit, warn }) {
    this.#emit = emit;
    this.#warn = warn;
  }

  /** sounds: of a configuration. */
  configure(sounds) {
    this.close();
    for (const about of sounds) this.#open(about);
  }

  async #open(about) {
    if (typeof AudioDecoder !== "function")
      return this.#refuse(about, `this browser has no AudioDecoder of WebCodecs: track ${about.track} is silent`);
    const track = new Track(about, this.#emit, (error) => {
      this.#tracks.delete(about.track);
      this.#refuse(about, `sound of track ${about.track} cannot be decoded: ${error.message}`);
    });
    this.#tracks.set(about.track, track);
    const { supported } = await AudioDecoder.isConfigSupported(configOf(about)).catch(() => ({ supported: false }));
    if (supported || this.#tracks.get(about.track) !== track) return;
    track.close();
    this.#tracks.delete(about.track);
    this.#refuse(about, `this browser does not decode sound of codec ${about.codec}: track ${about.track} is silent`);
  }

  #refuse({ track }, message) {
    if (this.#warned.has(track)) return;
    this.#warned.add(track);
    this.#warn(FvvError.warning("unsupported", message));
  }

  /** chunks: in the order of the stream. */
  take(chunks) {
    for (const chunk of chunks)
      try {
        this.#tracks.get(chunk.track)?.take(chunk);
      } catch (error) {
        this.#tracks.get(chunk.track).close();
        this.#tracks.delete(chunk.track);
        this.#refuse(chunk, `sound of track ${chunk.track} cannot be decoded: ${error.message}`);
      }
  }

  /** After a seek nothing continues. */
  restart() {
    for (const track of this.#tracks.values()) track.close();
  }

  /** Resolves when all samples of the packets so far were emitted. */
  async flush() {
    await Promise.all([...this.#tracks.values()].map((track) => track.flush()));
  }

  close() {
    this.restart();
    this.#tracks.clear();
  }
}
