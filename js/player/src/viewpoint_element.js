// The part of the element that media without free viewpoints have not: where one looks from, in the manner of
// <model-viewer>, the cameras of the stream, and how the scene is shown.

import { MediaElement } from "./media_element.js";
import { Navigator } from "./navigation/navigator.js";
import { isPose, orbitOf, poseFromOrbit } from "./navigation/pose.js";
import {
  formatFieldOfView,
  formatOrbit,
  formatTarget,
  parseFieldOfView,
  parseOrbit,
  parseTarget,
} from "./navigation/view_text.js";
import { MODES } from "./renderer/surface.js";
import { QUALITIES } from "./resolution.js";

const SHOW_CAMERAS = ["none", "frusta", "pictures"];
export const VIEW_ATTRIBUTES = ["camera-orbit", "camera-target", "field-of-view"];

export class ViewpointElement extends MediaElement {
  _navigator = new Navigator(() => this._stage?.wake());
  _stage = null;
  #selected = null;
  /** What the stage draws, also before there is one. */
  #drawing = { visibleBy: "auto", soft: 0, unseen: null, shadows: true, environment: true, grid: true, cameras: null };
  #showCameras = "none";

  /** Where one looks from at first: the stream's own view, but for what attributes say. */
  get _firstPose() {
    const { home, axes } = this._navigator;
    const say = (name, parse, auto) => (this.hasAttribute(name) && parse(this.getAttribute(name), auto)) || auto;
    const orbit = say("camera-orbit", parseOrbit, orbitOf(home, axes));
    const target = say("camera-target", parseTarget, home.target);
    return poseFromOrbit(orbit, target, say("field-of-view", parseFieldOfView, home.fov), axes);
  }

  get cameraOrbit() {
    return this.getAttribute("camera-orbit") ?? "auto auto auto";
  }
  set cameraOrbit(text) {
    this.setAttribute("camera-orbit", text);
  }
  get cameraTarget() {
    return this.getAttribute("camera-target") ?? "auto auto auto";
  }
  set cameraTarget(text) {
    this.setAttribute("camera-target", text);
  }
  get fieldOfView() {
    return this.getAttribute("field-of-view") ?? "auto";
  }
  set fieldOfView(text) {
    this.setAttribute("field-of-view", text);
  }
  /** What the attributes would have to say for the view as it is. */
  getCameraAttributes() {
    const { pose, axes } = this._navigator;
    return {
      cameraOrbit: formatOrbit(orbitOf(pose, axes)),
      cameraTarget: formatTarget(pose.target),
      fieldOfView: formatFieldOfView(pose.fov),
    };
  }

  getPose() {
    const { eye, target, up, fov } = this._navigator.pose;
    return { eye: [...eye], target: [...target], up: [...up], fov };
  }
  /** What is left out stays. duration: seconds. Promises whether it arrived: a hand may take over. */
  setPose(pose, { duration = 0 } = {}) {
    const whole = { ...this.getPose(), ...pose };
    if (!isPose(whole))
      throw new TypeError("a pose is {eye, target, up, fov}: three numbers each, and radians below pi");
    return this._navigator.goTo(whole, duration);
  }
  resetView({ duration = 0 } = {}) {
    return this._navigator.goTo(this._firstPose, duration);
  }
  /** Looks through a camera of the stream. */
  snapToCamera(id, { duration = 0 } = {}) {
    const camera = this.cameras.find((one) => one.id === id && one.calibrated);
    if (!camera) throw new RangeError(`there is no calibrated camera ${id} in this frame`);
    return this._navigator.lookThrough(camera, duration);
  }
  /** Identifier of the camera that is looked through, or null. */
  get camera() {
    return this._navigator.camera;
  }
  /** As they are in the frame on screen. */
  get cameras() {
    return this._stage?.cameras ?? [];
  }

  get navigation() {
    return this.getAttribute("navigation") === "fly" ? "fly" : "orbit";
  }
  set navigation(way) {
    this.setAttribute("navigation", way);
  }
  get viewMode() {
    const mode = this.getAttribute("view-mode");
    return mode in MODES ? mode : "textured";
  }
  set viewMode(mode) {
    this.setAttribute("view-mode", mode);
  }
  get quality() {
    const quality = this.getAttribute("quality");
    return QUALITIES.includes(quality) ? quality : "auto";
  }
  set quality(quality) {
    this.setAttribute("quality", quality);
  }

  /** The stage is there: it draws what has been chosen. */
  _chooseDrawing() {
    const how = this.#showCameras;
    const outlines = { frusta: how !== "none", picturePlanes: how === "pictures", selected: this.#selected };
    this._stage?.set({ ...this.#drawing, ...outlines, mode: this.viewMode });
    this.dispatchEvent(new Event("optionschange"));
  }
  #choose(options) {
    Object.assign(this.#drawing, options);
    this._chooseDrawing();
  }
  get visibleBy() {
    return this.#drawing.visibleBy;
  }
  set visibleBy(visibleBy) {
    this.#choose({ visibleBy });
  }
  get soft() {
    return this.#drawing.soft;
  }
  set soft(soft) {
    this.#choose({ soft });
  }
  /** 0xRRGGBB, or null: as the stream says. */
  get unseen() {
    return this.#drawing.unseen;
  }
  set unseen(unseen) {
    this.#choose({ unseen });
  }
  get shadows() {
    return this.#drawing.shadows;
  }
  set shadows(shadows) {
    this.#choose({ shadows });
  }
  get environment() {
    return this.#drawing.environment;
  }
  set environment(environment) {
    this.#choose({ environment });
  }
  get grid() {
    return this.#drawing.grid;
  }
  set grid(grid) {
    this.#choose({ grid });
  }
  /** Identifiers of those that may give colours, or null for all. */
  get colourCameras() {
    return this.#drawing.cameras;
  }
  set colourCameras(ids) {
    this.#choose({ cameras: ids && [...ids] });
  }
  get showCameras() {
    return this.#showCameras;
  }
  set showCameras(how) {
    if (!SHOW_CAMERAS.includes(how)) throw new TypeError(`showCameras is one of ${SHOW_CAMERAS.join(", ")}`);
    this.#showCameras = how;
    this._chooseDrawing();
  }
  get selectedCamera() {
    return this.#selected;
  }
  set selectedCamera(id) {
    this.#selected = id;
    this._chooseDrawing();
  }
  get hasEnvironment() {
    return (this._stage?.backgrounds.length ?? 0) > 0;
  }
}
