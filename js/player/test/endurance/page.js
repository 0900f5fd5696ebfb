// Plays the numbered board in a <fvv-player> for a long time, with seeks and changes of rate, and checks in every drawn
// picture that mesh and pictures are of the same frame. The element is used as on other pages, except that its clock and
// animation frames are simulated, as fast as frames arrive.

import { FvvPlayer } from "@fvv/player";

import { BACKGROUND, POSE, RATE, readBoard } from "./board_layout.js";
import { countOpenFrames, moment, mostOpen } from "./open_frames.js";

/** Milliseconds from one picture of the screen to the next. */
const REFRESH = 10;
const RATES = [0.25, 0.5, 1, 1, 2, 4, 8];
/** Real milliseconds to wait for a frame. */
const TIMEOUT = 50;
const MOST_WRONG = 5;

const changes = [];
countOpenFrames((change) => changes.push([moment(), change]));
const channel = new BroadcastChannel("video frames");
let settled = () => {};
channel.addEventListener("message", ({ data }) => (data === "settled" ? settled() : changes.push(data)));
/** Waits for the changes that the worker has reported and that are still on their way: they arrive in order. */
const settle = () =>
  new Promise((resolve, reject) => {
    settled = resolve;
    setTimeout(() => reject(new Error("the worker does not respond")), 10000);
    channel.postMessage("settle");
  });

const realNow = performance.now.bind(performance);
let time = 0;
performance.now = () => time;
let callbacks = [];
let asked = 0;
window.requestAnimationFrame = (callback) => {
  callbacks.push({ id: ++asked, callback });
  return asked;
};
window.cancelAnimationFrame = (unwanted) => (callbacks = callbacks.filter(({ id }) => id !== unwanted));

const { port1, port2 } = new MessageChannel();
/** Runs pending tasks, without the 4 ms of a timer. */
const turn = () =>
  new Promise((resolve) => {
    port1.onmessage = resolve;
    port2.postMessage(null);
  });

/** Pseudo-random numbers from 0 to 1, the same in every run. */
function randomOf(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

class Viewer {
  checked = 0;
  wrong = [];
  wrongCount = 0;
  warnings = [];
  arrivals = 0;
  failed = null;
  #sought = null;
  #changes = 0; // of the frame on screen
  #read = 0; // the one of these that was read last

  constructor(source) {
    const player = (this.player = new FvvPlayer());
    player.worker = "worker/counting_worker.js";
    player.loop = true;
    player.pixelRatio = 1;
    player.cameraOrbit = `0deg 90deg ${POSE.distance}m`;
    player.cameraTarget = "0m 0m 0m";
    player.fieldOfView = `${POSE.fov}rad`;
    Object.assign(player, { environment: false, shadows: false, grid: false });
    player.style.cssText = `width: ${POSE.width}px; height: ${POSE.height}px; --fvv-background: rgb(${BACKGROUND})`;
    player.addEventListener("seeked", () => this.#arrive());
    player.addEventListener("framechange", () => this.#changes++);
    player.addEventListener("warning", ({ detail }) => this.warnings.push(detail.message));
    player.addEventListener("error", () => (this.failed = new Error(player.error.message)));
    document.body.append(player);
    player.src = source;
  }

  #fault(what) {
    this.wrongCount++;
    if (this.wrong.length < MOST_WRONG) this.wrong.push(what);
  }

  seek(number, byTime) {
    this.#sought = number;
    if (byTime) this.player.currentTime = (number + 0.5) / RATE;
    else this.player.currentFrame = number;
  }
  #arrive() {
    if (this.#sought === null || this.player.seeking) return;
    this.arrivals++;
    const shown = this.player.currentFrame;
    if (shown !== this.#sought) this.#fault(`frame ${this.#sought} was sought, ${shown} is shown`);
    this.#sought = null;
  }

  /** Simulates an animation frame. */
  refresh() {
    if (this.failed) throw this.failed;
    time += REFRESH;
    const { drawnFrames = 0 } = this.player.stats;
    for (const { callback } of callbacks.splice(0)) callback(time);
    if (this.player.stats.drawnFrames > drawnFrames) this.#readDrawn();
  }
  #readDrawn() {
    const { mesh, picture } = readBoard(this.player._stage.renderer.readPixels());
    const { currentFrame } = this.player;
    if (mesh !== currentFrame || picture !== currentFrame)
      this.#fault(`frame ${currentFrame}: mesh ${mesh}, pictures ${picture}`);
    if (this.#read < this.#changes) this.checked++;
    this.#read = this.#changes;
  }

  /** Waits until the frame that is due has arrived, or the timeout. */
  async wait(timeout = TIMEOUT) {
    const { player } = this;
    const end = realNow() + timeout;
    const isDue = () => player.seeking || player.currentTime * RATE >= player.currentFrame + 1 - 1e-6;
    do await turn();
    while (isDue() && realNow() < end);
  }
}

let viewer = null;

/** Returns the decoder's warnings. */
window.begin = async (source) => {
  viewer = new Viewer(source);
  const { player } = viewer;
  while (player.readyState < HTMLMediaElement.HAVE_FUTURE_DATA) {
    viewer.refresh();
    await turn();
  }
  await player.play();
  return viewer.warnings;
};

/** Plays until a number of further frames was drawn. actions: number of seeks, and of changes of rate, during that. */
window.endure = async ({ frames, actions, seed }) => {
  const random = randomOf(seed);
  const { player } = viewer;
  const end = viewer.checked + frames;
  const wanted = { seeks: 0, rates: 0 };
  const seek = () => viewer.seek(Math.floor(random() * player.frameCount), random() < 0.5);
  let next = viewer.checked;
  while (viewer.checked < end) {
    if (viewer.checked >= next && wanted.seeks < actions) {
      next += frames / actions;
      wanted.seeks++;
      seek();
      // The last of several seeks wins.
      if (random() < 0.3) {
        await turn();
        viewer.refresh();
        seek();
      }
      // Always another one, so that their number is not up to chance.
      const others = RATES.filter((rate) => rate !== player.playbackRate);
      player.playbackRate = others[Math.floor(random() * others.length)];
      wanted.rates++;
    }
    viewer.refresh();
    // Sometimes time does not wait for decoding.
    if (random() < 0.9) await viewer.wait();
    else await turn();
  }
  while (player.seeking) await viewer.wait();
  const { checked, wrong, wrongCount, arrivals } = viewer;
  await settle();
  const open = mostOpen(changes);
  // The list of changes would grow.
  changes.splice(0, changes.length, [0, open.left]);
  const { framesShown, framesDropped, memoryBytes, ...counters } = player.stats;
  return {
    checked,
    wrong,
    wrongCount,
    arrivals,
    ...wanted,
    mostOpen: open.max,
    shown: framesShown,
    dropped: framesDropped,
    memoryBytes,
    counters,
  };
};
document.documentElement.dataset.ready = "";
