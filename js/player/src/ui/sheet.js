// The contact sheet of the cameras' pictures: the buttons over its cells.

import { element } from "./widgets.js";

/** A button over each cell, which shows that camera's picture in the whole view. */
export class SheetButtons {
  #player;
  #shown = "";
  node = element("div", { class: "sheet", role: "group", "aria-label": "Cameras", hidden: true });

  constructor(player) {
    this.#player = player;
  }

  update() {
    const { contactSheet: cells, cameras } = this.#player;
    const shown = JSON.stringify(cells);
    this.node.hidden = !cells.length;
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.node.replaceChildren(...cells.map((cell) => this.#button(cell, cameras)));
  }

  #button({ camera: id, ...cell }, cameras) {
    const camera = cameras.find((one) => one.id === id);
    const name = camera?.name || `Camera ${id}`;
    const button = element(
      "button",
      {
        type: "button",
        "aria-label": `Look through ${name}`,
        disabled: !camera?.calibrated,
        onclick: () => this.#player.snapToCamera(id),
      },
      element("span", { "aria-hidden": "true" }, name),
    );
    for (const [side, value] of Object.entries(cell)) button.style.setProperty(`--${side}`, value);
    return button;
  }
}
