// Frames of one decoder in their time: shows the one that is due, searches, loops, steps, follows a live edge. What a
// media element tells of it is not its business: it says so to its host.

import { Supply } from "./frame_queue.js";
import { groupAt, union } from "./ranges.js";
import { Clock, LiveEdge, whatIsDue } from "./timing.js";

/** Milliseconds that a search may go on when another is asked for: less, and nothing shows while one scrubs. */
const SEARCH_PATIENCE = 250;
/** Milliseconds that the supply may be empty before playing waits for it, and after which a frame came from afar. */
const STALL = 250;
const WAITED = 12;
const EPSILON = 1e-6;
/** Milliseconds that a frame stays on screen rather than one without its pictures. */
const KEEP = 1000;
/** Decoders of video lose pictures, also where a machine is too busy to answer in time. */
const lacksPictures = ({ pictures, samples }) => pictures.length < samples.length;

export class Playout {
  #show;
  #now;
  #host;
  #meter;
  #supply;
  #clock;
  #edge = new LiveEdge();
  #running = false;
  #stalled = false;
  #closed = false;
  #learned = false;
  #wrapped = false; // the supply is at the beginning of the loop already
  #goal = null; // what is sought last: {place, position, number}
  #search = null; // what is searched for at the moment: {goal, began}
  #patience = null;
  #taken = 0; // seconds where the last frame ends that was shown or dropped
  #shownAt = -Infinity;
  #rate = 1;
  #groups = [];
  #seconds = null; // of ticks
  #held = [];
  #again = false; // pictures of the first frame were asked for again
  #whole = false; // the frame on screen has its pictures
  live = false;
  loop = false;
  /** {from, to} in seconds, or null. */
  range = null;
  /** {number, seconds, duration} of the frame on screen. */
  shown = null;
  start = 0;
  end = Infinity;

  /**
   * show(frame): answers when the frame may be closed. host: {metadata, duration, ready, shown, seeking, sought, behind,
   * drained, ended, failed, wake}; ready(1): the frame of the place is missing, (2): the next one, (4): nothing.
   */
  constructor({ decoder, show, now, host, meter, live }) {
    Object.assign(this, { decoder, live });
    this.#show = show;
    this.#now = now;
    this.#host = host;
    this.#meter = meter;
    this.#clock = new Clock(now);
    this.#supply = new Supply(
      decoder,
      (frame) => this.#arrive(frame),
      (error) => host.failed(error),
      now,
    );
    // Of some sources it is known in the end how long they are.
    decoder.addEventListener("groups", () => this.#seconds && this.#learnGroups());
  }

  begin() {
    this.#supply.want();
  }

  get position() {
    return Math.min(Math.max(this.#clock.position, this.start), this.#limit);
  }
  get running() {
    return this.#running;
  }
  set running(running) {
    this.#running = running;
    this.#synchronise();
    this.#evaluate();
  }
  set rate(rate) {
    this.#rate = rate;
    this.#clock.rate = rate;
  }
  /** Frames of which the pictures are open in this thread: one that is shown, or two that come next. */
  get heldFrames() {
    return this.#supply.held;
  }
  get behind() {
    return this.live ? this.#edge.behind(this.position, this.#now()) : 0;
  }
  get groups() {
    return this.#groups;
  }

  /** Up to where time goes on without another frame. */
  get #limit() {
    if (this.#search || !this.shown) return Infinity;
    if (this.#wrapped) return this.#wrapAt;
    if (this.#supply.frame && this.#supply.settled) return Infinity;
    return this.#taken;
  }
  /** The frame that is due has not come for a while. */
  get #missing() {
    return this.#supply.waited > STALL && this.#clock.position > this.#limit;
  }
  get #inRange() {
    return this.range !== null && (!this.shown || this.shown.seconds < this.range.to - EPSILON);
  }
  get #wrapAt() {
    return this.#inRange ? Math.min(this.range.to, this.#taken) : Math.min(this.end, this.#taken);
  }
  get #wraps() {
    return this.decoder.seekable && (this.loop || this.range !== null);
  }

  #synchronise() {
    if (this.#running && !this.#stalled && !this.#search && this.shown) this.#clock.start();
    else this.#clock.stop();
  }

  #arrive(frame) {
    if (frame && this.live) this.#edge.observe(frame.seconds, this.#now(), this.#supply.waited > WAITED);
    if (frame && !this.#learned) this.#learn(frame);
    this.#evaluate();
    this.#host.wake();
  }

  #learn(frame) {
    this.#learned = true;
    const { timeBase } = frame.configuration;
    this.#seconds = (ticks) => (Number(ticks) * timeBase.numerator) / timeBase.denominator;
    this.start = frame.seconds;
    this.#learnGroups();
    if (!this.#goal) this.#clock.position = frame.seconds;
    this.#host.metadata(frame);
  }
  #learnGroups() {
    const { groups } = this.decoder;
    if (!groups) return;
    const seconds = this.#seconds;
    this.#groups = groups
      .filter(({ frameCount }) => frameCount)
      .map(({ start, end, firstFrame }) => ({ start: seconds(start), end: seconds(end), firstFrame }));
    this.start = this.#groups[0]?.start ?? this.start;
    if (!this.live) this.end = this.#groups.at(-1)?.end ?? Infinity;
    this.#host.duration();
  }

  /** Called for each picture of the screen while it plays. */
  tick() {
    if (this.live && this.#running && !this.#search) this.#follow();
    this.#evaluate();
  }

  #follow() {
    const { behind } = this;
    const hurry = this.#rate === 1 ? this.#edge.rateFor(behind) : 1;
    this.#clock.rate = this.#rate * hurry;
    if (this.#rate >= 1) this.#host.behind(behind);
  }

  #evaluate() {
    const supply = this.#supply;
    if (supply.showing || this.#closed || !supply.settled) return;
    const { frame, ended } = supply;
    if (this.#search) this.#answer(frame, ended);
    else if (!this.shown) {
      if (frame && this.#asksAgain(frame, this.#again)) this.#again = true;
      else if (frame) this.#present();
      else if (ended) this.#host.failed(new Error("there are no frames in this stream"));
    } else {
      if (frame || ended) this.#unstall();
      if (this.#running) this.#play(frame, ended);
    }
    if (supply.ended && !supply.showing && !this.#wrapped) this.#host.drained();
    supply.want();
  }

  #unstall() {
    this.#stalled = false;
    this.#synchronise();
    this.#host.ready(4);
  }

  #play(frame, ended) {
    if (!this.#wrapped && this.#wraps && (ended || (this.#inRange && frame?.seconds >= this.range.to - EPSILON)))
      return this.#wrap();
    if (this.#wrapped) return this.#playWrapped(frame);
    if (frame) return this.#playNext(frame);
    if (ended) {
      // Where there is no index, the end is known when it comes.
      this.end = Math.min(this.end, Math.max(this.#taken, this.#groups.at(-1)?.end ?? 0));
      if (this.#clock.position >= this.end - EPSILON) this.#finish();
    } else if (this.#missing) this.#stall();
  }

  #finish() {
    this.#clock.position = this.end;
    this.#host.ended();
  }

  #stall() {
    if (this.#stalled) return;
    this.#clock.position = this.#limit;
    this.#stalled = true;
    this.#synchronise();
    this.#host.ready(2);
  }

  #playNext(frame) {
    // Time that goes back: a live stream that began anew.
    if (frame.seconds < this.shown.seconds) this.#clock.position = frame.seconds;
    const { position, rate } = this.#clock;
    // Where decoding is what takes long, a frame that is not shown makes no other one come sooner.
    const last = frame.number + 1 === this.decoder.frameCount;
    const spared = !last && this.#supply.waited * rate < 1000 * frame.duration;
    const sinceShown = this.#now() - this.#shownAt;
    let due = whatIsDue(frame, position, rate, spared ? sinceShown : Infinity);
    if (due === "show" && this.#whole && lacksPictures(frame) && sinceShown < KEEP) due = "drop";
    if (due === "show") this.#present();
    if (due === "drop") {
      const dropped = this.#supply.shift();
      this.#taken = dropped.seconds + dropped.duration;
      dropped.close();
      this.#meter.dropped();
    }
    if (due === "lag" && !this.#leap(frame)) {
      this.#clock.position = frame.seconds;
      this.#present();
    }
  }

  /** On to the group that is due, over those that would only be decoded late. */
  #leap(frame) {
    const group = this.#groups[groupAt(this.#groups, this.#clock.position)];
    if (!this.decoder.seekable || !(group?.firstFrame > frame.number + 1)) return false;
    this.#meter.dropped(group.firstFrame - frame.number);
    this.#seekSupply({ frame: group.firstFrame });
    return true;
  }

  /** The beginning of the loop is decoded while the end is still on screen. */
  #wrap() {
    this.#wrapped = true;
    const from = this.range ? Math.max(this.range.from, this.start) : this.start;
    this.#seekSupply({ seconds: from });
  }
  #playWrapped(frame) {
    const at = this.#wrapAt;
    if (this.#clock.position < at) return;
    if (!frame) {
      if (this.#missing) this.#stall();
      return;
    }
    this.#wrapped = false;
    this.#host.seeking();
    this.#clock.position = Math.max(frame.seconds, this.range?.from ?? frame.seconds);
    this.#present(() => this.#host.sought());
  }

  /** The loop has changed: what is decoded ahead is not what comes next any more. */
  unwrap() {
    if (!this.#wrapped) return this.#evaluate();
    this.#wrapped = false;
    const next = this.shown.number + 1;
    if (next < (this.decoder.frameCount ?? Infinity)) this.#seekSupply({ frame: next });
    else this.#supply.finish();
    this.#evaluate();
  }

  async #present(done) {
    const frame = this.#supply.shift();
    const { number, seconds, duration, decodeMs } = frame;
    this.#whole = !lacksPictures(frame);
    // The position is that of the new run already.
    if (seconds < this.shown?.seconds) this.#edge.enter();
    const began = this.#now();
    this.#taken = seconds + duration;
    this.#supply.showing = true;
    this.#supply.want();
    let trouble = null;
    try {
      await this.#show(frame);
    } catch (error) {
      trouble = error;
    }
    frame.close();
    this.#supply.showing = false;
    if (this.#closed) return;
    if (trouble) return this.#host.failed(trouble);
    this.shown = { number, seconds, duration };
    this.#shownAt = this.#now();
    this.#meter.shown(this.#shownAt, { decodeMs, showMs: this.#shownAt - began });
    this.#host.shown(this.shown);
    done?.();
    this.#synchronise();
    this.#evaluate();
  }

  /** place: as Decoder.seek takes it. position: seconds where it is, as far as is known. */
  seek(place, position) {
    this.#goal = { place, position, number: place.frame ?? null };
    this.#wrapped = false;
    this.#clock.stop();
    this.#clock.position = position;
    this.#host.seeking();
    const spent = this.#search ? this.#now() - this.#search.began : Infinity;
    clearTimeout(this.#patience);
    if (spent >= SEARCH_PATIENCE) this.#beginSearch();
    else this.#patience = setTimeout(() => this.#beginSearch(), SEARCH_PATIENCE - spent);
  }
  #beginSearch() {
    clearTimeout(this.#patience);
    this.#search = { goal: this.#goal, began: this.#now() };
    this.#stalled = false;
    this.#host.ready(1);
    this.#seekSupply(this.#goal.place);
  }
  #seekSupply(place) {
    this.#supply.seek(place).then(() => this.#evaluate());
  }

  #answer(frame, ended) {
    const search = this.#search;
    if (frame && this.#asksAgain(frame, search.again)) search.again = true;
    else if (frame) this.#present(() => this.#found(search));
    else if (ended) this.#found(search);
  }
  /** One that stays on screen is worth a second attempt. */
  #asksAgain(frame, asked) {
    if (asked || !this.decoder.seekable || !lacksPictures(frame)) return false;
    this.#seekSupply({ frame: frame.number });
    return true;
  }
  #found(search) {
    // Another one may have begun while the frame was on its way to the screen.
    if (search !== this.#search) return;
    const { goal } = search;
    if (goal !== this.#goal) return this.#beginSearch();
    this.#search = this.#goal = null;
    if (goal.number !== null && this.shown) this.#clock.position = this.shown.seconds;
    this.#host.ready(2);
    this.#host.sought();
  }

  /** Frames forward or back from the one that is shown, or sought. False: that can't be had. */
  step(count) {
    if (!this.shown) return false;
    const { decoder, shown } = this;
    const supply = this.#supply;
    const from = this.#goal?.number ?? shown.number;
    const next = supply.settled && !this.#search && !this.#wrapped && !supply.showing ? supply.frame : null;
    if (count === 1 && next && (!decoder.seekable || next.number === from + 1)) {
      this.#host.seeking();
      this.#clock.position = next.seconds;
      this.#present(() => this.#host.sought());
      return true;
    }
    if (!decoder.seekable) return false;
    const number = Math.min(Math.max(from + count, 0), (decoder.frameCount ?? Infinity) - 1);
    this.seek({ frame: number }, shown.seconds + (number - shown.number) * shown.duration);
    return true;
  }

  /** As Decoder.held tells it. */
  set held(times) {
    const seconds = this.#seconds;
    if (seconds) this.#held = times.map(({ start, end }) => [seconds(start), seconds(end)]);
  }
  /** [[start, end]]: what plays without the network, as was told last, and what is decoded. */
  get buffered() {
    const decoded = this.shown ? [this.shown, this.#supply.frame].filter(Boolean) : [];
    return union([...this.#held, ...decoded.map(({ seconds, duration }) => [seconds, seconds + duration])]);
  }
  /** The same of where one can seek to: where the end is not known, as far as it has played or is held. */
  get seekable() {
    if (!this.decoder.seekable || !this.shown) return [];
    const end = Number.isFinite(this.end) ? this.end : Math.max(this.#taken, this.buffered.at(-1)[1]);
    return [[this.start, end]];
  }

  close() {
    this.#closed = true;
    clearTimeout(this.#patience);
    this.#supply.close();
  }
}
