// Everything that can be chosen, also what has a button of its own where there is room for it.

import { QUALITIES } from "../resolution.js";
import { MODES, SPEEDS } from "./commands.js";
import { element, select, toggle } from "./dom.js";
import { rateText } from "./text.js";

const QUALITY_NAMES = { auto: "Automatic", high: "High", medium: "Medium", low: "Low" };
const VISIBLE_BY = [
  ["auto", "As the stream says"],
  ["bits", "Bits of the stream"],
  ["depth", "Depth maps"],
  ["both", "Both"],
];

export class SettingsPanel {
  #player;
  #inputs;
  #modes;
  #surroundings;
  #copy;

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
      quality: choose(
        "Quality",
        QUALITIES.map((name) => [name, QUALITY_NAMES[name]]),
        (value) => (player.quality = value),
      ),
      visibleBy: choose("Visibility by", VISIBLE_BY, (value) => (player.visibleBy = value)),
      loop: flip("Loop", "loop"),
      soft: toggle("Soft transitions", false, (on) => (player.soft = on ? 0.5 : 0)),
      environment: flip("Surroundings", "environment"),
      shadows: flip("Shadows", "shadows"),
      grid: flip("Ground grid", "grid"),
      fly: toggle("Fly instead of orbit", false, (on) => (player.navigation = on ? "fly" : "orbit")),
      stats: toggle("Statistics", false, commands.toggleStats),
    };
    const i = this.#inputs;
    this.#modes = this.#makeModes();
    const action = (text, click) => element("button", { type: "button", class: "text", onclick: click }, text);
    this.#copy = action("Copy link to this view", () => player.copyBookmark());
    this.#surroundings = [i.environment.row, i.shadows.row];
    this.node = element(
      "div",
      {},
      this.#modes.node,
      i.speed.row,
      element(
        "div",
        { class: "actions" },
        action("Loop from here", () => commands.markLoop("from")),
        action("Loop up to here", () => commands.markLoop("to")),
        action("No loop range", commands.clearLoop),
      ),
      i.loop.row,
      i.quality.row,
      i.visibleBy.row,
      i.soft.row,
      ...this.#surroundings,
      i.grid.row,
      i.fly.row,
      i.stats.row,
      element(
        "div",
        { class: "actions" },
        action("Whole scene", commands.goHome),
        this.#copy,
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

  update() {
    const player = this.#player;
    const { speed, quality, visibleBy, loop, soft, environment, shadows, grid, fly, stats } = this.#inputs;
    for (const { input } of this.#modes.inputs) input.checked = input.value === player.viewMode;
    speed.input.value = String(player.playbackRate);
    quality.input.value = player.quality;
    visibleBy.input.value = player.visibleBy;
    loop.input.checked = player.loop;
    soft.input.checked = player.soft > 0;
    environment.input.checked = player.environment;
    shadows.input.checked = player.shadows;
    grid.input.checked = player.grid;
    fly.input.checked = player.navigation === "fly";
    stats.input.checked = player.showsStats;
    this.#copy.hidden = !player.bookmarks;
    for (const row of this.#surroundings) row.hidden = !player.hasEnvironment;
  }
}
