// The tools of analysis over the picture. The player loads this module when its attribute asks for one of them, or for marks.

import { objectsOf, pick, rayThrough } from "@fvv/analysis";

import { findInHash, putIntoHash } from "../navigation/view_text.js";
import { element, iconButton, select, toggle } from "../ui/widgets.js";
import { figure } from "./figures.js";
import { Follow } from "./follow.js";
import { MARK_KINDS, MarkTool } from "./mark_tool.js";
import { MarkList } from "./mark_list.js";
import { Marks, shapesOfMark } from "./marks.js";
import { documentOf, packMarks, readMarks, unpackMarks } from "./marks_document.js";
import { MeasureList } from "./measure_list.js";
import { MeasureTool, shapesOf } from "./measure_tool.js";
import { KINDS, Measurements } from "./measurements.js";
import { Overlay } from "./overlay.js";
import { Pointing } from "./pointing.js";
import { COLOURS, style } from "./style.js";

/** As in the icons of the player. */
const PATHS = {
  distance: "M4 16.5 16.5 4 20 7.5 7.5 20zM7.5 13l2 2M10.5 10l2 2M13.5 7l2 2",
  height: "M6 4h12M6 20h12M12 5v14M9 8l3-3 3 3M9 16l3 3 3-3",
  speed: "M4 16a8 8 0 1 1 16 0M12 16l4.5-5.5M4 16h2M18 16h2",
  arrow: "M5 19 19 5M11 5h8v8",
  line: "M5 19 19 5",
  ellipse: "M3.5 12a8.5 5.5 0 1 0 17 0a8.5 5.5 0 1 0-17 0",
  freehand: "M4 17c3-9 6-11 7-8s-3 8 0 8 4-7 9-9",
  text: "M6 6h12M12 6v13",
  trail: "M4 18c4 0 3-10 9-10M18.5 8a2 2 0 1 0-4 0 2 2 0 1 0 4 0",
};
const COLOUR_NAMES = ["Yellow", "Blue", "Pink", "Green", "Orange", "Violet"];
/** Milliseconds for a document of marks. */
const FETCH_MS = 20000;
/** Names of the tools, by the word of the attribute. */
const OFFERED = { measure: KINDS, mark: MARK_KINDS };

export class Tools {
  #player;
  #surface;
  #scene;
  #measurements = new Measurements();
  #marks = new Marks();
  #overlay = new Overlay();
  #pointing;
  #measureList;
  #markList;
  #follow;
  #hint = element("div", { class: "hint", role: "status" });
  #bar = element("div", { class: "tool-bar", role: "toolbar", "aria-label": "Tools", hidden: true });
  #options = element("div", { class: "tool-options", hidden: true });
  #centre;
  #speed;
  #colour;
  #on;
  #stays;
  #seconds;
  #text;
  #lists;
  #node;
  #buttons = new Map();
  #names = [];
  #active = null;
  #frame = null;
  #sheet = null;
  #leaving;

  /** host: {player, root, surface, scene, signal}. scene: {shown, size, up, floor, carry}: what is on screen, as Stage.shown; its radius; its
   * vertical; the level of its floor; moves the viewer. */
  constructor({ player, root, surface, scene, signal }) {
    this.#player = player;
    this.#surface = surface;
    this.#scene = scene;
    const leaving = (this.#leaving = new AbortController());
    signal.addEventListener("abort", () => leaving.abort(), { signal: leaving.signal });
    this.#pointing = new Pointing(root, surface, () => this.choose(null), leaving.signal);
    this.#makeOptions();
    const say = (text) => this.#say(text);
    this.#measureList = new MeasureList(player, this.#measurements, (one, value) => this.#figure(one.kind, value));
    this.#markList = new MarkList(player, this.#marks, say, () => player.copyBookmark());
    this.#follow = new Follow(player, scene.carry);
    const parts = [this.#follow.node, this.#markList.node, this.#measureList.node];
    const names = { class: "tool-list", tabIndex: 0, role: "group", "aria-label": "Results" };
    this.#lists = element("div", names, ...parts);
    this.#node = element("div", { class: "tools", part: "tools" }, this.#bar, this.#options, this.#hint, this.#lists);
    root.querySelector(".middle").before(this.#overlay.node, this.#pointing.node);
    root.querySelector(".controls").before(this.#node);
    this.#measurements.addEventListener("change", () => this.#update());
    this.#marks.addEventListener("change", () => {
      this.#update();
      player.dispatchEvent(new Event("markschange"));
    });
    const listen = (type, listener) => player.addEventListener(type, listener, { signal: leaving.signal });
    listen("framechange", () => this.#advance());
    listen("emptied", () => this.#forget());
    listen("keydown", (event) => this.#press(event));
    addEventListener("hashchange", () => this.#readLink(), { signal: leaving.signal });
    this.adopt();
    this.#update();
    this.#readLink();
  }

  #makeOptions() {
    this.#centre = toggle("Centres of objects", true, (on) => this.#pointing.tool && (this.#pointing.tool.centre = on));
    const units = ["m/s", "km/h"].map((unit) => [unit, unit]);
    this.#speed = select("Unit of speed", units, "m/s", () => this.#update());
    const colours = COLOURS.map((colour, i) => [colour, COLOUR_NAMES[i]]);
    this.#colour = select("Colour", colours, COLOURS[0], () => {});
    const places = [
      ["floor", "On the floor"],
      ["surface", "On the surface"],
    ];
    this.#on = select("Where marks are", places, "floor", () => this.#showOptions());
    this.#stays = toggle("Stays with the object", true, () => {});
    const times = [
      ["", "All the time"],
      ["1", "1 s from now"],
      ["3", "3 s from now"],
      ["10", "10 s from now"],
    ];
    this.#seconds = select("When marks are shown", times, "3", () => {});
    this.#text = element("input", {
      type: "text",
      maxLength: 200,
      placeholder: "Text",
      "aria-label": "Text of the mark",
    });
    const rows = [this.#colour, this.#on, this.#seconds, this.#text, this.#stays.row, this.#centre.row, this.#speed];
    this.#options.append(...rows);
  }
  #showOptions() {
    const name = this.#active;
    const isMark = name in MARK_KINDS;
    const isDrawn = isMark && name !== "trail";
    const wanted = [
      [this.#centre.row, name in KINDS && this.#hasObjects],
      [this.#speed, name === "speed"],
      [this.#colour, isMark],
      [this.#on, isDrawn],
      [this.#seconds, isDrawn],
      [this.#stays.row, isDrawn && this.#on.value === "surface" && this.#hasObjects],
      [this.#text, name === "text"],
    ];
    for (const [node, shown] of wanted) node.hidden = !shown;
    this.#options.hidden = !wanted.some(([, shown]) => shown);
  }

  /** Constructed style sheets are valid in one document. */
  adopt() {
    const { shadowRoot, ownerDocument } = this.#player;
    const { defaultView } = ownerDocument;
    if (!defaultView) return;
    this.#sheet = new defaultView.CSSStyleSheet();
    this.#sheet.replaceSync(style);
    shadowRoot.adoptedStyleSheets = [...shadowRoot.adoptedStyleSheets, this.#sheet];
  }

  /** Which tools are offered. */
  set names(names) {
    if (names.join() === this.#names.join()) return;
    this.#names = names;
    const kinds = names.flatMap((name) => Object.entries(OFFERED[name] ?? {}));
    this.#buttons.clear();
    this.#bar.replaceChildren(
      ...kinds.map(([name, { title }]) => {
        const button = iconButton(title, PATHS[name], () => this.choose(this.#active === name ? null : name), {
          part: `button ${name}`,
          "aria-pressed": "false",
        });
        this.#buttons.set(name, button);
        return button;
      }),
    );
    this.#bar.hidden = !kinds.length;
    this.choose(null);
    this.#update();
  }

  /** Begins a tool by its name; null: none. */
  choose(name) {
    this.#active = name;
    for (const [one, button] of this.#buttons) button.setAttribute("aria-pressed", String(one === name));
    this.#hint.textContent = "";
    this.#pointing.tool = name === null ? null : this.#toolOf(name);
    this.#showOptions();
    if (name === "text" && !this.#text.value) this.#text.focus({ preventScroll: true });
    else if (name !== null) this.#surface.focus({ preventScroll: true });
    this.draw();
  }
  #toolOf(name) {
    const parts = { look: (spot) => this.#look(spot), say: (text) => this.#say(text), changed: () => this.draw() };
    if (name in MARK_KINDS) {
      const floor = () => {
        const level = this.#scene.floor();
        return level === null ? null : { up: this.#scene.up(), level };
      };
      const look = () => ({
        colour: this.#colour.value,
        on: this.#on.value,
        stays: this.#stays.input.checked,
        seconds: this.#seconds.value === "" ? null : Number(this.#seconds.value),
        text: this.#text.value.trim(),
      });
      const add = (mark) => {
        this.#marks.add(mark);
        this.#say(`${MARK_KINDS[mark.kind].title} added`);
      };
      return new MarkTool(name, { ...parts, floor, style: look, add });
    }
    const done = (measurement) => this.#announce(measurement);
    const tool = new MeasureTool(name, { ...parts, measurements: this.#measurements, done });
    tool.centre = this.#centre.input.checked;
    return tool;
  }
  /** Undo and redo, as everywhere. */
  #press(event) {
    if (!this.#names.includes("mark") || !(event.ctrlKey || event.metaKey) || event.altKey) return;
    if (event.composedPath()[0] === this.#text) return;
    const key = event.key.toLowerCase();
    if (key === "y" || (key === "z" && event.shiftKey)) this.#marks.redo();
    else if (key === "z") this.#marks.undo();
    else return;
    event.preventDefault();
  }

  get #hasObjects() {
    const shown = this.#scene.shown();
    return shown !== null && objectsOf(shown.frame.configuration) !== null;
  }
  #say(text) {
    this.#hint.textContent = text;
  }
  #look([x, y]) {
    const shown = this.#scene.shown();
    if (!shown) return null;
    const ray = rayThrough(shown.view, x, y);
    return { frame: shown.frame, view: shown.view, ray, picked: pick(shown.frame, ray) };
  }
  #figure(kind, value) {
    const { quantity } = KINDS[kind];
    if (this.#frame?.configuration.scaleKnown === false)
      return figure(value, quantity === "speed" ? "unscaledSpeed" : "unscaled");
    return figure(value, quantity, this.#speed.value);
  }

  /** Whether clicks on the picture are for a tool. */
  get takesClicks() {
    return this.#pointing.tool !== null;
  }
  #announce({ kind, value }) {
    const { title } = KINDS[kind];
    this.#say(value ? `${title} ${this.#figure(kind, value).spoken}` : `${title}: play, and its value is known`);
  }

  #advance() {
    const shown = this.#scene.shown();
    if (!shown || shown.frame === this.#frame) return;
    this.#frame = shown.frame;
    this.#follow.advance(shown.frame);
    this.#measurements.advance(shown.frame);
    this.#update();
  }
  /** Another source has other places and objects; its marks come with their document. */
  #forget() {
    this.#frame = null;
    this.choose(null);
    this.#follow.forget();
    this.#measurements.clear();
  }

  #update() {
    this.#measureList.update();
    this.#markList.update(this.#frame);
    this.#markList.node.hidden = !this.#names.includes("mark");
    this.#follow.update(this.#frame, this.#names.includes("follow"));
    this.#lists.hidden = Array.from(this.#lists.children).every(({ hidden }) => hidden);
    this.draw();
  }

  /** Draws what belongs over the picture on screen. */
  draw() {
    const shown = this.#scene.shown();
    if (!shown) return this.#overlay.clear();
    if (shown.frame !== this.#frame) return this.#advance();
    const up = this.#scene.up();
    const marks = this.#marks.list.flatMap((mark) => shapesOfMark(mark, shown.frame));
    const measured = this.#measurements.list.flatMap((one) =>
      shapesOf(one, one.value ? this.#figure(one.kind, one.value).text : "", up),
    );
    const chosen = this.#pointing.tool?.shapes(shown.frame) ?? [];
    this.#overlay.draw(shown.view, this.#scene.size(), [...marks, ...measured, ...chosen]);
  }

  /** What is measured, for scripts: {kind, names, value, samples}. */
  get measurements() {
    return this.#measurements.list.map(({ kind, anchors, value, samples }) => ({
      kind,
      names: anchors.map(({ name }) => name),
      value,
      samples: samples.map(({ seconds, value: one }) => ({ seconds, value: one ?? null })),
    }));
  }

  get document() {
    return documentOf(this.#marks.list);
  }
  set document(value) {
    this.#marks.set(readMarks(value));
  }
  /** Shows the marks of an address, "" for none; a link has its own. */
  async fetchMarks(url) {
    if (this.#linked !== null) return;
    if (!url) return this.#marks.set([]);
    try {
      const response = await fetch(url, {
        signal: AbortSignal.any([this.#leaving.signal, AbortSignal.timeout(FETCH_MS)]),
      });
      if (!response.ok) throw new Error(`the host returns ${response.status}`);
      const marks = readMarks(await response.json());
      if (!this.#leaving.signal.aborted) this.#marks.set(marks);
    } catch (error) {
      if (this.#leaving.signal.aborted) return;
      console.warn(`<fvv-player>: ${url}: ${error.message}`);
      this.#say(`The marks cannot be shown: ${error.message}`);
    }
  }

  get #linked() {
    return this.#player.bookmarks ? findInHash(location.hash, `${this.#player.id || "fvv"}-marks`) : null;
  }
  async #readLink() {
    const text = this.#linked;
    if (text === null) return;
    try {
      this.#marks.set(await unpackMarks(text));
    } catch (error) {
      this.#say(`The link's marks cannot be shown: ${error.message}`);
    }
  }
  /** Puts the marks into the page's address, under a player's name. */
  async putMarks(name) {
    const { list } = this.#marks;
    if (!list.length) return;
    const hash = putIntoHash(location.hash, `${name}-marks`, await packMarks(list));
    history.replaceState(history.state, "", hash);
  }

  #firstFrame() {
    const { signal } = this.#leaving;
    return new Promise((resolve, reject) => {
      this.#player.addEventListener("framechange", resolve, { once: true, signal });
      const end = () => reject(new DOMException("the tools were closed", "AbortError"));
      signal.addEventListener("abort", end, { once: true });
    });
  }

  /** object: a name or an identifier; null: none is followed. Before the first frame it waits for that; AbortError: the tools were closed. */
  async follow(object) {
    if (object !== null && !this.#scene.shown()) await this.#firstFrame();
    this.#advance();
    const objects = this.#frame && objectsOf(this.#frame.configuration);
    const id = typeof object === "string" ? (objects?.find(object) ?? null) : object;
    if (object !== null && !objects?.list.some((one) => one.id === id))
      throw new RangeError(`the stream names no object ${object}`);
    this.#follow.follow(id);
  }

  close() {
    this.#leaving.abort();
    this.#pointing.tool = null;
    for (const node of [this.#node, this.#overlay.node, this.#pointing.node]) node.remove();
    const { shadowRoot } = this.#player;
    shadowRoot.adoptedStyleSheets = shadowRoot.adoptedStyleSheets.filter((sheet) => sheet !== this.#sheet);
  }
}
