// A fake decoder whose frames are numbers, and a media element with a simulated clock. The test sets the duration of
// decoding and showing.

import { Media } from "../src/playback/media.js";

const RATE = 25;
const GROUP = 10;

class FakeDecoder extends EventTarget {
  #next = 0;
  #place = 0;
  inWorker = true;
  configuration = null;
  closed = false;

  /**
   * restartAfter: number of frames after which times restart at 0. groups: [{start, end, first, count}] in ticks. gap: {before, ticks}:
   * times that are lost before a frame.
   */
  constructor(world, { count = 50, seekable = true, restartAfter = Infinity, groups = null, gap = null } = {}) {
    super();
    Object.assign(this, { world, count, seekable, restartAfter, gap, frameCount: seekable ? count : null });
    let firstFrame = 0;
    const listed = groups?.map(({ start, end, count: frameCount, first = start }) => {
      firstFrame += frameCount;
      return {
        start: BigInt(start),
        end: BigInt(end),
        size: 1000n,
        firstFrame: firstFrame - frameCount,
        frameCount,
        first,
      };
    });
    this.groups = listed
      ? listed
      : seekable
        ? Array.from({ length: Math.ceil(count / GROUP) }, (_, i) => ({
            start: BigInt(i * GROUP),
            end: BigInt(Math.min(count, (i + 1) * GROUP)),
            size: 1000n,
            firstFrame: i * GROUP,
            frameCount: Math.min(GROUP, count - i * GROUP),
          }))
        : null;
  }

  async next() {
    const { world } = this;
    if (this.broken) throw this.broken;
    if (this.#next >= this.count) return null;
    const number = this.#next++;
    const place = this.#place;
    if (world.decodeMs > 0) await world.wait(world.decodeMs);
    // After a seek the worker responds with frames of the new place.
    if (place !== this.#place) return this.next();
    // Live: not before it was captured.
    if (this.madeAt) await world.waitUntil(this.madeAt(number));
    world.open++;
    world.mostOpen = Math.max(world.mostOpen, world.open);
    let closed = false;
    const group = this.groups?.findLast(({ firstFrame, frameCount }) => frameCount && firstFrame <= number);
    const { before = Infinity, ticks } = this.gap ?? {};
    if (number === before) this.#report({ code: "gap", severity: "warning", to: BigInt(number + ticks) });
    const lost = number < before ? 0 : ticks;
    const tick =
      group?.first === undefined ? (number + lost) % this.restartAfter : group.first + number - group.firstFrame;
    return {
      number,
      seconds: tick / RATE,
      edgeSeconds: this.arrived ? this.arrived() / RATE : null,
      group: group ?? { end: BigInt(tick + 1) },
      duration: 1 / RATE,
      decodeMs: 1,
      samples: [{}],
      pictures: world.lost(number) ? [] : [{}],
      rung: world.rung,
      configuration: { timeBase: { numerator: 1, denominator: RATE } },
      close: () => {
        if (!closed) world.open--;
        closed = true;
      },
    };
  }
  /** Live: the first frame. */
  from(number) {
    this.#next = number;
  }
  #report(detail) {
    this.dispatchEvent(Object.assign(new Event("warning"), { detail }));
  }
  async seek({ frame, seconds }) {
    this.world.seeks++;
    await this.world.wait(0);
    this.#place++;
    const tick = Math.floor(seconds * RATE + 1e-6);
    const group = this.groups?.findLast(({ frameCount, start }) => frameCount && start <= tick);
    const within =
      group?.first === undefined
        ? tick
        : group.firstFrame + Math.min(Math.max(tick - group.first, 0), group.frameCount - 1);
    this.#next = frame ?? Math.min(within, this.count - 1);
  }
  rung = "auto";
  async lastingRung() {
    return this.world.lastingRung;
  }
  async stats() {
    return { bytesRead: 100 * this.#next, memoryBytes: 1, queued: 0 };
  }
  /** Set by tests. */
  bufferedTimes = [];
  async buffered() {
    return this.bufferedTimes;
  }
  close() {
    this.closed = true;
  }
}

/** The simulated clock: advances in steps of 4 ms and runs timers that are due. */
export class World {
  now = 0;
  decodeMs = 0;
  showMs = 0;
  open = 0;
  mostOpen = 0;
  seeks = 0;
  /** lost(number): whether the picture of a frame is lost. */
  lost = () => false;
  /** Of the frames that come, and what the decoder says of frames that stay. */
  rung = null;
  lastingRung = null;
  shown = [];
  /** Whether a source that was opened had been open before. */
  known = [];
  events = [];
  #timers = [];
  #ticking = false;

  media(options = {}) {
    const decoders = (this.decoders = []);
    const media = new Media({
      now: () => this.now,
      wake: () => (this.#ticking = true),
      open: async (source, isKnown) => {
        this.known.push(isKnown);
        const decoder = new FakeDecoder(this, options);
        options.prepare?.(decoder, decoders.length);
        decoders.push(decoder);
        return decoder;
      },
      show: async (frame) => {
        if (this.showMs > 0) await this.wait(this.showMs);
        const { number, rung, pictures } = frame;
        this.shown.push({ number, rung, pictures: pictures.length, at: this.now });
        return true;
      },
      vacate: () => this.shown.push({ number: null, at: this.now }),
      screen: options.screen,
    });
    const types =
      "loadstart loadedmetadata loadeddata durationchange canplay canplaythrough play playing pause seeking seeked waiting " +
      "stalled suspend ended ratechange error emptied abort progress";
    for (const type of types.split(" ")) media.addEventListener(type, () => this.events.push(type));
    this.current = media;
    return media;
  }

  waitUntil(time) {
    return new Promise((done) => this.#timers.push({ time, done }));
  }
  wait(milliseconds) {
    return this.waitUntil(this.now + milliseconds);
  }
  /** Lets all pending promises settle. */
  async settle() {
    for (let i = 0; i < 3; i++) await new Promise((done) => setImmediate(done));
  }
  async advance(milliseconds) {
    const end = this.now + milliseconds;
    await this.settle();
    while (this.now < end) {
      this.now += 4;
      for (const timer of this.#timers.filter(({ time }) => time <= this.now)) {
        this.#timers.splice(this.#timers.indexOf(timer), 1);
        timer.done();
      }
      await this.settle();
      if (this.now % 16 === 0 && this.#ticking) this.#ticking = this.current.tick();
    }
    await this.settle();
  }
  take() {
    return this.events.splice(0);
  }
  numbers() {
    return this.shown.splice(0).map(({ number }) => number);
  }
}

/** A media element that has shown the first frame. */
export async function ready(options) {
  const world = new World();
  const media = world.media(options);
  media.load("clip", options);
  await world.advance(40);
  return { world, media };
}
