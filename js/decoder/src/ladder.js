// The rungs of a stream (clause 5.2 of spec/fvv.md), and which one is read next.
//
// The choice is that of dash.js' rule DYNAMIC: by throughput while little is buffered, else by BOLA (Spiteri, Urgaonkar and
// Sitaraman, "BOLA: Near-Optimal Bitrate Adaptation for Online Videos", 2016; Spiteri, Sitaraman and Sparacio, "From Theory to
// Practice: Improving Bitrate Adaptation in the DASH Reference Player", 2018). A group that would arrive too late is abandoned.

/** Tracks of the rungs of a configuration, best first: [{rung, bitRate, size, scale, tracks}]; one entry without a ladder. */
export function rungsOf({ tracks, videos }) {
  const alternatives = new Map();
  for (const track of tracks.filter(({ alternateGroup }) => alternateGroup)) {
    const ranked = alternatives.get(track.alternateGroup) ?? [];
    alternatives.set(
      track.alternateGroup,
      [...ranked, track].sort((a, b) => a.rank - b.rank),
    );
  }
  const count = Math.max(1, ...Array.from(alternatives.values(), (ranked) => ranked.length));
  return Array.from({ length: count }, (_, rung) => {
    const taken = tracks.filter((track) => {
      const ranked = alternatives.get(track.alternateGroup);
      return !ranked || ranked[Math.min(rung, ranked.length - 1)] === track;
    });
    const shown = videos.filter(({ track }) => taken.some(({ id }) => id === track));
    return {
      rung,
      bitRate: taken.reduce((sum, { bitRate }) => sum + bitRate, 0),
      size: taken.reduce((sum, { kind, size }) => sum + (kind === "video" ? size : 0), 0),
      scale: scaleOf(shown.flatMap(({ tiles }) => tiles)),
      tracks: taken.map(({ id }) => id),
    };
  });
}

const area = (tiles, side) => tiles.reduce((sum, tile) => sum + tile[side].width * tile[side].height, 0);
/** Pixels of the video for a pixel of the cameras' pictures, along one axis; null: there are no tiles. */
const scaleOf = (tiles) => (tiles.length ? Math.sqrt(area(tiles, "destination") / area(tiles, "source")) : null);

/** Weighted means of what was measured, with half-lives in seconds of transfer: the lower one counts. */
const HALF_LIVES = [2, 8];
/** Shorter transfers say more about latency than about throughput. */
const LEAST_BYTES = 4096;

export class Throughput {
  #means = HALF_LIVES.map(() => ({ sum: 0, weight: 0 }));
  #least = 0;

  /** bytes that came in seconds of waiting for them. */
  add(bytes, seconds) {
    if (bytes < LEAST_BYTES || !(seconds > 0)) return;
    this.#least = 1;
    for (const [i, mean] of this.#means.entries()) {
      const kept = 0.5 ** (seconds / HALF_LIVES[i]);
      mean.sum = kept * mean.sum + (1 - kept) * ((8 * bytes) / seconds);
      mean.weight = kept * mean.weight + (1 - kept);
    }
  }
  /** Bits per second; null: nothing was measured. */
  get value() {
    return this.#least ? Math.min(...this.#means.map(({ sum, weight }) => sum / weight)) : null;
  }
}

/** Of the throughput, that may be used. */
const SAFETY = 0.85;
/** BOLA takes over at this many seconds, and is left below the second number. */
const BOLA_FROM = 6;
const BOLA_UNTIL = 3;
/** Seconds of buffer at which BOLA takes the lowest rung. */
const BOLA_LOWEST = 2;

export class Chooser {
  #throughput = new Throughput();
  #byBuffer = false;
  /** Seconds that are read ahead, at which BOLA takes the best rung. */
  target;

  constructor({ target = 12 } = {}) {
    this.target = target;
  }
  get throughput() {
    return this.#throughput.value;
  }
  measured(bytes, seconds) {
    this.#throughput.add(bytes, seconds);
  }

  /**
   * bits: of the next group in each rung, best first. seconds: its duration. buffer: seconds of playback that have arrived.
   * best: the best rung that may be taken. Returns {rung, reason}.
   */
  choose({ bits, seconds, buffer, best = 0 }) {
    const lowest = bits.length - 1;
    const affordable = this.#affordable(bits, seconds);
    if (affordable === null) return { rung: lowest, reason: "start" };
    this.#byBuffer = this.#byBuffer ? buffer >= BOLA_UNTIL : buffer >= BOLA_FROM;
    const rung = this.#byBuffer ? this.#bola(bits, buffer) : affordable;
    return { rung: Math.max(best, rung), reason: this.#byBuffer ? "buffer" : "throughput" };
  }
  /** The best rung that arrives as fast as it is played; null: the throughput is not known. */
  #affordable(bits, seconds) {
    const { value } = this.#throughput;
    if (value === null) return null;
    const found = bits.findIndex((size) => size / seconds <= SAFETY * value);
    return found < 0 ? bits.length - 1 : found;
  }
  /** The rung with the most utility for each bit, less what the buffer lacks: V (v + g) - Q over S, as in the paper. */
  #bola(bits, buffer) {
    const least = bits.at(-1);
    const utilities = bits.map((size) => Math.log(size / least) + 1);
    const g = (utilities[0] - 1) / (this.target / BOLA_LOWEST - 1);
    if (!(g > 0)) return 0;
    const V = BOLA_LOWEST / g;
    const scores = bits.map((size, i) => (V * (utilities[i] + g) - buffer) / size);
    return scores.indexOf(Math.max(...scores));
  }

  /**
   * Whether a group that is arriving should be replaced by its lowest rung: it would arrive after the buffer is empty, and
   * the lowest rung would arrive earlier. bits that are missing; lowest: bits of the group in the lowest rung.
   */
  abandons({ missing, lowest, buffer, throughput = this.throughput }) {
    return throughput !== null && missing / throughput > Math.max(buffer, 0.5) && lowest < missing;
  }
}
