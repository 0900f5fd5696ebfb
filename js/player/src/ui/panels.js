// Panels over the picture: one is open at a time, apart from the statistics. Escape closes them, and the focus goes back to
// where it came from.

import { element, iconButton } from "./dom.js";
import { icons } from "./icons.js";

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

  /** opened(): before it is shown. */
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
  /** Whether there was one. */
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
