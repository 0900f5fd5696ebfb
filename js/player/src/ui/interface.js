// The interface over the picture: bar, panels, messages, keys. It uses the public interface of the player.

import { commandOf, MovementKeys, keepsKey } from "../navigation/keys.js";
import { Bar } from "./bar.js";
import { commandsOf } from "./commands.js";
import { CamerasPanel, helpPanel, Panels, SettingsPanel, StatsOverlay } from "./panels.js";
import { SheetButtons } from "./sheet.js";
import { element, iconButton, icons } from "./widgets.js";

/** Milliseconds without input after which the controls fade. */
const IDLE_MS = 2600;
/** Milliseconds of waiting after which the spinner is shown. */
const SPINNER_DELAY_MS = 350;
/** How long a notice is shown. */
const NOTICE_MS = 1800;
/** Intervals of updates of the statistics, and of the live delay. */
const STATS_MS = 500;
const LIVE_MS = 1000;
const EVENTS =
  "play pause playing waiting seeking seeked timeupdate ended ratechange loadstart loadedmetadata canplay emptied error " +
  "progress stalled recovered durationchange framechange volumechange camera-change optionschange";

const LOST_CONTEXT =
  "Cannot draw this: the browser has taken the WebGL context away and has not given it back, because of a graphics driver " +
  "that failed or too many pictures at once.";

/** Names of codecs, and whether @fvv/video-fallback decodes them. */
const CODECS = {
  avc1: { name: "H.264", fallback: true, browsers: "current versions of Chrome, Edge, Firefox and Safari" },
  hvc1: { name: "HEVC", fallback: true, browsers: "Safari, and Chrome or Edge on most computers with a GPU" },
  vp09: { name: "VP9", fallback: true, browsers: "current versions of Chrome, Edge and Firefox" },
  av01: { name: "AV1", fallback: false, browsers: "current versions of Chrome, Edge and Firefox" },
};

/** Says which pictures are missing, and what would help. */
function missingPictures(codecs) {
  const known = codecs.map((codec) => CODECS[codec] ?? { name: codec, fallback: false, browsers: "another browser" });
  const names = known.map(({ name }) => name).join(" and ");
  const browsers = [...new Set(known.map((one) => one.browsers))].join("; ");
  const help = known.every(({ fallback }) => fallback) ? " The page can also add @fvv/video-fallback." : "";
  return `No pictures: this browser does not decode ${names} video. It plays in ${browsers}.${help}`;
}

export class Interface {
  #player;
  #root;
  #bar;
  #panels;
  #cameras;
  #settings;
  #stats = new StatsOverlay();
  #statsBox;
  #commands;
  #movement;
  #spinner = element("div", { class: "spinner", role: "status", "aria-label": "Loading", hidden: true });
  #outage = element("div", { class: "outage", role: "status", hidden: true });
  #big;
  #message;
  #notice = element("div", { class: "notice", role: "status" });
  #missing = element("div", { class: "missing", role: "status", hidden: true });
  #sheet;
  #controls;
  #idleTimer = null;
  #spinnerTimer = null;
  #noticeTimer = null;
  #statsTimer = null;
  #updating = false;
  #liveTimer = null;

  /** root: container of the interface; surface: the element below the controls. */
  constructor(player, root, surface, navigator, signal) {
    this.#player = player;
    this.#root = root;
    this.#panels = new Panels((name, open) => this.#expanded(name, open));
    const panels = { toggle: (name) => (name === "stats" ? this.#toggleStats() : this.#panels.toggle(name)) };
    this.#commands = commandsOf(player, panels);
    this.#movement = new MovementKeys(navigator);
    this.#bar = new Bar(player, this.#commands);
    this.#cameras = new CamerasPanel(player);
    this.#settings = new SettingsPanel(player, this.#commands);
    this.#panels.add("cameras", "Cameras", this.#cameras.node, () => this.#cameras.update());
    this.#panels.add("settings", "Settings", this.#settings.node, () => this.#settings.update());
    this.#panels.add("help", "Keys", helpPanel());
    this.#big = iconButton("Play", icons.play, this.#commands.togglePlay, {
      class: "icon big",
      part: "button big-play",
      hidden: true,
    });
    this.#message = element("div", { class: "message", role: "alert", hidden: true });
    this.#statsBox = element("div", { class: "stats-box", hidden: true }, this.#stats.node);
    this.#stats.node.hidden = false;
    this.#controls = element("div", { class: "controls" }, this.#panels.node, this.#bar.node);
    const middle = element("div", { class: "middle" }, this.#big, this.#spinner, this.#outage, this.#message);
    this.#sheet = new SheetButtons(player);
    root.append(this.#sheet.node, middle, this.#statsBox, this.#controls, this.#missing, this.#notice);
    this.#listen(surface, signal);
    this.update();
  }

  /** canvas: with the picture that was just drawn. */
  keepPreview(canvas) {
    const { controls, live, seekable, seeking, contactSheet } = this.#player;
    if (controls && !live && seekable.length && !seeking && !contactSheet.length)
      this.#bar.scrubber.keepPreview(canvas);
  }
  get commands() {
    return this.#commands;
  }
  get showsStats() {
    return !this.#statsBox.hidden;
  }

  #listen(surface, signal) {
    const player = this.#player;
    for (const type of EVENTS.split(" ")) player.addEventListener(type, () => this.#scheduleUpdate(), { signal });
    const awake = () => this.#wake();
    for (const type of ["pointermove", "pointerdown", "keydown", "focusin"])
      player.addEventListener(type, awake, { signal, passive: true });
    player.addEventListener("keydown", (event) => this.#press(event), { signal });
    player.addEventListener("keyup", (event) => this.#movement.release(event), { signal });
    player.addEventListener("focusout", () => this.#movement.releaseAll(), { signal });
    addEventListener("blur", () => this.#movement.releaseAll(), { signal });
    player.addEventListener("emptied", () => this.#bar.scrubber.forgetPreviews(), { signal });
    // Over the camera's picture of a phone, the controls are not a part of the scene.
    this.#controls.addEventListener("beforexrselect", (event) => event.preventDefault());
    surface.addEventListener("pointerdown", () => this.#panels.closeAll(), { signal });
    signal.addEventListener("abort", () => this.#close());
  }

  #press(event) {
    const target = event.composedPath()[0];
    if (event.defaultPrevented || !this.#player.keys || keepsKey(target, event.key.toLowerCase())) return;
    if (event.key === "Escape" && this.#panels.closeAll()) return event.preventDefault();
    this.#movement.flying = this.#player.navigation === "fly";
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
    const command = commandOf(event);
    if (command) this.#commands[command.command](command.value);
    else if (!(plain && this.#movement.press(event))) return;
    event.preventDefault();
  }

  #expanded(name, open) {
    this.#bar.buttons[name]?.setAttribute("aria-expanded", String(open));
    this.#wake();
  }
  #toggleStats() {
    const open = this.#statsBox.hidden;
    this.#statsBox.hidden = !open;
    this.#bar.buttons.stats.setAttribute("aria-pressed", String(open));
    clearInterval(this.#statsTimer);
    if (open) this.#statsTimer = setInterval(() => this.#readStats(), STATS_MS);
    if (open) this.#readStats();
    this.#scheduleUpdate();
  }
  #readStats() {
    this.#stats.update(this.#player.stats);
  }

  /** Shows the controls, and hides them after a while without input. */
  #wake() {
    this.#root.classList.remove("idle");
    clearTimeout(this.#idleTimer);
    this.#idleTimer = null;
    this.#awaitIdleness();
  }
  #awaitIdleness() {
    this.#idleTimer ??= setTimeout(() => {
      this.#idleTimer = null;
      const busy = this.#player.paused || this.#panels.anyOpen;
      this.#root.classList.toggle("idle", !busy);
    }, IDLE_MS);
  }

  /** Shows a text for a while; screen readers announce it. */
  notify(text) {
    this.#notice.textContent = text;
    clearTimeout(this.#noticeTimer);
    this.#noticeTimer = setTimeout(() => (this.#notice.textContent = ""), NOTICE_MS);
  }

  /** Updates once for all events of the same moment. */
  #scheduleUpdate() {
    if (this.#updating) return;
    this.#updating = true;
    queueMicrotask(() => {
      this.#updating = false;
      this.update();
    });
  }

  update() {
    const player = this.#player;
    const { controls, error, paused, readyState } = player;
    // A live stream continues while the player is paused.
    if (player.live && !error) this.#liveTimer ??= setInterval(() => this.#scheduleUpdate(), LIVE_MS);
    else {
      clearInterval(this.#liveTimer);
      this.#liveTimer = null;
    }
    this.#controls.hidden = !controls;
    if (paused) this.#root.classList.remove("idle");
    // Playback may begin without input.
    else if (!this.#root.classList.contains("idle")) this.#awaitIdleness();
    this.#big.hidden =
      !controls || !paused || error !== null || player.wasUsed || readyState < 2 || player.contactSheet.length > 0;
    const isWaiting =
      error === null && player.networkState !== 0 && (readyState < 3 || player.seeking) && !player.ended;
    // A button that offers to play needs no spinner beside it: it would be over a picture that is there.
    if (!isWaiting || !this.#big.hidden) {
      clearTimeout(this.#spinnerTimer);
      this.#spinnerTimer = null;
      this.#spinner.hidden = true;
    } else this.#spinnerTimer ??= setTimeout(() => (this.#spinner.hidden = false), SPINNER_DELAY_MS);
    this.#showOutage(isWaiting ? player.outage : null);
    this.#showTrouble(error);
    this.#showMissing(player.unsupportedCodecs);
    this.#sheet.update();
    if (controls) {
      this.#bar.update();
      if (this.#panels.isOpen("cameras")) this.#cameras.update();
      if (this.#panels.isOpen("settings")) this.#settings.update();
    }
  }

  /** While nothing is left to play: why, for those who wait. */
  #showOutage(outage) {
    this.#outage.hidden = outage === null;
    this.#outage.title = outage?.reason ?? "";
    const text = outage?.offline ? "Offline: waiting for the network" : "The connection is interrupted: trying again";
    const shown = outage ? text : "";
    if (this.#outage.textContent !== shown) this.#outage.textContent = shown;
  }

  /** What ended playback, or drawing, and a button to try again. */
  #showTrouble(error) {
    const lost = error === null && this.#player.contextLost;
    const text = error ? `Cannot play this: ${error.message}` : lost ? LOST_CONTEXT : "";
    if (this.#message.dataset.text === text) return;
    this.#message.hidden = text === "";
    this.#message.dataset.text = text;
    if (!text) return this.#message.replaceChildren();
    const retry = () => (lost ? this.#player.renewContext() : this.#player.load());
    const again = element("button", { type: "button", class: "text", onclick: retry }, "Try again");
    this.#message.replaceChildren(element("p", {}, text), again);
  }

  /** What is missing, and what would help, until the user closes it. */
  #showMissing(codecs) {
    const key = codecs.join();
    if (this.#missing.dataset.codecs === key) return;
    this.#missing.dataset.codecs = key;
    this.#missing.hidden = !codecs.length;
    const close = iconButton("Close", icons.close, () => (this.#missing.hidden = true));
    this.#missing.replaceChildren(...(codecs.length ? [element("p", {}, missingPictures(codecs)), close] : []));
  }

  #close() {
    for (const timer of [this.#idleTimer, this.#spinnerTimer, this.#noticeTimer]) clearTimeout(timer);
    clearInterval(this.#statsTimer);
    clearInterval(this.#liveTimer);
  }
}
