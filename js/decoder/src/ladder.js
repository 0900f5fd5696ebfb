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
  // The best of each; then a rung for each rank of another track. A group without a track of that rank gives the next better one.
  const lower = Array.from(alternatives.values(), (ranked) => ranked.slice(1).map(({ rank }) => rank)).flat();
  return [-1, ...new Set(lower.sort((a, b) => a - b))].map((rank, rung) => {
    const taken = tracks.filter((track) => {
      const ranked = alternatives.get(track.alternateGroup);
      return !ranked || (ranked.findLast((one) => one.rank <= rank) ?? ranked[0]) === track;
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
/** Round trips and what a computer does for a request: a transfer of up to this many times its latency is held up by them. */
const HELD_UP = 3;
/** Of the buffer, that a group may take to arrive whose rung is tried. */
const TRIED = 0.5;
/** BOLA takes over at this many seconds if it chooses nothing worse, as in the second paper, and is left below the second number. */
const BOLA_FROM = 6;
const BOLA_UNTIL = 3;
/** Seconds of buffer at which BOLA takes the lowest rung. */
const BOLA_LOWEST = 2;

export class Chooser {
  #throughput = new Throughput();
  #byBuffer = false;
  #isHeldUp = false; // the last group, by round trips
  #beginning = () => {}; // what was measured before the first choice
  #hasChosen = false;
  /** Seconds that are read ahead, at which BOLA takes the best rung. */
  target;

  constructor({ target = 12 } = {}) {
    this.target = target;
  }
  get throughput() {
    return this.#throughput.value;
  }
  /**
   * bytes that came in seconds; latency: those of them that round trips alone take. Small parts of a file say little of a
   * fast network.
   */
  measured(bytes, seconds, latency = 0) {
    this.#isHeldUp = seconds < HELD_UP * latency;
    if (!this.#isHeldUp || (8 * bytes) / seconds > this.throughput) this.#throughput.add(bytes, seconds);
  }
  /** The same of the first bytes of a stream: however fast they come, it begins with the lowest rung. */
  began(bytes, seconds) {
    if (this.#hasChosen) this.measured(bytes, seconds);
    else this.#beginning = () => this.measured(bytes, seconds);
  }

  /**
   * bits: of the next group in each rung, best first. seconds: its duration. buffer: seconds of playback that have arrived.
   * best: the best rung that may be taken. Returns {rung, reason}.
   */
  choose({ bits, seconds, buffer, best = 0 }) {
    const lowest = bits.length - 1;
    const affordable = this.#affordable(bits, seconds, buffer);
    if (!this.#hasChosen) this.#beginning();
    this.#hasChosen = true;
    if (affordable === null) return { rung: lowest, reason: "start" };
    const full = this.#bola(bits, buffer);
    this.#byBuffer = this.#byBuffer ? buffer >= BOLA_UNTIL : buffer >= BOLA_FROM && full <= affordable;
    const rung = this.#byBuffer ? full : affordable;
    return { rung: Math.max(best, rung), reason: this.#byBuffer ? "buffer" : "throughput" };
  }
  /** The best of these bit rates that the network carries, by what was measured; null: nothing was. */
  carries(rates) {
    const { value } = this.#throughput;
    if (value === null) return null;
    const found = rates.findIndex((rate) => rate <= SAFETY * value);
    return found < 0 ? rates.length - 1 : found;
  }
  /** The best rung that arrives as fast as it is played; null: the throughput is not known. */
  #affordable(bits, seconds, buffer) {
    const { value } = this.#throughput;
    const rung = this.carries(bits.map((size) => size / seconds));
    if (rung === null) return null;
    // The network may carry more than was measured: a better rung shows it, if the buffer lasts.
    const isTried = this.#isHeldUp && rung > 0 && bits[rung - 1] / value <= TRIED * buffer;
    return isTried ? rung - 1 : rung;
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

/** Seconds of a standing queue, the least delay within an interval, at which a lower rung is taken, and below which a better one is tried. */
const QUEUE_HIGH = 0.25;
const QUEUE_LOW = 0.1;
const INTERVAL = 1;
/** Seconds within which the delay of an empty network was seen. */
const MEMORY = 15;
/** Seconds without a queue before a better rung is tried: the first value, and after failures the last. */
const PATIENCE = 4;
const PATIENCE_MAX = 64;
/** A rung that fails within this many seconds was a failure. */
const TRIAL = 10;

/**
 * The choice for a live stream, which comes as fast as it is made: what the network could carry does not show, only whether
 * it carries this. So the delay of frames decides, as in Google's congestion control for WebRTC (Carlucci, De Cicco, Holmer
 * and Mascolo, "Congestion Control for Web Real-Time Communication", 2017), with the least delay of an interval for the
 * queue, as in CoDel (Nichols and Jacobson, "Controlling Queue Delay", 2012): key frames alone are no queue. Times are in seconds.
 */
export class LiveChooser {
  #arrivals = []; // {now, delay, bits} of two intervals
  #least = [Infinity, Infinity]; // delay, of this and the last span of MEMORY
  #since = null; // when that span began
  #changed = 0; // when the rung changed, or there was a queue
  #patience = new Map(); // rung -> seconds
  #rung = null;
  #tried = null; // {rung, at}: taken without knowing that the network carries it

  /** bytes of a frame with a time in the stream have come. */
  arrived(bytes, time, now) {
    const delay = now - time;
    if (this.#since === null || now - this.#since > MEMORY) {
      this.#least = [delay, this.#since === null ? delay : this.#least[0]];
      this.#since = now;
    }
    this.#least[0] = Math.min(this.#least[0], delay);
    this.#arrivals.push({ now, delay, bits: 8 * bytes });
    while (this.#arrivals[0].now < now - 2 * INTERVAL) this.#arrivals.shift();
  }
  /** The times of another stream follow. */
  restart() {
    this.#arrivals = [];
    this.#since = null;
  }
  /** Bits per second that have come; null: not known. */
  get throughput() {
    const span = this.#arrivals.length ? this.#arrivals.at(-1).now - this.#arrivals[0].now : 0;
    if (span < INTERVAL) return null;
    return this.#arrivals.slice(1).reduce((sum, { bits }) => sum + bits, 0) / span;
  }
  /** The least delay between two ages, beyond that of an empty network. */
  #queue(now, from, until) {
    const delays = this.#arrivals.filter((one) => one.now > now - from && one.now <= now - until);
    return Math.min(...delays.map(({ delay }) => delay)) - Math.min(...this.#least);
  }

  /** rates: bits per second, best rung first; rung: the one that comes; best: the best that may be taken. */
  choose({ rates, rung, best = 0, now }) {
    if (rung !== this.#rung) [this.#rung, this.#changed] = [rung, now];
    if (rung < best) return Math.min(best, rates.length - 1);
    const queue = this.#queue(now, INTERVAL, 0);
    const before = this.#queue(now, 2 * INTERVAL, INTERVAL);
    if (queue > QUEUE_LOW) this.#changed = now;
    const grows = queue > QUEUE_HIGH && queue >= before && Number.isFinite(before);
    return grows ? this.#lower(rates, rung, now) : this.#better(rung, best, now);
  }
  #lower(rates, rung, now) {
    if (this.#tried?.rung === rung && now - this.#tried.at < TRIAL)
      this.#patience.set(rung, Math.min(PATIENCE_MAX, 2 * this.#patienceOf(rung)));
    this.#tried = null;
    const affordable = rates.findIndex((rate) => rate > 0 && rate <= SAFETY * this.throughput);
    return Math.min(rates.length - 1, Math.max(rung + 1, affordable < 0 ? rates.length - 1 : affordable));
  }
  #patienceOf(rung) {
    return this.#patience.get(rung) ?? PATIENCE;
  }
  #better(rung, best, now) {
    if (this.#tried?.rung === rung && now - this.#tried.at > TRIAL) {
      this.#patience.delete(rung);
      this.#tried = null;
    }
    if (rung <= best || now - this.#changed < this.#patienceOf(rung - 1)) return rung;
    this.#tried = { rung: rung - 1, at: now };
    return rung - 1;
  }
}
