// Plays the numbered board for long, with seeks and changes of rate, and reads out of every picture that is drawn whether the
// mesh and the pictures in it are of one frame. Time goes on by hand, as fast as frames come.

import { createDecoder } from "@fvv/decoder";

import { Media } from "../../src/playback/media.js";
import { Renderer } from "../../src/renderer/index.js";
import { viewFromPose } from "../../src/view.js";
import { BACKGROUND, POSE, readBoard } from "./board_layout.js";
import { countOpenFrames, moment, mostOpen } from "./open_frames.js";

/** Milliseconds from one picture of the screen to the next. */
const REFRESH = 10;
const RATES = [0.25, 0.5, 1, 1, 2, 4, 8];
/** Real milliseconds that are waited for a frame to come. */
const PATIENCE = 50;
const MOST_WRONG = 5;

const view = viewFromPose(POSE);
const options = { clearColour: BACKGROUND, environment: false, shadows: false, grid: null };
const changes = [];
countOpenFrames((change) => changes.push([moment(), change]));
new BroadcastChannel("video frames").addEventListener("message", ({ data }) => changes.push(data));

const { port1, port2 } = new MessageChannel();
/** Lets everything happen that is waiting, without the 4 ms of a timer. */
const turn = () =>
  new Promise((resolve) => {
    port1.onmessage = resolve;
    port2.postMessage(null);
  });

/** Numbers from 0 to 1 that are the same in every run. */
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
  time = 0;
  checked = 0;
  wrong = [];
  wrongCount = 0;
  sought = null;
  arrivals = 0;

  constructor(source) {
    this.renderer = new Renderer(document.body.appendChild(document.createElement("canvas")), {
      contextAttributes: { antialias: false },
    });
    const worker = new URL("worker/counting_worker.js", import.meta.url);
    this.media = new Media({
      open: (file) => createDecoder({ source: file, shares: true, queue: 1, worker }),
      show: (frame) => this.renderer.show(frame),
      now: () => this.time,
    });
    this.media.loop = true;
    this.media.addEventListener("seeked", () => this.#arrive());
    this.media.load(source);
  }

  #fault(what) {
    this.wrongCount++;
    if (this.wrong.length < MOST_WRONG) this.wrong.push(what);
  }

  seek(number) {
    this.sought = number;
    this.media.currentFrame = number;
  }
  #arrive() {
    if (this.sought === null || this.media.seeking) return;
    this.arrivals++;
    const shown = this.renderer.frame.number;
    if (shown !== this.sought) this.#fault(`frame ${this.sought} was sought, ${shown} is shown`);
    this.sought = null;
  }

  /** As a picture of the screen: what is due is shown, and what has changed is drawn. */
  refresh() {
    this.time += REFRESH;
    this.media.tick();
    this.draw();
  }
  draw() {
    const { renderer } = this;
    if (!renderer.frame || !renderer.draw(view, options)) return;
    const { mesh, picture } = readBoard(renderer.readPixels());
    const { number } = renderer.frame;
    this.checked++;
    if (mesh !== number || picture !== number)
      this.#fault(`frame ${number}: the mesh says ${mesh}, the pictures say ${picture}`);
  }

  /** Until there is a frame to show next, or for as long as patience lasts. */
  async wait(ready = () => this.media.heldFrames > 0 && !this.media.seeking) {
    const end = performance.now() + PATIENCE;
    do await turn();
    while (!ready() && performance.now() < end);
  }
}

let viewer = null;

window.begin = async (source) => {
  viewer = new Viewer(source);
  const failed = new Promise((_, fail) =>
    viewer.media.addEventListener("error", () => fail(new Error(viewer.media.error.message))),
  );
  await Promise.race([failed, new Promise((loaded) => viewer.media.addEventListener("canplay", loaded))]);
  viewer.draw();
  viewer.media.play();
  return { frameCount: viewer.media.frameCount };
};

/** Plays until so many frames more were drawn; actions: seeks and changes of rate each, spread over them. */
window.endure = async ({ frames, actions, seed }) => {
  const random = randomOf(seed);
  const { media } = viewer;
  const end = viewer.checked + frames;
  const wanted = { seeks: 0, rates: 0 };
  let next = viewer.checked;
  while (viewer.checked < end) {
    if (media.error) throw new Error(media.error.message);
    if (viewer.checked >= next && wanted.seeks < actions) {
      next += frames / actions;
      wanted.seeks++;
      viewer.seek(Math.floor(random() * media.frameCount));
      // The last of several wins.
      if (random() < 0.3) {
        await turn();
        viewer.refresh();
        viewer.seek(Math.floor(random() * media.frameCount));
      }
      const rate = RATES[Math.floor(random() * RATES.length)];
      if (rate !== media.playbackRate) wanted.rates++;
      media.playbackRate = rate;
    }
    viewer.refresh();
    // Now and then time does not wait for what is decoded.
    if (random() < 0.9) await viewer.wait();
    else await turn();
  }
  await viewer.wait(() => !media.seeking);
  const { checked, wrong, wrongCount, arrivals } = viewer;
  const open = mostOpen(changes);
  // What is counted takes room itself.
  changes.splice(0, changes.length, [0, open.left]);
  return {
    checked,
    wrong,
    wrongCount,
    arrivals,
    ...wanted,
    mostOpen: open.most,
    dropped: media.meter.framesDropped,
    memoryBytes: (await media.decoder.stats()).memoryBytes,
    counters: viewer.renderer.counters,
  };
};
document.documentElement.dataset.ready = "";
