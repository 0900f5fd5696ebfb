// The viewer's place as it changes: what hands and keys ask for, smoothed, journeys to other places, and looking through
// a camera of the stream. Time comes from outside.

import { viewFromCamera, viewFromPose } from "../view.js";
import {
  axesOf,
  between,
  dolly,
  extentOf,
  homePose,
  level,
  look,
  move,
  NOTHING,
  orbit,
  pan,
  poseOfCamera,
} from "./pose.js";

/** Seconds in which two thirds of what was asked for is done. */
const SMOOTHING = 0.07;
/** What is left below this share of a unit is done at once. */
const REST = 2e-4;
/** Times the size of the scene. */
const NEAREST = 0.02;
const FARTHEST = 30;

const ease = (s) => (s < 0.5 ? 4 * s ** 3 : 1 - (2 - 2 * s) ** 3 / 2);
const still = () => ({
  theta: 0,
  phi: 0,
  lookTheta: 0,
  lookPhi: 0,
  panX: 0,
  panY: 0,
  dolly: 0,
  right: 0,
  up: 0,
  forward: 0,
});

export class Navigator extends EventTarget {
  #pending = still();
  #journey = null;
  #last = null;
  #source = "script";
  #lens = { camera: null, share: 0, leaving: false };
  #home = null;
  axes = axesOf("y", []);
  extent = NOTHING;
  pose = homePose(this.extent, [], this.axes, 16 / 9);
  aspect = 16 / 9;
  /** Nothing goes on by itself when someone has asked for calm. */
  calm = false;
  /** What held keys ask for in a second, in the same units. */
  drift = still();

  /** wake(): steps are wanted. */
  constructor(wake = () => {}) {
    super();
    this.wake = wake;
  }

  /** The scene, as the first frame shows it. */
  begin(frame) {
    const calibrated = frame.cameras.filter((camera) => camera.calibrated);
    this.axes = axesOf(frame.configuration.upAxis, calibrated);
    this.extent = extentOf(frame);
    this.#home = (aspect) => homePose(this.extent, calibrated, this.axes, aspect);
    this.pose = this.home;
    this.#changed("script");
  }
  get home() {
    return this.#home ? this.#home(this.aspect) : this.pose;
  }
  get limits() {
    const { radius } = this.extent;
    return { nearest: NEAREST * radius, farthest: FARTHEST * radius };
  }
  /** Identifier of the camera that is looked through, or is about to be; null: none. */
  get camera() {
    if (this.#journey) return this.#journey.camera?.id ?? null;
    return this.#lens.leaving ? null : (this.#lens.camera?.id ?? null);
  }

  // What hands ask for: radians, shares of the picture's height, natural logarithm of the distance, metres.
  orbitBy(theta, phi) {
    this.#ask({ theta, phi });
  }
  lookBy(lookTheta, lookPhi) {
    this.#ask({ lookTheta, lookPhi });
  }
  panBy(panX, panY) {
    this.#ask({ panX, panY });
  }
  dollyBy(amount) {
    this.#ask({ dolly: amount });
  }
  moveBy(right, up, forward) {
    this.#ask({ right, up, forward });
  }
  /** One of them by its name, as keys do. */
  nudge(name, amount) {
    this.#ask({ [name]: amount });
  }
  #ask(amounts) {
    this.#leave();
    this.#lens.leaving = true;
    for (const [name, amount] of Object.entries(amounts)) this.#pending[name] += amount;
    this.wake();
  }
  /** A journey ends where a hand takes over. */
  #leave() {
    this.#journey?.done(false);
    this.#journey = null;
  }

  /** seconds: 0 is at once. Promises whether it arrived. */
  goTo(pose, seconds = 0, camera = null) {
    this.#leave();
    this.#pending = still();
    return new Promise((done) => {
      const share = this.#lens.share;
      this.#journey = { from: this.pose, to: pose, camera, share, seconds: this.calm ? 0 : seconds, began: null, done };
      if (camera) this.#lens = { camera, leaving: false, share: camera.id === this.#lens.camera?.id ? share : 0 };
      this.wake();
    });
  }
  goHome(seconds) {
    return this.goTo(this.home, seconds);
  }
  lookThrough(camera, seconds) {
    return this.goTo(poseOfCamera(camera, this.extent.centre), seconds, camera);
  }

  /** Cameras of the frame that is shown: the one that is looked through may have moved. */
  follow(cameras) {
    const { camera } = this.#lens;
    const now = camera && cameras.find(({ id }) => id === camera.id);
    if (!now || now === camera) return;
    this.#lens.camera = now;
    const moved = poseOfCamera(now, this.extent.centre);
    if (this.#journey?.camera) Object.assign(this.#journey, { to: moved, camera: now });
    else if (this.#lens.share === 1) {
      this.pose = moved;
      this.#changed("script");
    }
  }

  /** now: milliseconds. Answers whether it goes on. */
  step(now) {
    const passed = this.#last === null ? 0.016 : Math.min((now - this.#last) / 1000, 0.1);
    const goesOn = this.#journey ? this.#travel(now) : this.#drive(passed);
    this.#last = goesOn ? now : null;
    return goesOn;
  }

  #travel(now) {
    const journey = this.#journey;
    journey.began ??= now;
    const { from, to, camera, share, seconds } = journey;
    const s = seconds > 0 ? Math.min((now - journey.began) / (1000 * seconds), 1) : 1;
    this.pose = between(from, to, ease(s), this.axes);
    this.#lens.share = camera ? share + (1 - share) * ease(s) : share * (1 - ease(s));
    if (s === 1) {
      this.#journey = null;
      if (!camera) this.#lens = { camera: null, share: 0, leaving: false };
      journey.done(true);
    }
    this.#changed("script");
    return s < 1;
  }

  #drive(passed) {
    const pending = this.#pending;
    const { drift } = this;
    let drifts = false;
    for (const name of Object.keys(drift)) {
      pending[name] += drift[name] * passed;
      drifts ||= drift[name] !== 0;
    }
    const rolled = this.#unroll(passed);
    const all = this.calm || Object.values(pending).every((amount) => Math.abs(amount) < REST);
    const share = all ? 1 : 1 - Math.exp(-passed / SMOOTHING);
    if (Object.values(pending).some((amount) => amount !== 0)) this.#apply(share);
    else if (rolled) this.#changed("user");
    return !all || drifts || rolled;
  }

  #apply(share) {
    const part = {};
    this.#lens.leaving = true;
    for (const name of Object.keys(this.#pending)) {
      part[name] = this.#pending[name] * share;
      this.#pending[name] -= part[name];
    }
    let { pose } = this;
    const { axes, limits } = this;
    if (part.theta || part.phi) pose = orbit(pose, part, axes);
    if (part.lookTheta || part.lookPhi) pose = look(pose, { theta: part.lookTheta, phi: part.lookPhi }, axes);
    if (part.panX || part.panY) pose = pan(pose, part.panX, part.panY);
    if (part.dolly) pose = dolly(pose, Math.exp(part.dolly), limits);
    if (part.right || part.up || part.forward) pose = move(pose, [part.right, part.up, part.forward]);
    this.pose = pose;
    this.#changed("user");
  }

  /** Out of a camera's view: its lens and its roll go as one moves on. */
  #unroll(passed) {
    const moved = Object.values(this.#pending).some((amount) => amount !== 0);
    const { share } = this.#lens;
    const rolled = this.pose.up !== this.axes.up;
    if ((share === 1 || share === 0) && !moved) return false;
    if (share === 0 && !rolled) return false;
    const step = this.calm ? 1 : 1 - Math.exp(-passed / (2 * SMOOTHING));
    // Level, one can't look straight down, as cameras can.
    this.pose = orbit(level(this.pose, step, this.axes), { theta: 0, phi: 0 }, this.axes);
    this.#lens.share = share * (1 - step) < 1e-3 ? 0 : share * (1 - step);
    if (this.#lens.share === 0) this.#lens.camera = null;
    return true;
  }

  #changed(source) {
    this.#source = source;
    this.dispatchEvent(new Event("change"));
  }
  /** Who moved last: "user" or "script". */
  get source() {
    return this.#source;
  }

  /** As the renderer takes it. */
  view(width, height) {
    const free = viewFromPose({ ...this.pose, width, height });
    const { camera, share } = this.#lens;
    if (!camera || share === 0) return free;
    const through = viewFromCamera(camera, width, height);
    if (share === 1) return through;
    const mixed = (name) => free[name] + (through[name] - free[name]) * share;
    return { ...free, fx: mixed("fx"), fy: mixed("fy"), cx: mixed("cx"), cy: mixed("cy") };
  }
}
