// What lies over the picture, and keeps up with the player: bar, panels, messages. It knows the player by what everyone
// may call.

import { commandOf, HeldKeys, keepsKey } from "../navigation/keys.js";
import { Bar } from "./bar.js";
import { commandsOf } from "./commands.js";
import { CamerasPanel, helpPanel, Panels, SettingsPanel, StatsOverlay } from "./panels.js";
import { element, iconButton, icons } from "./widgets.js";

/** Milliseconds without a hand on it after which the controls fade, and of waiting after which that shows. */
const IDLE = 2600;
const PATIENCE = 350;
const NOTICE = 1800;
const STATS = 500;
const AGEING = 1000;
const EVENTS =
  "play pause playing waiting seeking seeked timeupdate ended ratechange loadstart loadedmetadata canplay emptied error " +
  "progress durationchange framechange volumechange camera-change optionschange";

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
  #held;
  #spinner = element("div", { class: "spinner", role: "status", "aria-label": "Loading", hidden: true });
  #big;
  #message;
  #notice = element("div", { class: "notice", role: "status" });
  #controls;
  #idle = null;
  #waiting = null;
  #noticing = null;
  #polling = null;
  #updating = false;
  #ageing = null;

  /** root: of the shadow; stage: what the controls lie over. */
  constructor(player, root, surface, navigator, signal) {
    this.#player = player;
    this.#root = root;
    this.#panels = new Panels((name, open) => this.#expanded(name, open));
    const panels = { toggle: (name) => (name === "stats" ? this.#toggleStats() : this.#panels.toggle(name)) };
    this.#commands = commandsOf(player, panels);
    this.#held = new HeldKeys(navigator);
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
    const middle = element("div", { class: "middle" }, this.#big, this.#spinner, this.#message);
    root.append(middle, this.#statsBox, this.#controls, this.#notice);
    this.#listen(surface, signal);
    this.update();
  }

  get commands() {
    return this.#commands;
  }
  get showsStats() {
    return !this.#statsBox.hidden;
  }

  #listen(surface, signal) {
    const player = this.#player;
    for (const type of EVENTS.split(" ")) player.addEventListener(type, () => this.#soon(), { signal });
    const awake = () => this.#wake();
    for (const type of ["pointermove", "pointerdown", "keydown", "focusin"])
      player.addEventListener(type, awake, { signal, passive: true });
    player.addEventListener("keydown", (event) => this.#press(event), { signal });
    player.addEventListener("keyup", (event) => this.#held.release(event), { signal });
    player.addEventListener("focusout", () => this.#held.releaseAll(), { signal });
    addEventListener("blur", () => this.#held.releaseAll(), { signal });
    surface.addEventListener("pointerdown", () => this.#panels.closeAll(), { signal });
    signal.addEventListener("abort", () => this.#close());
  }

  #press(event) {
    const target = event.composedPath()[0];
    if (event.defaultPrevented || !this.#player.keys || keepsKey(target, event.key.toLowerCase())) return;
    if (event.key === "Escape" && this.#panels.closeAll()) return event.preventDefault();
    this.#held.flying = this.#player.navigation === "fly";
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
    const command = commandOf(event);
    if (command) this.#commands[command.command](command.value);
    else if (!(plain && this.#held.press(event))) return;
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
    clearInterval(this.#polling);
    if (open) this.#polling = setInterval(() => this.#readStats(), STATS);
    if (open) this.#readStats();
    this.#soon();
  }
  #readStats() {
    this.#stats.update(this.#player.stats);
  }

  /** Someone is there. */
  #wake() {
    this.#root.classList.remove("idle");
    clearTimeout(this.#idle);
    this.#idle = setTimeout(() => {
      const busy = this.#player.paused || this.#panels.anyOpen;
      this.#root.classList.toggle("idle", !busy);
    }, IDLE);
  }

  /** A word that goes away again, which screen readers say. */
  notify(text) {
    this.#notice.textContent = text;
    clearTimeout(this.#noticing);
    this.#noticing = setTimeout(() => (this.#notice.textContent = ""), NOTICE);
  }

  /** Once for all that happens at the same time. */
  #soon() {
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
    // What is live goes on while one stands still.
    if (player.live && !error) this.#ageing ??= setInterval(() => this.#soon(), AGEING);
    else {
      clearInterval(this.#ageing);
      this.#ageing = null;
    }
    this.#controls.hidden = !controls;
    if (paused) this.#root.classList.remove("idle");
    this.#big.hidden = !controls || !paused || error !== null || player.hasPlayed || readyState < 2;
    const waits = error === null && player.networkState !== 0 && (readyState < 3 || player.seeking) && !player.ended;
    if (!waits) {
      clearTimeout(this.#waiting);
      this.#waiting = null;
      this.#spinner.hidden = true;
    } else this.#waiting ??= setTimeout(() => (this.#spinner.hidden = false), PATIENCE);
    this.#tell(error);
    if (controls) {
      this.#bar.update();
      if (this.#panels.isOpen("cameras")) this.#cameras.update();
      if (this.#panels.isOpen("settings")) this.#settings.update();
    }
  }

  #tell(error) {
    if (this.#message.hidden === (error === null) && this.#message.dataset.text === (error?.message ?? "")) return;
    this.#message.hidden = error === null;
    this.#message.dataset.text = error?.message ?? "";
    if (!error) return this.#message.replaceChildren();
    const again = element("button", { type: "button", class: "text", onclick: () => this.#player.load() }, "Try again");
    this.#message.replaceChildren(element("p", {}, `This can't be played: ${error.message}`), again);
  }

  #close() {
    for (const timer of [this.#idle, this.#waiting, this.#noticing]) clearTimeout(timer);
    clearInterval(this.#polling);
    clearInterval(this.#ageing);
  }
}
