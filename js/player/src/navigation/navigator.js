// The viewer's pose over time: smoothed movements by pointer and keys, journeys to other poses, and views through a camera
// of the stream. The caller provides the time.

import { add } from "@fvv/shading";

import { viewFromCamera, viewOf } from "../view.js";
import {
  axesOf,
  between,
  dolly,
  extentOf,
  firstCamera,
  homePose,
  level,
  look,
  move,
  EMPTY_EXTENT,
  orbit,
  pan,
  poseOfCamera,
} from "./pose.js";

/** Time constant of smoothing in seconds. */
const SMOOTHING = 0.07;
/** A remaining movement below this is made at once; lengths are relative to the scene's radius. */
const REST = 2e-4;
const LENGTHS = ["right", "up", "forward"];
/** Limits of the distance, relative to the size of the scene. */
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
  #lens = { camera: null, weight: 0, leaving: false };
  #home = null;
  axes = axesOf("y", []);
  extent = EMPTY_EXTENT;
  pose = homePose(this.extent, undefined, this.axes, 16 / 9);
  aspect = 16 / 9;
  /** No animation, for users who prefer reduced motion. */
  calm = false;
  /** Movement per second by pressed keys. */
  drift = still();

  /** wake(): requests steps. */
  constructor(wake = () => {}) {
    super();
    this.wake = wake;
  }

  /** Takes the extent and axes of the scene from its first frame. */
  begin(frame) {
    const calibrated = frame.cameras.filter((camera) => camera.calibrated);
    this.axes = axesOf(frame.configuration.upAxis, calibrated);
    this.extent = extentOf(frame);
    const camera = firstCamera(frame.configuration, calibrated) ?? calibrated[0];
    this.#home = (aspect) => homePose(this.extent, camera, this.axes, aspect);
    this.#endJourney();
    this.#pending = still();
    this.#lens = { camera: null, weight: 0, leaving: false };
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

  /** Whether the view is exactly that of the camera. */
  get arrived() {
    return this.#journey === null && this.#lens.weight === 1 && !this.#lens.leaving;
  }

  // Movements by the user: radians, fractions of the picture's height, natural logarithm of the distance, metres.
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
  /** One of these movements by its name. */
  nudge(name, amount) {
    this.#ask({ [name]: amount });
  }
  #ask(amounts) {
    this.#endJourney();
    this.#lens.leaving = true;
    for (const [name, amount] of Object.entries(amounts)) this.#pending[name] += amount;
    this.wake();
  }
  /** The user's movement ends a journey. */
  #endJourney() {
    this.#journey?.done(false);
    this.#journey = null;
  }

  /** seconds: duration; 0: at once. Resolves to whether the pose was reached. */
  goTo(pose, seconds = 0, camera = null) {
    this.#endJourney();
    this.#pending = still();
    return new Promise((done) => {
      const weight = this.#lens.weight;
      this.#journey = {
        from: this.pose,
        to: pose,
        camera,
        weight,
        seconds: this.calm ? 0 : seconds,
        began: null,
        done,
      };
      if (camera) this.#lens = { camera, leaving: false, weight: camera.id === this.#lens.camera?.id ? weight : 0 };
      this.wake();
    });
  }
  goHome(seconds) {
    return this.goTo(this.home, seconds);
  }
  lookThrough(camera, seconds) {
    return this.goTo(poseOfCamera(camera, this.extent.centre), seconds, camera);
  }

  /** Moves the viewer with the scene, by metres: what it is about to do goes on from there. */
  carry(by) {
    const moved = (pose) => ({ ...pose, eye: add(pose.eye, by), target: add(pose.target, by) });
    this.#lens.leaving = true;
    this.pose = moved(this.pose);
    if (this.#journey) Object.assign(this.#journey, { from: moved(this.#journey.from), to: moved(this.#journey.to) });
    this.#changed("script");
    this.wake();
  }

  /** Takes the cameras of the current frame: the camera of the view may have moved. */
  follow(cameras) {
    const { camera } = this.#lens;
    const now = camera && cameras.find(({ id }) => id === camera.id);
    if (!now || now === camera) return;
    this.#lens.camera = now;
    const moved = poseOfCamera(now, this.extent.centre);
    if (this.#journey?.camera) Object.assign(this.#journey, { to: moved, camera: now });
    else if (this.#lens.weight === 1) {
      this.pose = moved;
      this.#changed("script");
    }
  }

  /** now: milliseconds. Returns whether the movement continues. */
  step(now) {
    const passed = this.#last === null ? 0.016 : Math.min((now - this.#last) / 1000, 0.1);
    const continues = this.#journey ? this.#travel(now) : this.#drive(passed);
    this.#last = continues ? now : null;
    return continues;
  }

  #travel(now) {
    const journey = this.#journey;
    journey.began ??= now;
    const { from, to, camera, weight, seconds } = journey;
    const s = seconds > 0 ? Math.min((now - journey.began) / (1000 * seconds), 1) : 1;
    this.pose = between(from, to, ease(s), this.axes);
    this.#lens.weight = camera ? weight + (1 - weight) * ease(s) : weight * (1 - ease(s));
    if (s === 1) {
      this.#journey = null;
      if (!camera) this.#lens = { camera: null, weight: 0, leaving: false };
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
    const isSmall = ([name, amount]) => Math.abs(amount) < REST * (LENGTHS.includes(name) ? this.extent.radius : 1);
    const all = this.calm || Object.entries(pending).every(isSmall);
    const fraction = all ? 1 : 1 - Math.exp(-passed / SMOOTHING);
    if (Object.values(pending).some((amount) => amount !== 0)) this.#apply(fraction);
    else if (rolled) this.#changed("user");
    return !all || drifts || rolled;
  }

  #apply(fraction) {
    const part = {};
    this.#lens.leaving = true;
    for (const name of Object.keys(this.#pending)) {
      part[name] = this.#pending[name] * fraction;
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

  /** After a camera's view, its lens and its roll fade out while the user moves. */
  #unroll(passed) {
    const moved = Object.values(this.#pending).some((amount) => amount !== 0);
    const { weight } = this.#lens;
    const rolled = this.pose.up !== this.axes.up;
    if ((weight === 1 || weight === 0) && !moved) return false;
    if (weight === 0 && !rolled) return false;
    const step = this.calm ? 1 : 1 - Math.exp(-passed / (2 * SMOOTHING));
    // orbit keeps the minimum angle to the vertical, which cameras need not have.
    this.pose = orbit(level(this.pose, step, this.axes), { theta: 0, phi: 0 }, this.axes);
    this.#lens.weight = weight * (1 - step) < 1e-3 ? 0 : weight * (1 - step);
    if (this.#lens.weight === 0) this.#lens.camera = null;
    return true;
  }

  #changed(source) {
    this.#source = source;
    this.dispatchEvent(new Event("change"));
  }
  /** The origin of the last movement: "user" or "script". */
  get source() {
    return this.#source;
  }

  /** The view for the renderer. */
  view(width, height) {
    const free = viewOf({ ...this.pose, width, height });
    const { camera, weight } = this.#lens;
    if (!camera || weight === 0) return free;
    const through = viewFromCamera(camera, width, height);
    if (weight === 1) return through;
    const mixed = (name) => free[name] + (through[name] - free[name]) * weight;
    return { ...free, fx: mixed("fx"), fy: mixed("fy"), cx: mixed("cx"), cy: mixed("cy") };
  }
}
