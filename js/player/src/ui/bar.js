// The bar of controls, with the slider for seeking.

import { MODES, SPEEDS } from "./commands.js";
import { Previews } from "./previews.js";
import { clockTime, element, iconButton, icons, leavesOut, rateText, select, setIcon, spokenTime } from "./widgets.js";

/** More groups than these are not marked, because their marks would merge. */
const MAX_MARKS = 80;

/** The slider for seeking; groups and buffered, played and looped ranges are drawn below it. */
class Scrubber {
  #player;
  #buffered = []; // an element for each range
  #played = element("div", { class: "played", part: "played" });
  #loop = element("div", { class: "looped", part: "loop", hidden: true });
  #marks = element("div", { class: "marks" });
  #marked = null; // the groups that are marked
  #previews = new Previews();
  #when = element("output", {});
  #tip = element("div", { class: "tip", "aria-hidden": "true", hidden: true }, this.#previews.node, this.#when);
  #track;
  #input;
  #dragging = false;

  constructor(player) {
    this.#player = player;
    this.#input = element("input", {
      type: "range",
      "aria-label": "Seek",
      min: 0,
      max: 1,
      step: "any",
      value: 0,
      disabled: true,
      oninput: () => this.#scrub(),
      onpointerdown: () => (this.#dragging = true),
      onpointerup: () => (this.#dragging = false),
      onpointercancel: () => (this.#dragging = false),
      onpointermove: (event) => this.#point(event),
      onpointerleave: () => (this.#tip.hidden = true),
    });
    this.#track = element("div", { class: "track" }, this.#loop, this.#played, this.#marks);
    this.node = element("div", { class: "scrubber", part: "scrubber" }, this.#track, this.#input, this.#tip);
  }

  get #range() {
    const { seekable, duration } = this.#player;
    if (seekable.length) return [seekable.start(0), seekable.end(0)];
    return [0, Number.isFinite(duration) && duration > 0 ? duration : 1];
  }

  #scrub() {
    this.#player.currentTime = Number(this.#input.value);
    this.update();
  }

  #point(event) {
    if (this.#input.disabled || event.pointerType === "touch") return;
    const { left, width } = this.#input.getBoundingClientRect();
    const fraction = Math.min(Math.max((event.clientX - left) / width, 0), 1);
    const [start, end] = this.#range;
    const seconds = start + fraction * (end - start);
    const frame = this.#player.frameAt(seconds);
    this.#when.textContent = frame === null ? clockTime(seconds) : `${clockTime(seconds)}, frame ${frame}`;
    this.#previews.show(frame, this.#player.frameCount);
    this.#tip.hidden = false;
    this.#tip.style.setProperty("--at", fraction);
  }

  update() {
    const player = this.#player;
    const [start, end] = this.#range;
    const fraction = (seconds) => Math.min(Math.max((seconds - start) / (end - start), 0), 1);
    const place = (node, from, to) => {
      node.style.setProperty("--from", fraction(from));
      node.style.setProperty("--to", Math.max(fraction(from), fraction(to)));
    };
    const input = this.#input;
    const now = player.currentTime;
    input.disabled = player.seekable.length === 0;
    // Changing the slider would interrupt dragging.
    if (!this.#dragging) Object.assign(input, { min: start, max: end, value: now });
    // During playback screen readers get an update once per second.
    const spoken = `${spokenTime(player.paused ? now : Math.floor(now))} of ${spokenTime(end)}`;
    if (input.getAttribute("aria-valuetext") !== spoken) input.setAttribute("aria-valuetext", spoken);
    place(this.#played, start, now);
    const { buffered, loopRange } = player;
    for (const node of this.#buffered.splice(buffered.length)) node.remove();
    for (let i = 0; i < buffered.length; i++) {
      this.#buffered[i] ??= this.#track.insertBefore(
        element("div", { class: "buffered", part: "buffered" }),
        this.#loop,
      );
      place(this.#buffered[i], buffered.start(i), buffered.end(i));
    }
    this.#mark(player.groups, fraction);
    this.#loop.hidden = loopRange === null;
    if (loopRange) place(this.#loop, loopRange.from, loopRange.to);
  }
  /** A mark where each group but the first begins. Groups are replaced, never changed. */
  #mark(groups, fraction) {
    if (groups === this.#marked) return;
    this.#marked = groups;
    const places = groups.length <= MAX_MARKS ? groups.slice(1).map(({ start }) => fraction(start)) : [];
    this.#marks.replaceChildren(
      ...places.map((at) => {
        const mark = element("i", {});
        mark.style.setProperty("--at", at);
        return mark;
      }),
    );
  }

  /** Keeps a small copy of the picture that was drawn. */
  keepPreview(canvas) {
    const { currentFrame, frameCount } = this.#player;
    if (frameCount) this.#previews.keep(canvas, currentFrame, frameCount);
  }
  forgetPreviews() {
    this.#previews.forget();
  }
}

/** Seconds behind the live edge from which the delay is displayed. */
const LATE = 1;

function setLabel(button, text) {
  if (button.title === text) return;
  button.title = text;
  button.setAttribute("aria-label", text);
}

export class Bar {
  #player;
  #parts;
  #scrubber;
  #now = element("span", { class: "now" });
  #total = element("span", { class: "total" });

  constructor(player, commands) {
    this.#player = player;
    this.#scrubber = new Scrubber(player);
    const button = (name, text, path, command, more = {}) =>
      iconButton(text, path, command, { part: `button ${name}`, disabled: false, ...more });
    const panel = { "aria-expanded": "false", "aria-haspopup": "dialog" };
    this.#parts = {
      play: button("play", "Play", icons.play, commands.togglePlay),
      back: button("step-back", "Frame back", icons.back, () => commands.step(-1)),
      forward: button("step-forward", "Frame forward", icons.forward, () => commands.step(1)),
      time: element("span", { class: "time", part: "time" }, this.#now, this.#total),
      live: element(
        "button",
        { type: "button", class: "live", part: "button live", hidden: true, onclick: commands.goLive },
        "Live",
      ),
      sound: button("sound", "Mute", icons.sound, commands.toggleSound, { hidden: true }),
      loop: button("loop", "Loop start", icons.loop, () => this.#markLoop(commands), { "data-wide": "2" }),
      speed: select(
        "Speed",
        SPEEDS.map((speed) => [speed, rateText(speed)]),
        1,
        (value) => (player.playbackRate = Number(value)),
        { class: "choice", "data-wide": "2" },
      ),
      mode: select("View", MODES, "textured", (value) => (player.viewMode = value), {
        class: "choice",
        "data-wide": "3",
      }),
      cameras: button("cameras", "Cameras", icons.cameras, commands.toggleCameras, panel),
      stats: button("stats", "Statistics", icons.stats, commands.toggleStats, {
        "aria-pressed": "false",
        "data-wide": "3",
      }),
      settings: button("settings", "Settings", icons.settings, commands.toggleSettings, panel),
      vr: button("vr", "Enter VR", icons.vr, () => commands.toggleImmersive("vr"), { hidden: true }),
      ar: button("ar", "Show in the room", icons.ar, () => commands.toggleImmersive("ar"), { hidden: true }),
      fullscreen: button("fullscreen", "Full screen", icons.fullscreen, commands.toggleFullscreen),
    };
    const { play, back, forward, time, live, ...others } = this.#parts;
    const spring = element("span", { class: "spring" });
    const row = element("div", { class: "row" }, play, back, forward, time, live, spring, ...Object.values(others));
    this.node = element(
      "div",
      { class: "bar", part: "controls", role: "group", "aria-label": "Controls" },
      this.#scrubber.node,
      row,
    );
  }

  get buttons() {
    return this.#parts;
  }
  get scrubber() {
    return this.#scrubber;
  }

  /** One button for a loop: sets its start, then its end, then clears it. */
  #markLoop(commands) {
    const { loopRange, seekable } = this.#player;
    if (!loopRange) commands.markLoop("from");
    else if (seekable.length && loopRange.to >= seekable.end(0) - 1e-6) commands.markLoop("to");
    else commands.clearLoop();
  }

  update() {
    const player = this.#player;
    const { play, back, forward, sound, live, loop, speed, mode, vr, ar, fullscreen } = this.#parts;
    const { paused, ended, loopRange, seekable, duration } = player;
    setIcon(play, !paused ? icons.pause : ended ? icons.replay : icons.play, paused && !ended);
    setLabel(play, !paused ? "Pause" : ended ? "Play again" : "Play");
    back.disabled = !seekable.length;
    forward.disabled = player.readyState < 2;
    this.#now.textContent = clockTime(player.currentTime);
    this.#total.textContent = Number.isFinite(duration) ? ` / ${clockTime(duration)}` : "";
    this.#scrubber.node.hidden = player.live;
    live.hidden = !player.live;
    const behind = player.liveLatency;
    const late = player.paused || behind > LATE;
    live.dataset.late = String(late);
    live.textContent = late && behind > LATE ? `Live \u2212${behind.toFixed(0)} s` : "Live";
    setLabel(live, late ? "Go live" : "Live: at the edge");
    const to = loopRange && seekable.length && loopRange.to >= seekable.end(0) - 1e-6;
    setLabel(loop, !loopRange ? "Loop start" : to ? "Loop end" : "Clear loop");
    loop.setAttribute("aria-pressed", String(loopRange !== null));
    loop.disabled = !seekable.length;
    sound.hidden = !player.hasSound;
    setIcon(sound, player.muted ? icons.silence : icons.sound);
    setLabel(sound, player.muted ? "Sound on" : "Mute");
    speed.value = String(player.playbackRate);
    mode.value = player.viewMode;
    const { immersive, immersiveModes } = player;
    vr.hidden = !immersiveModes.includes("vr");
    ar.hidden = !immersiveModes.includes("ar");
    setLabel(vr, immersive === "vr" ? "Exit VR" : "Enter VR");
    setLabel(ar, immersive === "ar" ? "Leave the room" : "Show in the room");
    fullscreen.hidden = leavesOut(player, "nofullscreen");
    setIcon(fullscreen, player.isFullscreen ? icons.leaveFullscreen : icons.fullscreen);
    setLabel(fullscreen, player.isFullscreen ? "Exit full screen" : "Full screen");
    this.#scrubber.update();
  }
}
