// The panels over the picture: cameras, settings, keys, statistics.

import { COMMANDS, MOVES } from "../navigation/keys.js";
import { cameraColour } from "../renderer/surface.js";
import { MODES, SPEEDS, sceneOf } from "./commands.js";
import { bitrateText, element, iconButton, icons, megabytes, rateText, select, toggle, leavesOut } from "./widgets.js";

/** Containers of panels: one panel is open at a time. Escape closes it, and the focus returns to where it was. */
export class Panels {
  #panels = new Map();
  #changed;
  #back = null;

  /** changed(name, open) */
  constructor(changed) {
    this.#changed = changed;
    this.node = element("div", { class: "panels" });
    this.node.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.closeAll()) event.stopPropagation();
    });
  }

  /** opened(): called before the panel is shown. */
  add(name, title, content, opened = () => {}) {
    const id = `panel-${name}`;
    const heading = element("h2", { id }, title);
    const close = iconButton("Close", icons.close, () => this.toggle(name));
    const header = element("header", {}, heading, close);
    const body = element("div", { class: "body", tabIndex: 0 }, content);
    const node = element(
      "section",
      { class: `panel ${name}`, part: `panel ${name}`, role: "dialog", "aria-labelledby": id, hidden: true },
      header,
      body,
    );
    this.#panels.set(name, { node, opened, body });
    this.node.append(node);
  }

  isOpen(name) {
    return this.#panels.get(name)?.node.hidden === false;
  }
  get anyOpen() {
    return [...this.#panels.values()].some(({ node }) => !node.hidden);
  }

  toggle(name) {
    const open = !this.isOpen(name);
    const from = this.node.getRootNode().activeElement;
    this.closeAll();
    if (!open) return;
    this.#back = from;
    const { node, opened, body } = this.#panels.get(name);
    opened();
    node.hidden = false;
    body.focus({ preventScroll: true });
    this.#changed(name, true);
  }
  /** Returns whether a panel was open. */
  closeAll() {
    let closed = false;
    for (const [name, { node }] of this.#panels) {
      if (node.hidden) continue;
      node.hidden = true;
      closed = true;
      this.#changed(name, false);
    }
    if (closed) this.#back?.focus?.({ preventScroll: true });
    this.#back = null;
    return closed;
  }
}

const hex = (colour) =>
  `#${colour
    .map((x) =>
      Math.round(255 * x)
        .toString(16)
        .padStart(2, "0"),
    )
    .join("")}`;

/** The cameras of the stream: whether their frusta are drawn, which give colours, and views through them. */
export class CamerasPanel {
  #player;
  #list = element("ul", { class: "cameras" });
  #rows = new Map();
  #shown = "";
  #frusta;
  #planes;
  #sheet;
  #all;

  constructor(player) {
    this.#player = player;
    this.#frusta = toggle("Show cameras in the scene", false, (on) => (player.showCameras = on ? "frusta" : "none"));
    this.#planes = toggle("With their pictures", false, (on) => (player.showCameras = on ? "pictures" : "frusta"));
    this.#sheet = toggle(
      "Pictures of all cameras",
      false,
      (on) => (player.showCameras = on ? "sheet" : sceneOf(player)),
    );
    this.#all = element(
      "button",
      { type: "button", class: "text", onclick: () => (player.colourCameras = null) },
      "Use all",
    );
    const free = element(
      "button",
      { type: "button", class: "text", onclick: () => player.resetView({ duration: 0.7 }) },
      "Whole scene",
    );
    this.node = element(
      "div",
      {},
      this.#frusta.row,
      this.#planes.row,
      this.#sheet.row,
      element("div", { class: "actions" }, this.#all, free),
      this.#list,
    );
  }

  #row({ id, name, calibrated }) {
    const title = name || `Camera ${id}`;
    const swatch = element("span", { class: "swatch" });
    swatch.style.setProperty("--swatch", hex(cameraColour(id)));
    const use = toggle("", true, (on) => this.#use(id, on), { "aria-label": `Colours of ${title}` });
    const look = iconButton(
      `Look through ${title}`,
      icons.look,
      () => this.#player.snapToCamera(id, { duration: 0.7 }),
      {
        disabled: !calibrated,
      },
    );
    const select = (on) => () => (this.#player.selectedCamera = on ? id : null);
    const row = element(
      "li",
      {
        onpointerenter: select(true),
        onpointerleave: select(false),
        onfocusin: select(true),
        onfocusout: select(false),
      },
      swatch,
      element("span", { class: "name" }, title),
      look,
      use.row,
    );
    this.#rows.set(id, { look, input: use.input });
    return row;
  }

  #use(id, on) {
    const player = this.#player;
    const used = new Set(player.colourCameras ?? player.cameras.map((camera) => camera.id));
    if (on) used.add(id);
    else used.delete(id);
    player.colourCameras = used.size === player.cameras.length ? null : [...used];
  }

  update() {
    const { cameras, camera, colourCameras, showCameras } = this.#player;
    const state = cameras.map(({ id, name, calibrated }) => [id, name, calibrated].join()).join();
    if (state !== this.#shown) {
      this.#shown = state;
      this.#rows.clear();
      this.#list.replaceChildren(...cameras.map((one) => this.#row(one)));
    }
    const inScene = ["frusta", "pictures"].includes(showCameras);
    this.#frusta.input.checked = inScene;
    this.#planes.input.checked = showCameras === "pictures";
    this.#planes.input.disabled = !inScene;
    this.#sheet.input.checked = showCameras === "sheet";
    this.#all.disabled = colourCameras === null;
    for (const [id, { look, input }] of this.#rows) {
      input.checked = !colourCameras || colourCameras.includes(id);
      look.setAttribute("aria-pressed", String(id === camera));
    }
  }
}

/** Pixels for a pixel of the page. */
const PIXEL_RATIOS = [
  ["auto", "Automatic"],
  ["2", "High"],
  ["1", "Medium"],
  ["0.5", "Low"],
];
const BLENDS = [
  ["", "As the stream says"],
  ["viewer", "Cameras near the viewer"],
  ["paper", "Cameras that the surface faces"],
];
const VISIBLE_BY = [
  ["auto", "Automatic"],
  ["bits", "Stream"],
  ["depth", "Depth maps"],
  ["both", "Both"],
];

/** All settings, including those with a button in a wide bar. */
export class SettingsPanel {
  #player;
  #inputs;
  #modes;
  #environmentRows;
  #copy;
  #download;

  constructor(player, commands) {
    this.#player = player;
    const choose = (label, choices, changed) => {
      const input = select(label, choices, choices[0][0], changed, { class: "choice" });
      return {
        input,
        row: element("div", { class: "field" }, element("span", { "aria-hidden": "true" }, label), input),
      };
    };
    const flip = (label, name) => toggle(label, false, (on) => (player[name] = on));
    this.#inputs = {
      speed: choose(
        "Speed",
        SPEEDS.map((speed) => [speed, rateText(speed)]),
        (value) => (player.playbackRate = Number(value)),
      ),
      pixelRatio: choose("Resolution", PIXEL_RATIOS, (value) => (player.pixelRatio = value)),
      rung: choose("Stream", [["auto", "Automatic"]], (value) => (player.rung = value)),
      visibleBy: choose("Visibility by", VISIBLE_BY, (value) => (player.visibleBy = value)),
      loop: flip("Loop", "loop"),
      blend: choose("Colours by", BLENDS, (value) => (player.blend = value || null)),
      environment: flip("Environment", "environment"),
      shadows: flip("Shadows", "shadows"),
      grid: flip("Ground grid", "grid"),
      fly: toggle("Fly instead of orbit", false, (on) => (player.navigation = on ? "fly" : "orbit")),
      stats: toggle("Statistics", false, commands.toggleStats),
    };
    const i = this.#inputs;
    this.#modes = this.#makeModes();
    const action = (text, click) => element("button", { type: "button", class: "text", onclick: click }, text);
    this.#download = action("Download", () => player.download());
    this.#copy = action("Copy link to this view", () => player.copyBookmark());
    this.#environmentRows = [i.environment.row, i.shadows.row];
    this.node = element(
      "div",
      {},
      this.#modes.node,
      i.speed.row,
      element(
        "div",
        { class: "actions" },
        action("Loop start", () => commands.markLoop("from")),
        action("Loop end", () => commands.markLoop("to")),
        action("Clear loop range", commands.clearLoop),
      ),
      i.loop.row,
      i.pixelRatio.row,
      i.rung.row,
      i.visibleBy.row,
      i.blend.row,
      ...this.#environmentRows,
      i.grid.row,
      i.fly.row,
      i.stats.row,
      element(
        "div",
        { class: "actions" },
        action("Whole scene", commands.goHome),
        this.#copy,
        this.#download,
        action("Keys", commands.toggleHelp),
      ),
    );
  }

  #makeModes() {
    const inputs = MODES.map(([value, text]) => {
      const input = element("input", {
        type: "radio",
        name: "mode",
        value,
        onchange: () => (this.#player.viewMode = value),
      });
      return { input, row: element("label", { class: "chip" }, input, element("span", {}, text)) };
    });
    const node = element(
      "fieldset",
      { class: "chips" },
      element("legend", {}, "View"),
      ...inputs.map(({ row }) => row),
    );
    return { node, inputs };
  }

  /** The rungs of the stream; automatic names the one that is played. */
  #updateRungs({ row, input }) {
    const { rungs, rung, playedRung } = this.#player;
    row.hidden = rungs.length < 2;
    if (row.hidden) return;
    const played = rungs[playedRung];
    const texts = [played ? `Automatic (${rungText(played)})` : "Automatic", ...rungs.map(rungText)];
    const options = texts.map((text, i) => element("option", { value: i ? String(i - 1) : "auto" }, text));
    if (texts.join() !== Array.from(input.options, ({ text }) => text).join()) input.replaceChildren(...options);
    input.value = String(rung === "auto" ? rung : Math.min(rung, rungs.length - 1));
  }

  update() {
    const player = this.#player;
    const { speed, pixelRatio, rung, visibleBy, loop, blend, environment, shadows, grid, fly, stats } = this.#inputs;
    for (const { input } of this.#modes.inputs) input.checked = input.value === player.viewMode;
    speed.input.value = String(player.playbackRate);
    pixelRatio.input.value = String(player.pixelRatio);
    this.#updateRungs(rung);
    visibleBy.input.value = player.visibleBy;
    loop.input.checked = player.loop;
    blend.input.value = player.blend ?? "";
    environment.input.checked = player.environment;
    shadows.input.checked = player.shadows;
    grid.input.checked = player.grid;
    fly.input.checked = player.navigation === "fly";
    stats.input.checked = player.showsStats;
    this.#copy.hidden = !player.bookmarks;
    this.#download.hidden = leavesOut(player, "nodownload") || !player.canDownload;
    for (const row of this.#environmentRows) row.hidden = !player.hasEnvironment;
  }
}

/** "3/4 of the size, 2.1 Mbit/s" */
function rungText({ scale, bitRate, rung }) {
  const size = scale === null ? `Rung ${rung}` : `${Math.round(100 * scale)} %`;
  return bitRate ? `${size}, ${bitrateText(bitRate)}` : size;
}

/** The table of keys. */
export function helpPanel() {
  const rows = [...MOVES, ...COMMANDS].flatMap(({ shown, description }) => [
    element("dt", {}, ...shown.map((key) => element("kbd", {}, key))),
    element("dd", {}, description),
  ]);
  const hints = element(
    "p",
    {},
    element(
      "span",
      { class: "by-mouse" },
      "Drag to rotate, with the right button to pan, scroll to zoom. A click plays and pauses.",
    ),
    element("span", { class: "by-finger" }, "Swipe sideways to rotate; two fingers move and zoom."),
  );
  return element("div", {}, hints, element("dl", { class: "keys" }, ...rows));
}

const ROWS = [
  ["Frames/s", ({ framesPerSecond }) => framesPerSecond.toFixed(1)],
  ["Frame", ({ frame, frameCount }) => (frameCount ? `${frame} of ${frameCount}` : String(frame))],
  ["Decoding", ({ decodeMs }) => `${decodeMs.toFixed(1)} ms`],
  ["Showing", ({ showMs }) => `${showMs.toFixed(1)} ms`],
  ["Buffer", ({ bufferedSeconds }) => `${bufferedSeconds.toFixed(2)} s`],
  ["Bit rate", ({ bitrate }) => bitrateText(bitrate)],
  ["Dropped", ({ framesDropped, framesShown }) => `${framesDropped} of ${framesDropped + framesShown}`],
  ["Memory", ({ memoryBytes }) => megabytes(memoryBytes)],
  ["Pixels", ({ width, height }) => `${width}\u00d7${height}`],
  ["Draw calls", ({ drawCalls }) => String(drawCalls)],
];

/** Statistics of playback and drawing. */
export class StatsOverlay {
  #values = ROWS.map(() => element("dd", {}));

  constructor() {
    const rows = ROWS.flatMap(([name], i) => [element("dt", {}, name), this.#values[i]]);
    this.node = element("dl", { class: "stats", part: "stats", "aria-label": "Statistics", hidden: true }, ...rows);
  }
  update(stats) {
    ROWS.forEach(([, text], i) => (this.#values[i].textContent = text(stats)));
  }
}
