// The part of the element for free viewpoints: the view, in the manner of <model-viewer>, the cameras of the stream, and the
// drawing options.

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
import { degreesOf, radiansOf } from "./view.js";

/** Values of the attribute quality, which pixel-ratio has replaced; it remains for one version. */
const FORMER_QUALITIES = { high: 2, medium: 1, low: 0.5 };
const SHOW_CAMERAS = ["none", "frusta", "pictures", "sheet"];
/** CSS pixels below a contact sheet for the bar. */
const BAR = 100;
export const VIEW_ATTRIBUTES = ["camera-orbit", "camera-target", "field-of-view"];

export class ViewpointElement extends MediaElement {
  _navigator = new Navigator(() => this._stage?.wake());
  _stage = null;
  #selected = null;
  #waiting = []; // movements before the first frame: {move, resolve, reject}
  /** Drawing options, kept also while there is no stage. */
  #drawing = {
    visibleBy: "auto",
    blend: null,
    unseen: null,
    shadows: true,
    environment: true,
    grid: true,
    cameras: null,
  };
  #showCameras = null;
  /** Whether the user or a script has played, sought or chosen a view since the source was loaded. */
  wasUsed = false;
  #leftSheet = false; // a camera of the contact sheet was chosen

  /** The first view: the stream's own view, overridden by attributes. */
  get _firstPose() {
    const { home, axes } = this._navigator;
    const valueOf = (name, parse, auto) => (this.hasAttribute(name) && parse(this.getAttribute(name), auto)) || auto;
    const orbit = valueOf("camera-orbit", parseOrbit, orbitOf(home, axes));
    const target = valueOf("camera-target", parseTarget, home.target);
    return poseFromOrbit(orbit, target, valueOf("field-of-view", parseFieldOfView, home.fov), axes);
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
  /** The values of the attributes for the current view. */
  getCameraAttributes() {
    const { pose, axes } = this._navigator;
    return {
      cameraOrbit: formatOrbit(orbitOf(pose, axes)),
      cameraTarget: formatTarget(pose.target, this._navigator.extent.radius),
      fieldOfView: formatFieldOfView(pose.fov),
    };
  }

  /** fov: vertical, degrees. */
  getPose() {
    const { eye, target, up, fov } = this._navigator.pose;
    return { eye: [...eye], target: [...target], up: [...up], fov: degreesOf(fov) };
  }
  /**
   * What is at a place of the picture, {time, frame, position, normal, face, object, camera, ...}, as pick of @fvv/analysis
   * returns it; null: nothing. x, y: CSS pixels from the top left corner of the element; or x is a ray, {origin, direction}, in
   * the coordinates of the stream. The first call loads the module.
   */
  async pick(x, y) {
    const isRay = typeof x === "object" && x !== null;
    if (!isRay && !(Number.isFinite(x) && Number.isFinite(y)))
      throw new TypeError(`pick: expected x and y, or a ray, found ${x} and ${y}`);
    // As they are now: playback goes on while the module is loaded.
    const shown = this.contactSheet.length ? null : this._stage?.shown;
    if (!shown) return null;
    const { pick, rayThrough } = await import("@fvv/analysis");
    return pick(shown.frame, isRay ? x : rayThrough(shown.view, x, y));
  }

  /** Calls move as soon as there is a frame. The promise resolves to false if the source fails or is replaced before. */
  #withFrame(move) {
    if (this._stage?.empty === false && this.readyState > 0) return move();
    return new Promise((resolve, reject) => this.#waiting.push({ move, resolve, reject }));
  }
  _beginMoves() {
    for (const { move, resolve, reject } of this.#waiting.splice(0))
      try {
        resolve(move());
      } catch (error) {
        reject(error);
      }
  }
  _abandonMoves() {
    for (const { resolve } of this.#waiting.splice(0)) resolve(false);
  }
  /**
   * Omitted fields are kept. duration: seconds. Before the first frame it waits for that. Resolves to false if the user
   * interrupts the movement.
   */
  setPose(pose, { duration = 0 } = {}) {
    const given = { ...pose };
    if (given.fov !== undefined) {
      given.fov = radiansOf(given.fov);
      // Version 0.1 had radians.
      if (pose.fov > 0 && pose.fov < Math.PI)
        console.warn(`<fvv-player>: fov is in degrees, and ${pose.fov} are very few`);
    }
    if (!isPose({ ...this._navigator.pose, ...given }))
      throw new TypeError(
        "pose: expected {eye, target, up, fov}: three vectors of three numbers, and degrees below 180",
      );
    return this.#withFrame(() => this._navigator.goTo({ ...this._navigator.pose, ...given }, duration));
  }
  resetView({ duration = 0 } = {}) {
    return this._navigator.goTo(this._firstPose, duration);
  }
  /** Moves to the view of a camera of the stream, as setPose does. From a contact sheet it goes there at once. */
  snapToCamera(id, { duration = 0 } = {}) {
    return this.#withFrame(() => this.#snapToCamera(id, duration));
  }
  #snapToCamera(id, duration) {
    const camera = this.cameras.find((one) => one.id === id && one.calibrated);
    if (!camera) throw new RangeError(`no calibrated camera ${id} in this frame`);
    this.wasUsed = true;
    if (this.showCameras === "sheet") {
      this.#showCameras = null;
      this.#leftSheet = true;
      this._chooseDrawing();
      return this._navigator.lookThrough(camera, 0);
    }
    return this._navigator.lookThrough(camera, duration);
  }
  /** Identifier of the camera of the view, or null. */
  get camera() {
    return this._navigator.camera;
  }
  /** The cameras as they are in the frame on screen. */
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
  /** "auto", or the most pixels that are drawn for a pixel of the page. */
  get pixelRatio() {
    const text = this.getAttribute("pixel-ratio") ?? FORMER_QUALITIES[this.getAttribute("quality")];
    const ratio = Number(text);
    return ratio > 0 && Number.isFinite(ratio) ? ratio : "auto";
  }
  set pixelRatio(ratio) {
    this.setAttribute("pixel-ratio", ratio);
  }

  /** "auto", or the rung of the stream's ladder that is wanted, 0 for the best. */
  get rung() {
    const text = this.getAttribute("rung") ?? "";
    return /^\d{1,5}$/.test(text) ? Number(text) : "auto";
  }
  set rung(rung) {
    this.setAttribute("rung", rung);
  }

  /** Cameras of another stream have other identifiers. */
  _forgetCameras() {
    this.#drawing.cameras = this.#selected = null;
    this.#leftSheet = false;
  }

  /** Applies the drawing options to the stage. */
  _chooseDrawing() {
    const how = this.showCameras;
    this._stage?.set({
      ...this.#drawing,
      mode: this.viewMode,
      frusta: how === "frusta" || how === "pictures",
      picturePlanes: how === "pictures",
      selected: this.#selected,
      sheet: how === "sheet",
      sheetBottom: this.controls ? BAR : 0,
    });
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
  /** viewer, paper, or null: as the stream specifies. */
  get blend() {
    return this.#drawing.blend;
  }
  set blend(blend) {
    this.#choose({ blend });
  }
  /** 0xRRGGBB, or null: the stream's value. */
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
  /** Identifiers of the cameras that may give colours; null: all. */
  get colourCameras() {
    return this.#drawing.cameras;
  }
  set colourCameras(ids) {
    this.#choose({ cameras: ids && [...ids] });
  }
  get showCameras() {
    if (this.#showCameras !== null) return this.#showCameras;
    if (!this.onlyPictures) return "none";
    return this.#leftSheet ? "pictures" : "sheet";
  }
  /** null: the contact sheet for streams of pictures only, and the pictures once a camera was chosen; otherwise none. */
  set showCameras(how) {
    if (how !== null && !SHOW_CAMERAS.includes(how))
      throw new TypeError(`showCameras: expected null or one of ${SHOW_CAMERAS.join(", ")}`);
    this.#showCameras = how;
    this.#leftSheet = false;
    this._chooseDrawing();
  }
  /** Whether the stream on screen has pictures of cameras and no meshes. */
  get onlyPictures() {
    return this._stage?.onlyPictures ?? false;
  }
  /** The cells of the contact sheet, {camera, x, y, width, height} in fractions of the picture; empty if it is not shown. */
  get contactSheet() {
    return this.showCameras === "sheet" ? (this._stage?.sheetCells ?? []) : [];
  }
  get selectedCamera() {
    return this.#selected;
  }
  set selectedCamera(id) {
    this.#selected = id;
    this._chooseDrawing();
  }
  get hasEnvironment() {
    return (this._stage?.environments.length ?? 0) > 0;
  }
}
