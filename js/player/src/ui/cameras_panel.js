// The cameras of the stream: whether they are drawn, which of them may give colours, and looking through one.

import { cameraColour } from "../renderer/camera_colour.js";
import { element, iconButton, toggle } from "./dom.js";
import { icons } from "./icons.js";

const hex = (colour) =>
  `#${colour
    .map((x) =>
      Math.round(255 * x)
        .toString(16)
        .padStart(2, "0"),
    )
    .join("")}`;

export class CamerasPanel {
  #player;
  #list = element("ul", { class: "cameras" });
  #rows = new Map();
  #shown = "";
  #frusta;
  #planes;
  #all;

  constructor(player) {
    this.#player = player;
    this.#frusta = toggle("Show cameras in the scene", false, (on) => (player.showCameras = on ? "frusta" : "none"));
    this.#planes = toggle("With their pictures", false, (on) => (player.showCameras = on ? "pictures" : "frusta"));
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
    this.#frusta.input.checked = showCameras !== "none";
    this.#planes.input.checked = showCameras === "pictures";
    this.#planes.input.disabled = showCameras === "none";
    this.#all.disabled = colourCameras === null;
    for (const [id, { look, input }] of this.#rows) {
      input.checked = !colourCameras || colourCameras.includes(id);
      look.setAttribute("aria-pressed", String(id === camera));
    }
  }
}
