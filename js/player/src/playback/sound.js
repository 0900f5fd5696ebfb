// Sound by Web Audio. Its clock is the clock of playback: now() follows the samples that the device plays, and sound is
// scheduled for the time that playback will have then.

import { Stretch } from "./stretch.js";
import { Course } from "./timing.js";

/** Seconds that are scheduled ahead. */
const AHEAD = 0.25;
/** Milliseconds between looks at what has to be scheduled. */
const INTERVAL = 50;
/** Seconds of fades: where sound begins or ends it must not click. */
const FADE = 0.006;
/** Time constant in seconds of changes of volume. */
const VOLUME = 0.015;
/** Seconds by which playback may be elsewhere than the sound before that is scheduled again. */
const TOLERANCE = 0.012;
/** Speeds at which sound is heard; its pitch is kept. */
const SLOWEST = 0.5;
const FASTEST = 2;
const SAME = 0.001;
/** Changes of the speed that are left to the tolerance above: a live stream changes it all the time. */
const SAME_RATE = 0.03;
/** Part by which the measured time of the device corrects the clock at each look. */
const SMOOTHING = 0.1;

/** Tracks that are played together: all of one language, and those without one. languages: of the user, best first. */
export function chooseTracks(sounds, languages) {
  const spoken = [...new Set(sounds.map(({ language }) => language).filter(Boolean))];
  if (spoken.length < 2) return sounds;
  const base = (tag) => tag.toLowerCase().split("-")[0];
  const wanted = languages.map((tag) => spoken.find((one) => base(one) === base(tag))).find(Boolean) ?? spoken[0];
  return sounds.filter(({ language }) => !language || language === wanted);
}

/** A part of a track's sound without a gap, on its way to the device. */
class Voice {
  #context;
  #rate;
  #gain;
  #sources = new Set();
  #stretch;
  #base; // context time of the first sample of the output
  #sent = 0; // samples of the output
  next; // the sample that follows

  /** first: number of the first sample; at: context time when it is to be heard. speed: of playback. */
  constructor(context, output, { rate, channels, first, at, speed }) {
    this.#context = context;
    this.#rate = rate;
    this.next = first;
    this.#stretch = Math.abs(speed - 1) > SAME ? new Stretch(channels, rate, speed) : null;
    // On a sample of the context, so that parts that follow each other do.
    this.#base = Math.round(at * context.sampleRate) / context.sampleRate;
    this.#gain = new GainNode(context, { gain: 0 });
    this.#gain.connect(output);
    const begin = Math.max(this.#base, context.currentTime);
    this.#gain.gain.setValueAtTime(0, begin);
    this.#gain.gain.linearRampToValueAtTime(1, begin + FADE);
  }

  /** Context time of the end of what was sent. */
  get end() {
    return this.#base + this.#sent / this.#rate;
  }

  send(channels) {
    this.next += channels[0].length;
    const out = this.#stretch ? this.#stretch.push(channels) : channels;
    const { length } = out[0];
    if (!length) return;
    const at = this.end;
    this.#sent += length;
    const late = Math.max(0, this.#context.currentTime + 0.003 - at);
    if (late * this.#rate >= length) return;
    const buffer = new AudioBuffer({ length, numberOfChannels: out.length, sampleRate: this.#rate });
    out.forEach((samples, i) => buffer.copyToChannel(samples, i));
    const source = new AudioBufferSourceNode(this.#context, { buffer });
    source.connect(this.#gain);
    source.onended = () => this.#sources.delete(source);
    source.start(late ? at + late : at, late);
    this.#sources.add(source);
  }

  /** at: context time; those of the past are now. */
  stop(at) {
    const { gain } = this.#gain;
    const end = Math.max(at, this.#context.currentTime);
    gain.cancelScheduledValues(end);
    gain.setTargetAtTime(0, end, FADE / 3);
    for (const source of this.#sources) source.stop(end + 2 * FADE);
    setTimeout(() => this.#gain.disconnect(), 1000 * (end - this.#context.currentTime + 1));
  }
}

/** A track: blocks that may still be needed, and the way of its sound to the device. */
class Track {
  #context = null;
  #way = null; // to the device
  blocks = [];
  voice = null;

  constructor(about) {
    this.about = about;
  }

  /** way: {input, place}: where sound goes to, and place(position, at), which moves it at a context time. */
  connect(context, way) {
    this.#context = context;
    this.#way = way;
  }

  /** from: seconds that were played already. */
  forget(from) {
    while (this.blocks.length && this.blocks[0].seconds + lengthOf(this.blocks[0]) < from) this.blocks.shift();
  }

  stop(at = 0) {
    this.voice?.stop(at);
    this.voice = null;
  }

  /** Sends blocks up to a time. course: of playback, in context time. */
  schedule(position, until, course) {
    for (;;) {
      const first = this.#nextBlock(position);
      if (!first || first.seconds > until) return;
      const joined = [first];
      for (let i = this.blocks.indexOf(first) + 1; i < this.blocks.length; i++) {
        const [block, before] = [this.blocks[i], joined.at(-1)];
        if (block.start !== before.start + before.channels[0].length || block.seconds > until) break;
        joined.push(block);
      }
      if (this.voice?.next !== first.start) {
        const { rate, channels, start: number, seconds } = first;
        this.stop();
        this.voice = new Voice(this.#context, this.#way.input, {
          rate,
          channels: channels.length,
          first: number,
          at: course.timeOf(seconds),
          speed: course.rate,
        });
      }
      for (const { position: place, seconds } of joined) if (place) this.#way.place(place, course.timeOf(seconds));
      this.voice.send(first.channels.map((_, i) => concatenate(joined.map(({ channels }) => channels[i]))));
    }
  }
  /** The block that follows what was sent, or the first one that is not over. */
  #nextBlock(position) {
    const { voice, blocks } = this;
    if (voice) {
      const next = blocks.find(({ start }) => start >= voice.next);
      if (next) return next;
      if (blocks.length) return null;
    }
    return blocks.find((block) => block.seconds + lengthOf(block) > position) ?? null;
  }
}

const lengthOf = ({ channels, rate }) => channels[0].length / rate;

function concatenate(parts) {
  const out = new Float32Array(parts.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}

/**
 * The way to output for a track, at its place if it has one. scale: length in the scene at which sound has its full volume. origin:
 * what places count from, as the listener's.
 */
function wayTo(output, { position, moves }, scale, origin) {
  if (!position && !moves) return { input: output, place() {} };
  const { context } = output;
  const refDistance = Math.max(scale, 1e-6);
  const panner = new PannerNode(context, { panningModel: "HRTF", distanceModel: "inverse", refDistance });
  panner.connect(output);
  const place = (where, at) =>
    ["positionX", "positionY", "positionZ"].forEach((axis, i) => {
      const parameter = panner[axis];
      const value = where[i] - origin[i];
      if (at > context.currentTime) parameter.linearRampToValueAtTime(value, at);
      else parameter.setValueAtTime(value, context.currentTime);
    });
  return { input: panner, place };
}

export class Sound {
  #motion;
  #listener;
  #scale;
  #makeDevice;
  #device = null;
  #context = null;
  #master = null;
  #tracks = new Map();
  #configured = "[]";
  #origin = [0, 0, 0]; // parameters of the device have 32 bits, as shaders do
  #present = false;
  #timer = null;
  #offset = 0; // milliseconds: now() is performance.now() and this
  #drift = null; // smoothed difference of the device's time and performance.now(), and what now() had before
  #course = null; // of what is scheduled, in context time
  #leaving = false; // blocks are those of the place where playback goes to
  #volume = 1;
  #muted = false;
  #changed;
  #stateChanged = () => this.update();
  #waiting = null; // AbortController of listeners for a gesture of the user

  /**
   * motion(): {running, position, rate, begins} of playback at now(), as Playout has it. listener(): {eye, target, up}, or null. scale(): size of the
   * scene. changed(): whether there is sound has changed. device(): what sound is given to in place of a context of its own, with
   * listener and scale: {context, wayOf(about) for Track.connect, volume}; called when there is sound to be heard.
   */
  constructor({ motion, listener = () => null, scale = () => 1, changed, device = null }) {
    this.#motion = motion;
    this.#listener = listener;
    this.#scale = scale;
    this.#changed = changed;
    this.#makeDevice = device;
  }

  /** Whether the stream has sound. */
  get present() {
    return this.#present;
  }
  /** For tests. */
  get context() {
    return this.#context;
  }

  /** Milliseconds. While sound is heard it is the device's clock, else performance.now(); it never jumps. */
  now() {
    return performance.now() + this.#offset;
  }

  set volume(volume) {
    this.#volume = volume;
    this.#adjust();
  }
  set muted(muted) {
    this.#muted = muted;
    this.#adjust();
    this.update();
  }
  #adjust() {
    const { currentTime } = this.#context ?? {};
    const volume = this.#muted ? 0 : this.#volume;
    this.#master?.gain.setTargetAtTime(volume, currentTime, VOLUME);
    if (this.#device) this.#device.volume = volume;
  }

  /** Takes the events of a decoder. */
  follow(decoder) {
    decoder.addEventListener("configuration", ({ detail }) => {
      this.#origin = detail.localOrigin ?? [0, 0, 0];
      this.#configure(detail.sounds ?? []);
    });
    decoder.addEventListener("soundrestart", () => this.#restart());
    decoder.addEventListener("restart", () => this.#restart());
    // Sound arrives before the configuration does.
    decoder.addEventListener("sound", ({ detail }) => this.#take(detail));
  }

  #configure(sounds) {
    // A repetition of the configuration interrupts nothing.
    const text = JSON.stringify(sounds);
    if (text === this.#configured) return;
    this.#configured = text;
    const chosen = chooseTracks(sounds, navigator.languages ?? []);
    const former = this.#tracks;
    this.#tracks = new Map(
      chosen.map((about) => {
        const track = new Track(about);
        track.blocks = former.get(about.track)?.blocks ?? [];
        return [about.track, track];
      }),
    );
    for (const track of former.values()) track.stop();
    this.#course = null;
    if (this.#context) this.#connect();
    if (this.#present !== sounds.length > 0) {
      this.#present = sounds.length > 0;
      this.#changed();
    }
    this.update();
  }
  #connect() {
    for (const track of this.#tracks.values()) {
      const { about } = track;
      const way = this.#device?.wayOf(about) ?? wayTo(this.#master, about, this.#scale(), this.#origin);
      track.connect(this.#context, way);
    }
  }

  #take(block) {
    if (!this.#tracks.has(block.track)) this.#tracks.set(block.track, new Track({}));
    const { blocks } = this.#tracks.get(block.track);
    // A live stream may start again.
    if (blocks.length && block.start < blocks.at(-1).start) blocks.length = 0;
    blocks.push(block);
    if (blocks.length === 1) this.update();
  }
  /** What was read is played on: it may be the end of a loop. */
  #restart() {
    if (this.#course && !this.#leaving) this.#schedule(Infinity);
    for (const track of this.#tracks.values()) track.blocks = [];
    this.#leaving = this.#course !== null;
  }

  /** Another source follows. */
  reset() {
    this.#stop();
    this.#tracks.clear();
    this.#configured = "[]";
    if (this.#present) {
      this.#present = false;
      this.#changed();
    }
  }

  /** Browsers play no sound before a gesture of the user. */
  #open() {
    if (this.#context || this.#waiting || typeof AudioContext !== "function") return;
    if (navigator.userActivation?.hasBeenActive === false) {
      this.#waiting = new AbortController();
      const { signal } = this.#waiting;
      const begin = () => {
        if (navigator.userActivation.hasBeenActive === false) return;
        this.#waiting?.abort();
        this.#waiting = null;
        this.update();
      };
      for (const type of ["pointerup", "click", "keydown", "touchend"])
        document.addEventListener(type, () => setTimeout(begin), { signal, capture: true });
      return;
    }
    const [{ blocks: [{ rate }] = [{}] } = {}] = [...this.#tracks.values()].filter(({ blocks }) => blocks.length);
    if (!rate) return;
    this.#device = this.#makeDevice?.() ?? null;
    this.#context = this.#device?.context ?? new AudioContext({ sampleRate: rate, latencyHint: "interactive" });
    this.#context.addEventListener("statechange", this.#stateChanged);
    if (this.#device) this.#adjust();
    else {
      this.#master = new GainNode(this.#context, { gain: this.#muted ? 0 : this.#volume });
      this.#master.connect(this.#context.destination);
    }
    this.#connect();
  }

  /** The time of the sample that the device plays, in milliseconds of the context, less performance.now(). */
  #measure() {
    const context = this.#context;
    const { contextTime, performanceTime } = context.getOutputTimestamp?.() ?? {};
    if (performanceTime > 0 && contextTime > 0) return contextTime * 1000 - performanceTime;
    return (context.currentTime - (context.outputLatency || context.baseLatency || 0)) * 1000 - performance.now();
  }
  #synchronise() {
    const measured = this.#measure();
    if (this.#drift === null || Math.abs(measured - this.#drift.value) > 100)
      this.#drift = { value: measured, zero: measured - this.#offset };
    else this.#drift.value += SMOOTHING * (measured - this.#drift.value);
    this.#offset = this.#drift.value - this.#drift.zero;
  }
  /** Context time of the sample that is heard at a time of now(). */
  #heardAt(now) {
    return (now + this.#drift.zero) / 1000;
  }

  /** Schedules what playback needs next. Called when playback changes, and regularly. */
  update() {
    const motion = this.#motion();
    const wanted = motion.running && this.#tracks.size > 0 && !this.#muted;
    if (wanted) this.#open();
    const context = this.#context;
    if (wanted && context?.state === "suspended") context.resume().catch(() => {});
    const heard = wanted && context?.state === "running" && motion.rate >= SLOWEST && motion.rate <= FASTEST;
    this.#tick(motion.running && this.#tracks.size > 0);
    if (!heard) return this.#stop();
    this.#synchronise();
    if (!this.#device) this.#place();
    const { position, rate, begins } = this.#motion();
    const time = this.#heardAt(this.now());
    const off = this.#course ? this.#course.positionAt(time) - position : Infinity;
    if (Math.abs(off) > TOLERANCE || Math.abs(this.#course.rate - rate) > SAME_RATE) {
      const course = new Course(time, position, rate);
      // A round of a loop is heard to its end.
      this.#stop(position < begins ? course.timeOf(begins) : 0);
      this.#course = course;
    }
    if (this.#leaving) return;
    for (const track of this.#tracks.values()) track.forget(position - 0.1);
    this.#schedule(AHEAD);
  }
  /** Schedules what the device needs in the next seconds. */
  #schedule(seconds) {
    const course = this.#course;
    const now = course.positionAt(this.#context.currentTime);
    for (const track of this.#tracks.values()) track.schedule(now, now + seconds * course.rate, course);
  }
  #stop(at) {
    this.#leaving = false;
    if (!this.#course) return;
    this.#course = null;
    for (const track of this.#tracks.values()) track.stop(at);
  }

  #tick(runs) {
    if (runs) this.#timer ??= setInterval(() => this.update(), INTERVAL);
    else {
      clearInterval(this.#timer);
      this.#timer = null;
    }
  }

  /** The viewer is the listener. */
  #place() {
    const pose = this.#listener();
    if (!pose) return;
    const { listener, currentTime } = this.#context;
    const { target, up } = pose;
    const forward = target.map((x, i) => x - pose.eye[i]);
    const eye = pose.eye.map((x, i) => x - this.#origin[i]);
    if (!listener.positionX) {
      listener.setPosition(...eye);
      listener.setOrientation(...forward, ...up);
      return;
    }
    const names = ["positionX", "positionY", "positionZ", "forwardX", "forwardY", "forwardZ", "upX", "upY", "upZ"];
    [...eye, ...forward, ...up].forEach((value, i) => listener[names[i]].setTargetAtTime(value, currentTime, VOLUME));
  }

  close() {
    this.reset();
    this.#tick(false);
    this.#waiting?.abort();
    this.#waiting = null;
    this.#context?.removeEventListener("statechange", this.#stateChanged);
    if (!this.#device) this.#context?.close().catch(() => {});
    this.#context = this.#master = this.#device = this.#drift = null;
  }
}
