// Packets of sound to samples, by WebCodecs, or where that has no decoder by others (software_sound.js). Each track has a
// decoder of its own, which goes on from group to group; where the sound does not continue it begins again with the packets
// that the group repeats for that.

import { FvvError } from "../errors.js";
import { aacFields, AacPackets, fitsAdts, OpusPackets } from "./software_sound.js";

const MICROSECONDS = 1e6;
/** Where the number of samples that an encoder puts before the sound is in the record of Opus. */
const PRE_SKIP = 10;

/** The sample rate by the record: Opus has 48 kHz, AAC says it (ISO/IEC 14496-3, clause 1.6). */
export function sampleRate({ codec, record }) {
  const rates = [96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000, 7350];
  return codec === "opus" ? 48000 : rates[aacFields(record).rate];
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

/** The AudioDecoder of WebCodecs. */
class NativeDecoder {
  #about;
  #rate;
  #decoder;

  /** output(start, channels): samples from the sample with this number on. fail(error): nothing follows. */
  constructor(about, { output, fail }) {
    this.#about = about;
    this.#rate = sampleRate(about);
    this.#decoder = new AudioDecoder({
      output: (data) => {
        output(Math.round((data.timestamp * this.#rate) / MICROSECONDS), planesOf(data));
        data.close();
      },
      error: fail,
    });
    this.#decoder.configure(configOf(about));
  }
  get usable() {
    return this.#decoder.state === "configured";
  }
  /** packets: [{start, data}] without a gap. */
  decode(packets) {
    const microseconds = (samples) => Math.round((samples / this.#rate) * MICROSECONDS);
    const duration = microseconds(this.#about.packetDuration);
    for (const { start, data } of packets)
      this.#decoder.decode(new EncodedAudioChunk({ type: "key", timestamp: microseconds(start), duration, data }));
  }
  close() {
    if (this.#decoder.state !== "closed") this.#decoder.close();
  }
}

/** Returns a function that creates a decoder with such callbacks. Throws an Error if there is none. */
async function chooseDecoder(about, soundFallback) {
  const { codec } = about;
  const hasNative = typeof AudioDecoder === "function";
  const isSupported = () => AudioDecoder.isConfigSupported(configOf(about)).catch(() => ({ supported: false }));
  if (hasNative && (await isSupported()).supported) return (callbacks) => new NativeDecoder(about, callbacks);
  if (codec === "opus" && soundFallback) {
    const { OpusDecoder } = await soundFallback();
    return (callbacks) => new OpusPackets(OpusDecoder, about, callbacks);
  }
  if (codec !== "opus" && typeof OfflineAudioContext === "function" && fitsAdts(about))
    return (callbacks) => new AacPackets(about, sampleRate(about), callbacks);
  if (hasNative) throw new Error(`this browser does not decode sound of codec ${codec}`);
  throw new Error("there is no AudioDecoder of WebCodecs here");
}

class Track {
  #about;
  #rate;
  #emit;
  #fail;
  #make = null;
  #waiting = []; // chunks that arrived before there was a decoder
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

  /** make: as chooseDecoder returns it. */
  begin(make) {
    this.#make = make;
    for (const chunk of this.#waiting.splice(0)) this.take(chunk);
  }

  take(chunk) {
    if (!this.#make) {
      this.#waiting.push(chunk);
      return;
    }
    const { start, sizes, prerollCount, position, data } = chunk;
    const { packetDuration, preroll, moves } = this.#about;
    const first = Number(start) + prerollCount * packetDuration;
    const continues = this.#decoder?.usable && first === this.#end;
    if (!continues) this.#restart(first - Math.max(0, prerollCount - preroll) * packetDuration);
    if (moves) this.#positions.push({ from: first, position });
    const packets = [];
    let [at, time] = [0, Number(start)];
    sizes.forEach((size, i) => {
      if (!continues || i >= prerollCount) packets.push({ start: time, data: data.subarray(at, at + size) });
      at += size;
      time += packetDuration;
    });
    this.#end = time;
    this.#decoder.decode(packets);
  }

  #restart(begin) {
    this.close();
    this.#begin = begin;
    this.#positions = [];
    const decoder = this.#make({
      output: (start, channels) => decoder === this.#decoder && this.#output(start, channels),
      fail: (error) => decoder === this.#decoder && this.#fail(error),
    });
    this.#decoder = decoder;
  }

  #output(time, planes) {
    const { track, position } = this.#about;
    const rate = this.#rate;
    const late = Math.max(0, this.#begin - time);
    if (late >= planes[0].length) return;
    const channels = planes.map((plane) => plane.subarray(late));
    const start = time + late;
    while (this.#positions.length > 1 && this.#positions[1].from <= start) this.#positions.shift();
    const place = this.#positions[0]?.position ?? position;
    this.#emit({ track, start, seconds: start / rate, rate, channels, position: place });
  }

  close() {
    this.#decoder?.close();
    this.#decoder = null;
    this.#end = null;
    this.#waiting = [];
  }
}

export class SoundDecoders {
  #emit;
  #warn;
  #fallback;
  #tracks = new Map();
  #warned = new Set();

  /**
   * emit(block): samples, as the event "sound" has them. warn(error): of a track that cannot be decoded. fallback(): imports
   * a decoder of Opus, as the option soundFallback does.
   */
  constructor({ emit, warn, fallback }) {
    this.#emit = emit;
    this.#warn = warn;
    this.#fallback = fallback;
  }

  /** sounds: of a configuration. */
  configure(sounds) {
    this.close();
    for (const about of sounds) this.#open(about);
  }

  async #open(about) {
    const refuse = (message) => {
      if (this.#tracks.get(about.track) !== track) return;
      track.close();
      this.#tracks.delete(about.track);
      this.#refuse(about, message);
    };
    const fail = ({ message }) => refuse(`sound of track ${about.track} cannot be decoded: ${message}`);
    const track = new Track(about, this.#emit, fail);
    this.#tracks.set(about.track, track);
    try {
      const make = await chooseDecoder(about, this.#fallback);
      if (this.#tracks.get(about.track) === track) track.begin(make);
    } catch ({ message }) {
      refuse(`${message}: track ${about.track} is silent`);
    }
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

  close() {
    this.restart();
    this.#tracks.clear();
  }
}
