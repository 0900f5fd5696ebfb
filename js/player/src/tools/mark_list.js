// The list of marks beside the picture, and what is done with all of them: undo, save, open, link.

import { clockTime, element, iconButton, icons } from "../ui/widgets.js";
import { describe } from "./marks.js";
import { documentOf, readMarks } from "./marks_document.js";
import { saveFile } from "./measure_list.js";

export class MarkList {
  #player;
  #marks;
  #say;
  #undo;
  #redo;
  #save;
  #link;
  #items = element("ul", { "aria-label": "Marks" });
  #shown = null;
  node;

  /** link(): copies an address with the marks. */
  constructor(player, marks, say, link) {
    this.#player = player;
    this.#marks = marks;
    this.#say = say;
    const button = (text, click) => element("button", { type: "button", class: "text", onclick: click }, text);
    this.#undo = button("Undo", () => marks.undo());
    this.#redo = button("Redo", () => marks.redo());
    this.#save = button("Save", () =>
      saveFile("marks.json", "application/json", JSON.stringify(documentOf(marks.list), null, 1)),
    );
    this.#link = button("Link", link);
    const file = element("input", {
      type: "file",
      accept: ".json,application/json",
      "aria-label": "Open marks",
      hidden: true,
    });
    file.addEventListener("change", () => this.#open(file.files[0]).finally(() => (file.value = "")));
    const open = button("Open", () => file.click());
    const actions = element(
      "div",
      { class: "line-of actions" },
      this.#undo,
      this.#redo,
      this.#save,
      open,
      this.#link,
      file,
    );
    this.node = element("div", { hidden: true }, actions, this.#items);
  }

  async #open(file) {
    try {
      if (file) this.#marks.set(readMarks(JSON.parse(await file.text())));
    } catch ({ message }) {
      this.#say(`This file has no marks: ${message}`);
    }
  }

  update(frame) {
    this.#undo.disabled = !this.#marks.canUndo;
    this.#redo.disabled = !this.#marks.canRedo;
    const { list } = this.#marks;
    this.#save.disabled = !list.length;
    this.#link.hidden = !this.#player.bookmarks;
    if (this.#shown === list) return;
    this.#shown = list;
    this.#items.replaceChildren(...list.map((mark) => this.#row(mark, frame)));
  }
  #row(mark, frame) {
    const text = describe(mark, frame, clockTime);
    const key = element("span", { class: "key" });
    if (mark.colour) key.style.setProperty("background", mark.colour);
    const seek = () => this.#seek(mark, frame);
    const name = element(
      "button",
      { type: "button", class: "name", onclick: seek, disabled: mark.from === undefined },
      key,
      text,
    );
    const remove = iconButton(`Remove ${text}`, icons.close, () => this.#marks.remove(mark));
    return element("li", {}, element("div", { class: "line-of" }, name, remove));
  }
  #seek({ from }, frame) {
    const { numerator, denominator } = frame.configuration.timeBase;
    this.#player.currentTime = (from * numerator) / denominator;
  }
}
