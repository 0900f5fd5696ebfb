// The tools of analysis over the picture. The player loads this module when its attribute asks for one of them.

import { objectsOf, pick, rayThrough } from "@fvv/analysis";

import { element, iconButton, icons, select, toggle } from "../ui/widgets.js";
import { figure } from "./figures.js";
import { MeasureList } from "./measure_list.js";
import { MeasureTool, shapesOf } from "./measure_tool.js";
import { KINDS, Measurements } from "./measurements.js";
import { Overlay } from "./overlay.js";
import { Pointing } from "./pointing.js";
import { style } from "./style.js";

/** As in the icons of the player. */
const PATHS = {
  distance: "M4 16.5 16.5 4 20 7.5 7.5 20zM7.5 13l2 2M10.5 10l2 2M13.5 7l2 2",
  height: "M6 4h12M6 20h12M12 5v14M9 8l3-3 3 3M9 16l3 3 3-3",
  speed: "M4 16a8 8 0 1 1 16 0M12 16l4.5-5.5M4 16h2M18 16h2",
};

export class Tools {
  #player;
  #surface;
  #scene;
  #measurements = new Measurements();
  #overlay = new Overlay();
  #pointing;
  #list;
  #hint = element("div", { class: "hint", role: "status" });
  #bar = element("div", { class: "tool-bar", role: "toolbar", "aria-label": "Tools" });
  #options = element("div", { class: "tool-options", hidden: true });
  #centre;
  #speed;
  #lists;
  #node;
  #buttons = new Map();
  #active = null;
  #frame = null;
  #sheet = null;
  #leaving;

  /** host: {player, root, surface, scene, signal}. scene: {shown, size, up}: what is on screen, as Stage.shown; its radius; its vertical. */
  constructor({ player, root, surface, scene, signal }) {
    this.#player = player;
    this.#surface = surface;
    this.#scene = scene;
    const leaving = (this.#leaving = new AbortController());
    signal.addEventListener("abort", () => leaving.abort(), { signal: leaving.signal });
    this.#pointing = new Pointing(root, surface, () => this.choose(null), leaving.signal);
    this.#list = new MeasureList(player, this.#measurements, (one, value) => this.#figure(one.kind, value));
    this.#centre = toggle("Centres of objects", true, (on) => this.#pointing.tool && (this.#pointing.tool.centre = on));
    const units = ["m/s", "km/h"].map((unit) => [unit, unit]);
    this.#speed = select("Unit of speed", units, "m/s", () => this.#update());
    this.#options.append(this.#centre.row, this.#speed);
    const lists = element(
      "div",
      { class: "tool-list", tabIndex: 0, role: "group", "aria-label": "Results" },
      this.#list.node,
    );
    this.#node = element("div", { class: "tools", part: "tools" }, this.#bar, this.#options, this.#hint, lists);
    this.#lists = lists;
    root.querySelector(".middle").before(this.#overlay.node, this.#pointing.node);
    root.querySelector(".controls").before(this.#node);
    this.#measurements.addEventListener("change", () => this.#update());
    const listen = (type, listener) => player.addEventListener(type, listener, { signal: leaving.signal });
    listen("framechange", () => this.#advance());
    listen("emptied", () => this.#forget());
    this.adopt();
    this.#update();
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
    const wanted = names.includes("measure") ? Object.entries(KINDS).map(([name, { title }]) => [name, title]) : [];
    this.#buttons.clear();
    this.#bar.replaceChildren(
      ...wanted.map(([name, title]) => {
        const button = iconButton(title, PATHS[name], () => this.choose(this.#active === name ? null : name), {
          part: `button ${name}`,
          "aria-pressed": "false",
        });
        this.#buttons.set(name, button);
        return button;
      }),
    );
    this.choose(null);
  }

  /** Begins a tool by its name; null: none. */
  choose(name) {
    this.#active = name;
    for (const [one, button] of this.#buttons) button.setAttribute("aria-pressed", String(one === name));
    this.#options.hidden = name === null;
    this.#hint.textContent = "";
    const parts = {
      look: (spot) => this.#look(spot),
      measurements: this.#measurements,
      say: (text) => this.#say(text),
      changed: () => this.draw(),
      done: (measurement) => this.#announce(measurement),
    };
    const tool = name === null ? null : new MeasureTool(name, parts);
    if (tool) tool.centre = this.#centre.input.checked;
    this.#pointing.tool = tool;
    this.#centre.row.hidden = !this.#hasObjects;
    this.#speed.hidden = name !== "speed";
    this.#options.hidden ||= this.#centre.row.hidden && this.#speed.hidden;
    if (tool) this.#surface.focus({ preventScroll: true });
    this.draw();
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
    return { frame: shown.frame, ray, picked: pick(shown.frame, ray) };
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
    this.#measurements.advance(shown.frame);
  }
  #forget() {
    this.#frame = null;
    this.choose(null);
    this.#measurements.clear();
  }

  #update() {
    this.#list.update();
    this.#lists.hidden = !this.#measurements.list.length;
    this.draw();
  }

  /** Draws what belongs over the picture on screen. */
  draw() {
    const shown = this.#scene.shown();
    if (!shown) return this.#overlay.clear();
    if (shown.frame !== this.#frame) this.#advance();
    const up = this.#scene.up();
    const shapes = this.#measurements.list.flatMap((one) =>
      shapesOf(one, one.value ? this.#figure(one.kind, one.value).text : "", up),
    );
    const chosen = this.#pointing.tool?.shapes(shown.frame) ?? [];
    this.#overlay.draw(shown.view, this.#scene.size(), [...shapes, ...chosen]);
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

  close() {
    this.#leaving.abort();
    this.#pointing.tool = null;
    for (const node of [this.#node, this.#overlay.node, this.#pointing.node]) node.remove();
    const { shadowRoot } = this.#player;
    shadowRoot.adoptedStyleSheets = shadowRoot.adoptedStyleSheets.filter((sheet) => sheet !== this.#sheet);
  }
}
