// <fvv-player> over a network that fails at random, in simulated time. The element is used as on other pages, without a worker;
// clock, animation frames, fetch and WebSocket of the page are those of the simulation, codecs and WebGL those of the browser.

import { FvvPlayer } from "@fvv/player";

import { crc32c } from "../../../decoder/dist/chunks.js";
import { Clock, randomOf } from "../../../testing/chaos/clock.mjs";
import { faultsOf, Figures, HANG_MS } from "../../../testing/chaos/figures.mjs";
import { anyFault, Host, misfortune } from "../../../testing/chaos/host.mjs";
import { anyLiveFault, LiveServer } from "../../../testing/chaos/live_server.mjs";

/** Milliseconds of a film, and of a live stream, before another one begins. */
const SESSION = [10000, 60000];
const LIVE_SESSION = [30000, 180000];
const SIZE = [160, 120];
const STEP = 100;
/** Of this machine: a codec that keeps a picture for so long waits for more samples. */
const CODEC_MS = 500;
/** Frames that may be passed over when playback goes on: those that were late. */
const SKIPPED_MAX = 1;
const EXPECTED_WARNINGS = ["no-range", "io", "changed", "reconnect", "gap", "skipped"];

/** What this machine decodes: meanwhile simulated time stands still. */
class Codecs {
  #open = 0; // samples without a picture
  #since = 0;
  #now = performance.now.bind(performance);

  constructor() {
    const codecs = this;
    const Decoder = globalThis.VideoDecoder;
    globalThis.VideoDecoder = class extends Decoder {
      #samples = 0;
      constructor({ output, error }) {
        super({
          output: (frame) => {
            this.#samples--;
            codecs.#count(-1);
            output(frame);
          },
          error,
        });
      }
      decode(sample) {
        this.#samples++;
        codecs.#count(1);
        super.decode(sample);
      }
      #forget() {
        codecs.#count(-this.#samples);
        this.#samples = 0;
      }
      reset() {
        this.#forget();
        super.reset();
      }
      close() {
        this.#forget();
        super.close();
      }
    };
  }
  #count(change) {
    this.#open += change;
    this.#since = this.#now();
  }
  isAtWork = (now) => this.#open > 0 && now - this.#since < CODEC_MS;
}

const codecs = new Codecs();
const files = new Map(); // path -> bytes

/** paths: what the host has, below files/. */
window.load = async (paths) => {
  for (const path of paths) {
    const response = await fetch(`files/${path}`);
    if (!response.ok) throw new Error(`${path}: ${response.status}`);
    files.set(path, new Uint8Array(await response.arrayBuffer()));
  }
};

/** A player and the pictures that it draws. */
class Viewer {
  #player = new FvvPlayer();
  #drawn = null; // number of the last frame
  onPicture = () => {};
  errors = [];
  warnings = [];

  /** renew(url): the address that is valid now. */
  constructor(renew) {
    const player = this.#player;
    player.addEventListener("addressexpired", ({ detail }) => detail.respondWith(renew(detail.url)));
    Object.assign(player, { worker: "none", loop: true, muted: true, pixelRatio: 1, quality: "high" });
    Object.assign(player, { environment: false, shadows: false, grid: false });
    Object.assign(player, { cameraOrbit: "20deg 80deg 4m", cameraTarget: "0m 1m 0m", fieldOfView: "0.6rad" });
    player.style.cssText = `display: block; width: ${SIZE[0]}px; height: ${SIZE[1]}px`;
    player.addEventListener("warning", ({ detail }) => this.warnings.push(detail));
    player.addEventListener("error", () => this.errors.push(player.error.message));
    document.body.append(player);
    // The canvas can be read as long as the event lasts.
    const watch = () => {
      const stage = player._stage;
      if (stage && stage !== this.stage) stage.addEventListener("drawn", () => this.#see());
      this.stage = stage;
    };
    watch();
    player.addEventListener("loadstart", watch);
  }
  get player() {
    return this.#player;
  }
  #see() {
    const { currentFrame } = this.#player;
    const { data } = this.#player._stage.renderer.readPixels();
    this.onPicture({ number: currentFrame, hash: crc32c(data), data, isNew: currentFrame !== this.#drawn });
    this.#drawn = currentFrame;
  }
  open(source, options = {}) {
    this.#drawn = null;
    this.errors = [];
    this.warnings = [];
    const { rung = "auto" } = options;
    this.#player.decoderOptions = { limits: { cacheBytes: 0 } };
    Object.assign(this.#player, { rung, src: source });
    const playing = this.#player.play();
    playing.catch(() => {}); // the event "error" says why
  }
  close() {
    this.#player.remove();
  }
}

/** Everything of a part of the simulation. read: as Host takes it. */
function begin(seed, read) {
  const clock = new Clock({ isAtWork: codecs.isAtWork });
  const random = randomOf(seed);
  const host = new Host(clock, random, read);
  return { clock, random, host, figures: new Figures() };
}
function end({ clock, host }) {
  clock.end();
  host.end();
}
const fileOf = (path, version) => {
  const replaced = version % 2 ? files.get(path.replace("/", "-replaced/")) : null;
  const bytes = replaced ?? files.get(path);
  if (!bytes) throw new Error(`the host has no ${path}`);
  return bytes;
};

/** How two pictures differ: the number of values, and by how much at most. */
function difference(one, other) {
  let [count, most] = [0, 0];
  for (let i = 0; i < one.length; i++) {
    if (one[i] !== other[i]) count++;
    most = Math.max(most, Math.abs(one[i] - other[i]));
  }
  return { count, most };
}

/** The pictures of each frame that a source shows in any of its rungs, without faults: maps from hashes to their values. */
async function picturesOf(viewer, world, source, { rungs, frameCount, version = 0 }) {
  const pictures = Array.from({ length: frameCount }, () => new Map());
  for (let n = 0; n < version; n++) world.host.begin({ kind: "replaced" });
  world.host.finish();
  for (let rung = 0; rung < rungs; rung++) {
    const seen = new Map();
    viewer.onPicture = ({ number, hash, data }) => seen.set(number, [hash, data]);
    viewer.open(source, { rung: rungs > 1 ? rung : "auto" });
    for (let waited = 0; seen.size < frameCount; waited += STEP) {
      if (viewer.errors.length) throw new Error(`${source}: ${viewer.errors}`);
      if (waited > 60000) throw new Error(`${source}: ${seen.size} of ${frameCount} frames in a minute`);
      await world.clock.wait(STEP);
    }
    if (viewer.warnings.length) throw new Error(`${source}: ${viewer.warnings[0].message}`);
    for (const [number, [hash, data]] of seen) pictures[number].set(hash, data);
  }
  return pictures;
}

/** Counts what a viewer sees of one source until a time, and how long it takes until it goes on after faults. */
class Session {
  #world;
  #viewer;
  #pictures;
  #loops;
  #last = null; // number of the frame on screen
  #shownAt;
  #seeking = null;
  #waited = null; // fault that was over when nothing new had been on screen
  #frameMs;
  #name;
  shown = 0;

  /** pictures: of picturesOf. inOrder: frames come one after the other, and again from the first one on. */
  constructor(world, viewer, { path, pictures, frameMs, inOrder }) {
    Object.assign(this, { inOrder });
    this.#name = path;
    this.#world = world;
    this.#viewer = viewer;
    this.#pictures = pictures;
    this.#loops = pictures.length;
    this.#frameMs = frameMs;
    this.#shownAt = world.clock.now;
    viewer.onPicture = (picture) => this.#see(picture);
  }
  #known(number, hash) {
    if (this.inOrder) return this.#pictures[number]?.has(hash) ?? false;
    return this.#pictures.some((hashes) => hashes.has(hash));
  }
  /** Of a wrong picture: how far it is from the nearest one of the film. */
  #report(number, data) {
    const { figures, clock } = this.#world;
    const known = this.#pictures.flatMap((hashes, i) => Array.from(hashes.values(), (other) => [i, other]));
    const all = known.map(([i, other]) => ({ i, ...difference(data, other) }));
    const { i, count, most } = all.reduce((best, one) => (one.count < best.count ? one : best));
    const nearest = `${count} of ${data.length} values differ from frame ${i}, by up to ${most}`;
    figures.details.push(`${this.#name}: frame ${number} at ${Math.round(clock.now)} ms: ${nearest}`);
  }
  #see({ number, hash, data, isNew }) {
    const { figures, clock, host } = this.#world;
    if (!this.#known(number, hash)) {
      figures.wrong++;
      if (figures.details.length < 8) this.#report(number, data);
    }
    if (!isNew) return;
    figures.frames++;
    this.shown++;
    if (this.inOrder && this.#last !== null && this.#seeking === null) {
      const step = (number - this.#last + this.#loops) % this.#loops;
      if (step > 1 + SKIPPED_MAX) {
        figures.lost++;
        figures.details.push(`${this.#name}: frame ${number} after ${this.#last} at ${Math.round(clock.now)} ms`);
      }
    }
    const { player } = this.#viewer;
    if (this.#seeking !== null && !player.seeking) this.#seeking = null;
    const waited = clock.now - this.#shownAt > this.#frameMs + 200;
    if (this.#waited && waited)
      figures.recovered(this.#waited, clock.now - Math.max(host.ended, this.#waited.allowed ?? 0));
    this.#waited = null;
    this.#last = number;
    this.#shownAt = clock.now;
  }
  seek(number) {
    this.#seeking = number;
    this.#viewer.player.currentFrame = number;
  }
  /** Until a time, or an error. mayEnd(random): called about once a second. */
  async watch(ends, act = () => {}) {
    const { clock, host, figures } = this.#world;
    let fault = host.fault;
    let free = clock.now;
    for (let n = 0; clock.now < ends; n++) {
      await clock.wait(STEP);
      if (fault && !host.fault) this.#waited = fault;
      fault = host.fault;
      if (fault) free = clock.now;
      if (this.#viewer.errors.length) return this.#viewer.errors[0];
      if (clock.now - Math.max(free, this.#shownAt) > HANG_MS) {
        figures.hangs++;
        return null;
      }
      if (n % 10 === 9 && this.shown) act();
    }
    return null;
  }
}

function judge(world, viewer, { error, source, session }) {
  const { figures, host, clock } = world;
  const lately = host.fault || clock.now - (host.ended ?? -Infinity) < 10000;
  if (error && !session.shown && lately) figures.refused++;
  else if (error) figures.errors.push(`${source}: ${error}`);
  for (const { code, message } of viewer.warnings)
    if (!EXPECTED_WARNINGS.includes(code)) figures.errors.push(`${source}: ${code}: ${message}`);
}

/** films: [{path, rungs, frameCount, frameMs, replaced, shows, seeks}]. */
window.films = async ({ minutes, seed, films }) => {
  const world = begin(seed, fileOf);
  const { clock, host, random, figures } = world;
  const viewer = new Viewer((url) => host.renew(url));
  for (const film of films) {
    if (film.shows) {
      film.pictures = films.find(({ path }) => path === film.shows).pictures;
      continue;
    }
    const source = `http://host.test/${film.path}`;
    film.pictures = await picturesOf(viewer, world, source, film);
    if (!film.replaced) continue;
    const others = await picturesOf(viewer, world, source, { ...film, version: 1 });
    film.pictures.forEach((known, i) => others[i].forEach((data, hash) => known.set(hash, data)));
    world.host.begin({ kind: "replaced" });
    world.host.finish();
  }
  const stop = new AbortController();
  const faults = misfortune(world, anyFault, null, stop.signal);
  const ends = clock.now + 60000 * minutes;
  while (clock.now < ends) {
    const film = random.pick(films);
    const source = `http://host.test/${film.path}`;
    figures.sessions++;
    const session = new Session(world, viewer, { ...film, inOrder: true });
    viewer.open(host.renew(source));
    const error = await session.watch(clock.now + random.between(...SESSION), () => {
      if (film.seeks && random.random() < 0.1) session.seek(Math.floor(random.between(0, film.frameCount)));
    });
    judge(world, viewer, { error, source, session });
  }
  stop.abort();
  await faults;
  host.finish();
  figures.requests = host.requests;
  viewer.close();
  end(world);
  return { figures: figures.toJSON(), faults: faultsOf(figures) };
};

const bytesOf = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0));

/** stream: {head, groups}, chunks in base64; film: the same as a file, {path, frameCount, frameMs}. */
window.live = async ({ minutes, seed, stream, film, groupMs }) => {
  const world = begin(seed, fileOf);
  const { clock, host, random, figures } = world;
  const viewer = new Viewer((url) => host.renew(url));
  const pictures = await picturesOf(viewer, world, `http://host.test/${film.path}`, { ...film, rungs: 1 });
  const server = new LiveServer(clock, host, {
    head: bytesOf(stream.head),
    groups: stream.groups.map((chunks) => chunks.map(bytesOf)),
    groupMs,
  });
  const { WebSocket } = globalThis;
  globalThis.WebSocket = server.WebSocket;
  const stop = new AbortController();
  const faults = misfortune(world, anyLiveFault, server, stop.signal);
  const ends = clock.now + 60000 * minutes;
  while (clock.now < ends) {
    figures.sessions++;
    const source = "ws://host.test/live/x";
    const session = new Session(world, viewer, { ...film, pictures, inOrder: false });
    viewer.open(source);
    const error = await session.watch(clock.now + random.between(...LIVE_SESSION));
    judge(world, viewer, { error, source, session });
  }
  stop.abort();
  await faults;
  host.finish();
  server.end();
  viewer.close();
  globalThis.WebSocket = WebSocket;
  end(world);
  return { figures: figures.toJSON(), faults: faultsOf(figures) };
};
document.documentElement.dataset.ready = "";
