// Sound at another speed without another pitch: WSOLA (Verhelst and Roelands, 1993). Frames overlap by half; each is taken
// where it continues the one before best, near its place.

/** Seconds of a frame, and how far its place may be off. */
const FRAME = 0.04;
const REACH = 0.01;
/** Similarity is measured at one sample of this number. */
const STRIDE = 4;

export class Stretch {
  #speed;
  #hop; // half a frame, in samples
  #reach;
  #input; // a Float32Array for each channel
  #dropped = 0; // samples of the input that are no longer kept
  #frames = 0; // that were put out
  #last = 0; // place of the last frame in the input

  /** speed: of playback. */
  constructor(channels, rate, speed) {
    this.#speed = speed;
    this.#hop = Math.round((FRAME * rate) / 2);
    this.#reach = Math.round(REACH * rate);
    this.#input = Array.from({ length: channels }, () => new Float32Array(0));
  }

  /** Samples that were put out. */
  get outputLength() {
    return this.#frames * this.#hop;
  }

  /** Takes samples, and returns those that are ready: a Float32Array for each channel. */
  push(channels) {
    this.#input = this.#input.map((kept, i) => {
      const joined = new Float32Array(kept.length + channels[i].length);
      joined.set(kept);
      joined.set(channels[i], kept.length);
      return joined;
    });
    const out = channels.map(() => []);
    while (this.#end >= this.#place(this.#frames) + this.#reach + 2 * this.#hop) this.#put(out);
    this.#drop();
    return out.map((parts) => join(parts, this.#hop));
  }

  get #end() {
    return this.#dropped + this.#input[0].length;
  }
  #place(frame) {
    return Math.round(frame * this.#hop * this.#speed);
  }

  /** The second half of the last frame fades into the first half of the next one. */
  #put(out) {
    const hop = this.#hop;
    const next = this.#frames === 0 ? 0 : this.#bestPlace(this.#place(this.#frames), this.#last + hop);
    const before = this.#frames === 0 ? next : this.#last + hop;
    this.#input.forEach((samples, i) => {
      const part = new Float32Array(hop);
      const [a, b] = [before - this.#dropped, next - this.#dropped];
      for (let k = 0; k < hop; k++) {
        const weight = 0.5 - 0.5 * Math.cos((Math.PI * (k + 0.5)) / hop);
        part[k] = samples[a + k] * (1 - weight) + samples[b + k] * weight;
      }
      out[i].push(part);
    });
    this.#last = next;
    this.#frames++;
  }

  /** The place near `place` that is most like what follows the last frame, at `natural`. */
  #bestPlace(place, natural) {
    const from = Math.max(place - this.#reach, this.#dropped);
    let [best, most] = [Math.max(place, from), -Infinity];
    for (let at = from; at <= place + this.#reach; at += STRIDE) {
      const likeness = this.#likeness(at - this.#dropped, natural - this.#dropped);
      if (likeness > most) [best, most] = [at, likeness];
    }
    return best;
  }
  #likeness(a, b) {
    let [product, power] = [0, 1e-9];
    for (const samples of this.#input)
      for (let k = 0; k < this.#hop; k += STRIDE) {
        product += samples[a + k] * samples[b + k];
        power += samples[a + k] ** 2;
      }
    return product / Math.sqrt(power);
  }

  #drop() {
    const needed = Math.min(this.#place(this.#frames) - this.#reach, this.#last + this.#hop);
    const count = needed - this.#dropped;
    if (count < this.#hop) return;
    this.#input = this.#input.map((samples) => samples.slice(count));
    this.#dropped += count;
  }
}

function join(parts, length) {
  const out = new Float32Array(parts.length * length);
  parts.forEach((part, i) => out.set(part, i * length));
  return out;
}
