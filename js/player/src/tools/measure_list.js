// The list of measurements beside the picture: values, graphs, and what can be done with each.

import { element, iconButton, icons } from "../ui/widgets.js";
import { Graph } from "./graph.js";
import { csvOf, KINDS } from "./measurements.js";

/** Offers a text as a file. */
export function saveFile(name, type, text) {
  const href = URL.createObjectURL(new Blob([text], { type }));
  element("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 60000);
}

export class MeasureList {
  #measurements;
  #player;
  #show;
  #rows = new Map();
  #items = element("ul", { class: "measurements", "aria-label": "Measurements" });
  node = element("div", { hidden: true }, this.#items);

  /** show(measurement, value): {text, spoken} */
  constructor(player, measurements, show) {
    this.#player = player;
    this.#measurements = measurements;
    this.#show = show;
  }

  update() {
    const { list } = this.#measurements;
    this.node.hidden = !list.length;
    const ids = new Set(list.map(({ id }) => id));
    for (const [id, row] of this.#rows)
      if (!ids.has(id)) {
        row.node.remove();
        this.#rows.delete(id);
      }
    for (const measurement of list) {
      if (!this.#rows.has(measurement.id)) this.#add(measurement);
      this.#updateRow(this.#rows.get(measurement.id), measurement);
    }
  }

  #titleOf({ kind, anchors }) {
    return `${KINDS[kind].title}: ${anchors.map(({ name }) => name).join(" to ")}`;
  }
  #add(measurement) {
    const title = this.#titleOf(measurement);
    const value = element("output", { class: "value" });
    const graph = new Graph((seconds) => (this.#player.currentTime = seconds));
    const save = element(
      "button",
      {
        type: "button",
        class: "text",
        onclick: () => saveFile(`${measurement.kind}.csv`, "text/csv", csvOf(measurement)),
        "aria-label": `${title}, save as CSV`,
      },
      "CSV",
    );
    const remove = iconButton(`Remove ${title}`, icons.close, () => this.#measurements.remove(measurement.id));
    const name = element("span", { class: "name" }, element("span", { class: `key k${measurement.id % 6}` }), title);
    const node = element("li", {}, element("div", { class: "line-of" }, name, save, remove), value, graph.node);
    this.#rows.set(measurement.id, { node, value, graph });
    this.#items.append(node);
  }
  #updateRow({ value, graph }, measurement) {
    const text = measurement.value ? this.#show(measurement, measurement.value).text : "not known in this frame";
    if (value.textContent !== text) value.textContent = text;
    const show = (one) => this.#show(measurement, one).text;
    graph.update(this.#titleOf(measurement), measurement.samples, show, this.#player.currentTime);
  }
}
