// Sound where WebCodecs has no decoder: Opus by libopus in wasm, npm's opus-decoder, which the caller provides; AAC by
// decodeAudioData, as files of ADTS. Both have the interface of NativeDecoder in sound.js.

import { joined } from "../joined.js";

/** OpusHead (RFC 7845, clause 5.1): where fields are. */
const OPUS = { channels: 9, gain: 16, family: 18, streams: 19, coupled: 20, mapping: 21 };
/** Channels by Vorbis's order, in the order of Web Audio; for each number of channels from 3 on. */
const ORDERS = [
  [0, 2, 1],
  [0, 1, 2, 3],
  [0, 2, 1, 3, 4],
  [0, 2, 1, 5, 3, 4],
  [0, 2, 1, 6, 5, 3, 4],
  [0, 2, 1, 7, 5, 6, 3, 4],
];

/** Options of opus-decoder, and the factor of all samples. */
function opusOptions(record) {
  const channels = record[OPUS.channels];
  const gain = 10 ** (new DataView(record.buffer, record.byteOffset).getInt16(OPUS.gain, true) / 256 / 20);
  // All samples are wanted: times have the delay of the encoder subtracted already.
  const options = { channels, sampleRate: 48000, preSkip: 0 };
  if (record[OPUS.family] === 0) return { options, gain };
  const mapping = Array.from(record.subarray(OPUS.mapping, OPUS.mapping + channels));
  const channelMappingTable = ORDERS[channels - 3]?.map((channel) => mapping[channel]) ?? mapping;
  const [streamCount, coupledStreamCount] = [record[OPUS.streams], record[OPUS.coupled]];
  return { options: { ...options, streamCount, coupledStreamCount, channelMappingTable }, gain };
}

/** Decodes one call after the other. decode(packets): returns samples, {start, channels}. */
class Sequence {
  usable = true;
  #before;
  #output;
  #fail;

  /** ready: when decoding can begin. */
  constructor(ready, { output, fail }) {
    this.#before = ready;
    this.#output = output;
    this.#fail = fail;
  }
  push(decode) {
    this.#before = this.#before.then(async () => {
      if (!this.usable) return;
      const { start, channels } = await decode();
      if (this.usable) this.#output(start, channels);
    });
    this.#before.catch((error) => {
      if (this.usable) this.#fail(error);
      this.usable = false;
    });
  }
  async settled() {
    await this.#before.catch(() => {});
  }
}

export class OpusPackets {
  #decoder;
  #gain;
  #sequence;

  /** OpusDecoder: the class of npm's opus-decoder. */
  constructor(OpusDecoder, { record }, callbacks) {
    const { options, gain } = opusOptions(record);
    this.#gain = gain;
    this.#decoder = new OpusDecoder(options);
    this.#sequence = new Sequence(this.#decoder.ready, callbacks);
  }
  get usable() {
    return this.#sequence.usable;
  }
  decode(packets) {
    this.#sequence.push(() => {
      const { channelData, errors } = this.#decoder.decodeFrames(packets.map(({ data }) => data));
      if (errors.length) throw new Error(errors[0].message);
      if (this.#gain !== 1) for (const samples of channelData) samples.forEach((x, i) => (samples[i] = x * this.#gain));
      return { start: packets[0].start, channels: channelData };
    });
  }
  close() {
    this.#sequence.usable = false;
    // Not while it decodes, nor before it is there.
    this.#sequence
      .settled()
      .then(() => this.#decoder.free())
      .catch(() => {});
  }
}

/** ISO/IEC 14496-3, clauses 1.6.2.1 and 1.A.2.2. */
const AAC_LC = 2;
const RATES = 13;
const HEAD = 7;
const MAX_FRAME = 2 ** 13 - 1;

/** Fields of an AudioSpecificConfig (clause 1.6.2.1); rate: index of the sample rate. */
export const aacFields = (record) => ({
  type: record[0] >> 3,
  rate: ((record[0] & 7) << 1) | (record[1] >> 7),
  channels: (record[1] >> 3) & 15,
});

/** Whether packets with this record can be frames of ADTS, which have 1024 samples. */
export function fitsAdts({ record, packetDuration }) {
  const { type, rate, channels } = aacFields(record);
  return type === AAC_LC && rate < RATES && channels >= 1 && channels <= 7 && packetDuration === 1024;
}

function adtsFrame(record, data) {
  const { type, rate, channels } = aacFields(record);
  const size = HEAD + data.length;
  if (size > MAX_FRAME) throw new Error(`a packet has ${data.length} bytes, more than a frame of ADTS`);
  const frame = new Uint8Array(size);
  frame.set([
    ...[0xff, 0xf1, ((type - 1) << 6) | (rate << 2) | (channels >> 2), ((channels & 3) << 6) | (size >> 11)],
    ...[(size >> 3) & 255, ((size & 7) << 5) | 31, 0xfc],
  ]);
  frame.set(data, HEAD);
  return frame;
}

export class AacPackets {
  #about;
  #context;
  #sequence;
  #last = []; // frames before the next packet, from which it is decoded

  constructor(about, rate, callbacks) {
    this.#about = about;
    this.#context = new OfflineAudioContext(about.channels, 1, rate);
    this.#sequence = new Sequence(Promise.resolve(), callbacks);
  }
  get usable() {
    return this.#sequence.usable;
  }
  decode(packets) {
    const { record, packetDuration, preroll } = this.#about;
    const [start, count] = [packets[0].start, packets.length * packetDuration];
    this.#sequence.push(async () => {
      const frames = [...this.#last, ...packets.map(({ data }) => adtsFrame(record, data))];
      this.#last = frames.slice(-preroll);
      const sound = await this.#context.decodeAudioData(joined(frames).buffer);
      // Some decoders have no output for the first frame of a file.
      const from = Math.max(0, sound.length - count);
      const late = Math.max(0, count - sound.length);
      const channels = Array.from({ length: sound.numberOfChannels }, (_, i) => sound.getChannelData(i).subarray(from));
      return { start: start + late, channels };
    });
  }
  close() {
    this.#sequence.usable = false;
  }
}
