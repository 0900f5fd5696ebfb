// Shows the frames of one decoder at their time: playback, seeks, loops, steps, live edge. States and events of a media
// element are up to its host.

import { FrameQueue } from "./frame_queue.js";
import { Opening } from "./opening.js";
import { groupAt, union } from "./ranges.js";
import { Resting } from "./resting.js";
import { Clock, LiveEdge, whatIsDue } from "./timing.js";

/** Milliseconds that a search may continue after another seek; with less nothing is shown while the user scrubs. */
const SEARCH_TIMEOUT = 250;
/** Milliseconds with an empty queue after which playback stalls. */
const STALL = 250;
/** Milliseconds after which a frame counts as waited for. */
const WAITED = 12;
const EPSILON = 1e-6;
/** Milliseconds that a frame stays on screen instead of one that lacks pictures. */
const KEEP = 1000;
/** Decoders of video lose pictures, for example on a busy machine. */
const lacksPictures = ({ pictures, samples }) => pictures.length < samples.length;

export class Playout {
  #show;
  #vacate;
  #now;
  #screen;
  #host;
  #meter;
  #queue;
  #clock;
  #edge = new LiveEdge();
  #running = false;
  #stalled = false;
  #closed = false;
  #learned = false;
  #wrapped = false; // the queue is already at the beginning of the loop
  #goal = null; // the last seek: {place, position, number}
  #search = null; // the current search: {goal, began}
  #searchTimer = null;
  #last = 0; // end in seconds of the last group, which may have no frames
  #taken = 0; // end in seconds of the last frame that was shown or dropped
  #shownAt = -Infinity;
  #rate = 1;
  #groups = [];
  #seconds = null; // converts ticks
  #cached = []; // [start, end] in seconds
  #retried = false; // the first frame lacked pictures and was requested again
  #damage = null; // the first
  #complete = false; // the frame on screen has all its pictures
  #rung = null; // of the frame on screen
  #tracks = null; // that were selected for it, as text
  #resting = new Resting({ better: (asked) => this.#better(asked), ask: (rung) => this.#askAgain(rung) });
  #opening = null; // while the first frame is covered
  #began; // milliseconds, when the source was set
  #again = null; // number of the frame on screen, while it is requested again
  #isWatched = true;
  #unsupported = false; // a codec: pictures are missing for good
  #gapEnd = null; // in ticks, of what a live stream has lost
  #begins = -Infinity; // position from which on a round of the loop is played
  #skipped = false; // frames after the one on screen were left out, because decoding is behind
  live = false;
  loop = false;
  /** {from, to} in seconds, or null. */
  range = null;
  /** {number, seconds, duration, until} of the frame on screen; until: the end of its group, where its mesh ends. */
  shown = null;
  start = 0;
  end = Infinity;

  /**
   * show(frame): resolves when the frame may be closed. vacate(): no mesh is valid, the stage is empty. screen(): as
   * whatIsDue takes it. host: {metadata, duration, ready, shown, seeking, sought, plays, liveCatchUp, behind, drained, ended, failed, wake};
   * plays(): whether playback follows the first frame; ready(1): the current frame is missing, (2): the next one is missing, (4): none is. began: when the source was set.
   */
  constructor({ decoder, show, vacate, now, screen, host, meter, live, began }) {
    Object.assign(this, { decoder, live });
    this.#began = began;
    this.#show = show;
    this.#vacate = vacate;
    this.#now = now;
    this.#screen = screen;
    this.#host = host;
    this.#meter = meter;
    this.#clock = new Clock(now);
    this.#queue = new FrameQueue(
      decoder,
      (frame) => this.#arrive(frame),
      (error) => host.failed(error),
      now,
    );
    // The length of some sources is known only at their end.
    decoder.addEventListener("warning", ({ detail }) => {
      if (detail.severity === "error" && detail.code !== "gap") this.#damage ??= detail;
      if (detail.code === "unsupported") this.#unsupported = true;
      if (detail.code === "gap" && live) this.#gapEnd = detail.to;
    });
    decoder.addEventListener("groups", () => this.#seconds && this.#learnGroups());
  }

  begin() {
    this.#queue.fill();
  }

  get position() {
    return Math.min(Math.max(this.#clock.position, this.start), this.#limit);
  }
  /** Of the clock: {running, position, rate}. Before `begins` the round of the loop before is still to be heard. */
  get motion() {
    const { running, position, rate } = this.#clock;
    return { running, position, rate, begins: this.#begins };
  }
  get running() {
    return this.#running;
  }
  set running(running) {
    const pauses = this.#running && !running;
    this.#running = running;
    if (running && !this.#opening) this.#leaveAgain();
    this.#synchronise();
    this.#evaluate();
    // The frame on screen is not that of the time, and no other is about to come.
    if (pauses && this.#skipped && this.#goal === null) {
      const { position } = this;
      return this.seek({ seconds: position }, position);
    }
    // Who pauses looks closely.
    if (pauses && this.#rests) this.#resting.hurry();
    else this.#rest();
  }
  /** false: the page is hidden, so that no frame has to look better. */
  set watched(watched) {
    this.#isWatched = watched;
    this.#rest();
  }
  set rate(rate) {
    this.#rate = rate;
    this.#clock.rate = rate;
  }
  /** Number of frames with open pictures in this thread. */
  get openFrames() {
    return this.#queue.openFrames;
  }
  get behind() {
    return this.live ? this.#edge.behind(this.position, this.#now()) : 0;
  }
  get groups() {
    return this.#groups;
  }

  /** The position that playback can reach without another frame. */
  get #limit() {
    if (this.#search || !this.shown) return Infinity;
    if (this.#wrapped) return this.#wrapAt;
    if (this.#queue.frame && this.#queue.settled) return Infinity;
    // The stage may be empty till the end.
    if (this.#queue.ended && this.#queue.settled && Number.isFinite(this.end)) return Math.max(this.#taken, this.end);
    return this.#taken;
  }
  /** Whether the frame that is due has been missing for a while. */
  get #missing() {
    return this.#queue.waited > STALL && this.#clock.position > this.#limit;
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
    if (this.#running && !this.#stalled && !this.#search && !this.#opening && this.shown) this.#clock.start();
    else this.#clock.stop();
  }

  #arrive(frame) {
    if (frame && this.live) this.#observe(frame);
    if (frame && !this.#learned) this.#learn(frame);
    this.#evaluate();
    this.#host.wake();
  }

  #observe({ seconds, edgeSeconds: edge }) {
    this.#edge.observe({ seconds, edge, waited: this.#queue.waited > WAITED }, this.#now());
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
    this.#last = groups.length ? seconds(groups.at(-1).end) : 0;
    if (!this.live) this.end = this.#last || Infinity;
    this.#host.duration();
  }

  /** Called for each picture of the screen while it plays. */
  tick() {
    if (this.live && this.#running && !this.#search) this.#follow();
    this.#evaluate();
  }

  #follow() {
    const { behind } = this;
    const hurry = this.#rate === 1 ? this.#edge.rateFor(behind, this.#host.liveCatchUp()) : 1;
    this.#clock.rate = this.#rate * hurry;
    if (this.#rate >= 1) this.#host.behind(behind);
  }

  #evaluate() {
    const queue = this.#queue;
    if (queue.showing || this.#closed || !queue.settled) return;
    const { frame, ended } = queue;
    if (this.#search) this.#takeFound(frame, ended);
    else if (this.#again !== null) this.#takeAgain(frame, ended);
    else if (!this.shown) {
      if (frame && this.#retries(frame, this.#retried)) this.#retried = true;
      else if (frame) this.#present();
      else if (ended) this.#host.failed(this.#noFrames());
    } else if (!this.#opening) {
      if (frame || ended) this.#unstall();
      // Playback may have begun with that, and have taken the frame.
      if (this.#running && queue.frame === frame) this.#play(frame, ended);
    }
    if (queue.ended && !queue.showing && !this.#wrapped) this.#host.drained();
    queue.fill();
  }

  /** Whether the frame on screen stays there, and can be requested again. */
  get #rests() {
    const isIdle = (!this.#running || this.#opening) && !this.#search && this.#goal === null && !this.#closed;
    return isIdle && this.#isWatched && this.decoder.seekable && this.shown !== null && !this.shown.vacated;
  }
  #rest() {
    if (this.#opening) return;
    if (this.#rests) this.#resting.begin();
    else this.#resting.end();
  }
  /** Another rung is wanted. */
  improve() {
    if (this.#rests) this.#resting.hurry();
  }
  /** Other tracks were selected, which the frames that are shown need at once. */
  refetch() {
    if (this.#rests) return this.#askAgain(this.#rung);
    const isPlaying = this.#running && this.shown && !this.#search && this.#goal === null && !this.#wrapped;
    const next = this.shown && this.shown.number + 1;
    if (isPlaying && this.decoder.seekable && next < (this.decoder.frameCount ?? Infinity))
      this.#seekQueue({ frame: next });
  }
  async #better(asked) {
    const { decoder } = this;
    const wished = (await decoder.lastingRung?.({ plays: this.#host.plays() }).catch(() => null)) ?? null;
    const isBetter = wished !== null && (decoder.rung === "auto" ? wished < this.#rung : wished !== this.#rung);
    const rung = isBetter && !asked.has(wished) ? wished : null;
    return { rung, known: wished !== null, lacks: !this.#complete && !this.#unsupported };
  }
  /** The first frame is on screen, covered. */
  #open() {
    const search = this.#search;
    this.#search = this.#goal = null;
    this.#opening = new Opening({
      better: (asked) => this.#better(asked),
      ask: (rung) => this.#askAgain(rung),
      done: () => this.#uncover(search),
      spent: this.#now() - this.#began,
    });
  }
  #uncover(search) {
    this.#opening = null;
    // Another place is sought, which is seen as it comes.
    if (this.#closed || this.#goal !== null) return;
    this.#host.shown(this.shown);
    if (search) {
      this.#search = search;
      this.#goal = search.goal;
      this.#found(search);
    }
    this.#synchronise();
    this.#evaluate();
    this.#rest();
  }
  /** The viewer acts: the first frame is seen as it is. */
  uncover() {
    this.#opening?.end();
  }
  /** rung: in which it should come; null: as other frames. */
  #askAgain(rung) {
    if (!this.#rests || this.#queue.showing) return;
    this.#wrapped = false;
    this.#again = this.shown.number;
    this.#seekQueue({ frame: this.#again, ...(rung !== null && { rung }) });
  }
  /** Playback goes on: a rung that takes too long for that does not hold it up. */
  #leaveAgain() {
    const next = this.#again !== null && this.#again + 1;
    this.#again = null;
    if (next && next < (this.decoder.frameCount ?? Infinity)) this.#seekQueue({ frame: next });
  }
  /** The frame on screen has come again. */
  #takeAgain(frame, ended) {
    if (!frame && !ended) return;
    const isSame = frame?.number === this.#again;
    this.#again = null;
    if (!isSame) return this.#opening?.came();
    const isWorse = this.#complete && lacksPictures(frame);
    const isOther = frame.rung !== this.#rung || JSON.stringify(frame.tracks) !== this.#tracks;
    if (!isWorse && (isOther || !this.#complete)) return this.#present();
    this.#queue.shift().close();
    this.#opening?.came();
  }

  #noFrames() {
    const damage = this.#damage;
    if (!damage) return new Error("the stream has no frames");
    const { code, message } = damage;
    const advice = code === "truncated" ? ": the file is incomplete" : "";
    return Object.assign(new Error(`no frame can be shown: ${message}${advice}`, { cause: damage }), { code });
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
      // Without an index the end is known only now.
      this.end = Math.min(this.end, Math.max(this.#taken, this.#last));
      this.#leaveStage();
      if (this.#clock.position >= this.end - EPSILON) this.#finish();
    } else if (this.#missing) this.#stall();
  }

  #finish() {
    this.#clock.position = this.end;
    this.#host.ended();
  }

  /** Nothing is carried over from one group to the next: until there is another mesh the stage is empty. */
  #leaveStage() {
    const { position } = this.#clock;
    const { until, vacated } = this.shown;
    // What was skipped may have meshes.
    if (this.#skipped) return;
    if (vacated || position < until || position >= this.end - EPSILON) return;
    this.shown.vacated = true;
    this.#vacate();
  }

  #stall() {
    if (this.#stalled) return;
    this.#clock.position = this.#limit;
    this.#stalled = true;
    this.#synchronise();
    this.#host.ready(2);
  }

  #playNext(frame) {
    // Times go back: a live stream has restarted.
    if (frame.seconds < this.shown.seconds) this.#clock.position = frame.seconds;
    if (this.live) this.#passGap(frame);
    const { position, rate } = this.#clock;
    // If decoding is the bottleneck, dropping a frame does not make the next one arrive sooner.
    const last = frame.number + 1 === this.decoder.frameCount;
    const spared = !last && this.#queue.waited * rate < 1000 * frame.duration;
    const sinceShown = this.#now() - this.#shownAt;
    let due = whatIsDue(frame, position, rate, spared ? sinceShown : Infinity, this.#screen());
    if (due === "show" && this.#complete && lacksPictures(frame) && sinceShown < KEEP) due = "drop";
    if (due === "wait") this.#leaveStage();
    if (due === "show") this.#present();
    if (due === "drop") {
      const dropped = this.#queue.shift();
      this.#taken = dropped.seconds + dropped.duration;
      dropped.close();
      this.#meter.dropped();
    }
    if (due === "lag" && !this.#skipToDue(frame)) {
      this.#clock.position = frame.seconds;
      this.#present();
    }
  }

  /** What was lost live is not waited for on an empty stage: its time has passed. */
  #passGap(frame) {
    if (this.#gapEnd === null || frame.seconds < this.#seconds(this.#gapEnd) - EPSILON) return;
    if (this.#clock.position < this.#taken - EPSILON) return;
    this.#clock.position = Math.max(this.#clock.position, frame.seconds);
    this.#gapEnd = null;
  }

  /** Skips to the group that is due. */
  #skipToDue(frame) {
    const group = this.#groups[groupAt(this.#groups, this.#clock.position)];
    if (!this.decoder.seekable || !(group?.firstFrame > frame.number + 1)) return false;
    this.#meter.dropped(group.firstFrame - frame.number);
    this.#skipped = true;
    this.#seekQueue({ frame: group.firstFrame });
    return true;
  }

  /** Begins to decode the beginning of the loop while its end is still on screen. */
  #wrap() {
    this.#wrapped = true;
    const from = this.range ? Math.max(this.range.from, this.start) : this.start;
    this.#seekQueue({ seconds: from });
  }
  #playWrapped(frame) {
    const { position, rate } = this.#clock;
    const { delay, refresh } = this.#screen();
    const left = this.#wrapAt - position;
    if (left > ((delay + refresh / 2) / 1000) * rate) return;
    if (!frame) {
      if (this.#missing) this.#stall();
      return;
    }
    this.#wrapped = false;
    this.#host.seeking();
    this.#begins = Math.max(frame.seconds, this.range?.from ?? frame.seconds);
    this.#clock.position = this.#begins - Math.max(0, left);
    this.#present(() => this.#host.sought());
  }

  /** The loop has changed: frames that were decoded ahead may be the wrong ones. */
  unwrap() {
    if (!this.#wrapped) return this.#evaluate();
    this.#wrapped = false;
    const next = this.shown.number + 1;
    if (next < (this.decoder.frameCount ?? Infinity)) this.#seekQueue({ frame: next });
    else this.#queue.finish();
    this.#evaluate();
  }

  async #present(done) {
    const frame = this.#queue.shift();
    const { number, seconds, duration, decodeMs } = frame;
    const isAgain = number === this.shown?.number;
    const goal = this.#goal;
    const opens = !this.shown && !this.live && frame.rung > 0 && this.decoder.rung === "auto" && this.decoder.seekable;
    const until = this.#seconds(frame.group.end);
    this.#complete = !lacksPictures(frame);
    this.#rung = frame.rung ?? null;
    this.#tracks = JSON.stringify(frame.tracks);
    // The position is already that of the restarted stream.
    if (seconds < this.shown?.seconds) this.#edge.enter();
    const began = this.#now();
    this.#taken = seconds + duration;
    this.#queue.showing = true;
    this.#queue.fill();
    let failure = null;
    try {
      await this.#show(frame);
    } catch (error) {
      failure = error;
    }
    frame.close();
    this.#queue.showing = false;
    if (this.#closed) return;
    if (failure) return this.#host.failed(failure);
    this.shown = { number, seconds, duration, until };
    this.#skipped = false;
    this.#shownAt = this.#now();
    this.#meter.shown(this.#shownAt, { decodeMs, showMs: this.#shownAt - began });
    // A place that is sought meanwhile is seen as it comes.
    if (opens && this.#goal === goal) return this.#open();
    if (this.#opening) return this.#opening.came();
    this.#host.shown(this.shown);
    done?.();
    this.#synchronise();
    this.#evaluate();
    if (!isAgain) this.#rest();
  }

  /** place: as Decoder.seek takes it. position: its seconds, as far as known. */
  seek(place, position) {
    this.#goal = { place, position, number: place.frame ?? null };
    this.#again = null;
    this.#opening?.end();
    this.#resting.end();
    this.#wrapped = false;
    this.#begins = -Infinity;
    this.#clock.stop();
    this.#clock.position = position;
    this.#host.seeking();
    const spent = this.#search ? this.#now() - this.#search.began : Infinity;
    clearTimeout(this.#searchTimer);
    if (spent >= SEARCH_TIMEOUT) this.#beginSearch();
    else this.#searchTimer = setTimeout(() => this.#beginSearch(), SEARCH_TIMEOUT - spent);
  }
  #beginSearch() {
    clearTimeout(this.#searchTimer);
    this.#search = { goal: this.#goal, began: this.#now() };
    this.#stalled = false;
    this.#host.ready(1);
    this.#seekQueue(this.#goal.place);
  }
  #seekQueue(place) {
    this.#queue.seek(place).then(() => this.#evaluate());
  }

  #takeFound(frame, ended) {
    const search = this.#search;
    if (frame && this.#retries(frame, search.retried)) search.retried = true;
    else if (frame && this.shown && this.#isBefore(search.goal, frame)) this.#findEmpty(search, frame);
    else if (frame) this.#present(() => this.#found(search));
    else if (ended) this.#found(search);
  }
  /** Whether a position is before the first frame of its group. */
  #isBefore({ position, number }, frame) {
    return number === null && position >= this.start && position < frame.seconds - EPSILON;
  }
  #findEmpty(search, { number, duration }) {
    const seconds = search.goal.position;
    this.shown = { number: number - 1, seconds, duration, until: seconds };
    this.#found(search);
  }
  /** A frame that stays on screen but lacks pictures is requested once more. */
  #retries(frame, retried) {
    if (retried || !this.decoder.seekable || !lacksPictures(frame)) return false;
    this.#seekQueue({ frame: frame.number });
    return true;
  }
  #found(search) {
    // Another search may have begun while the frame was being shown.
    if (search !== this.#search) return;
    const { goal } = search;
    if (goal !== this.#goal) return this.#beginSearch();
    this.#search = this.#goal = null;
    if (goal.number !== null && this.shown) this.#clock.position = this.shown.seconds;
    if (this.shown) this.#leaveStage();
    this.#host.ready(2);
    this.#host.sought();
    this.#rest();
  }

  /** Moves count frames forward or back from the frame that is shown or sought. Returns false if that is impossible. */
  step(count) {
    if (!this.shown) return false;
    const { decoder, shown } = this;
    const queue = this.#queue;
    const from = this.#goal?.number ?? shown.number;
    const next = queue.settled && !this.#search && !this.#wrapped && !queue.showing ? queue.frame : null;
    if (count === 1 && next && (!decoder.seekable || next.number === from + 1)) {
      this.#host.seeking();
      this.#clock.position = next.seconds;
      this.#present(() => this.#host.sought());
      return true;
    }
    if (!decoder.seekable) return false;
    const last = decoder.frameCount ? decoder.frameCount - 1 : queue.ended ? from : Infinity;
    const number = Math.min(Math.max(from + count, 0), last);
    // At the end, and at the beginning, there is nothing to show.
    if (number === from) return false;
    this.seek({ frame: number }, shown.seconds + (number - shown.number) * shown.duration);
    return true;
  }

  /** times: the result of Decoder.buffered. */
  set cachedTimes(times) {
    const seconds = this.#seconds;
    if (seconds) this.#cached = times.map(({ start, end }) => [seconds(start), seconds(end)]);
  }
  /** [[start, end]]: times in the decoder's cache at the last update, and decoded frames. */
  get buffered() {
    const decoded = this.shown ? [this.shown, this.#queue.frame].filter(Boolean) : [];
    return union([...this.#cached, ...decoded.map(({ seconds, duration }) => [seconds, seconds + duration])]);
  }
  /** [[start, end]]: times that can be sought; if the end is not known, as far as it was played or is buffered. */
  get seekable() {
    if (!this.decoder.seekable || !this.shown) return [];
    const end = Number.isFinite(this.end) ? this.end : Math.max(this.#taken, this.buffered.at(-1)[1]);
    return [[this.start, end]];
  }

  close() {
    this.#closed = true;
    this.#opening?.end();
    this.#resting.end();
    clearTimeout(this.#searchTimer);
    this.#queue.close();
  }
}
