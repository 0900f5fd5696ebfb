// The view follows an object: it stays where it is in the picture, and the viewer moves around it as before.

import { objectsOf } from "@fvv/analysis";
import { subtract } from "@fvv/shading";

import { element } from "../ui/widgets.js";
import { nameOf } from "./anchors.js";

/** Seconds in which the view turns to the object. */
const JOURNEY = 0.5;

export class Follow {
  #player;
  #carry;
  #object = null;
  #last = null;
  #frame = null;
  #shown = null;
  #buttons = new Map();
  #items = element("ul", { class: "objects", "aria-label": "Objects" });
  node = element("div", { hidden: true }, this.#items);

  /** carry(vector): moves viewer and target, with all that they are about to do. */
  constructor(player, carry) {
    this.#player = player;
    this.#carry = carry;
  }
  get object() {
    return this.#object;
  }

  /** id: of an object, null: none. Turns the view to it. */
  follow(id) {
    this.#object = id;
    this.#last = id === null || !this.#frame ? null : this.#centre(this.#frame);
    if (this.#last) {
      const { eye, target } = this.#player.getPose();
      const moved = subtract(this.#last, target);
      const pose = { eye: eye.map((x, k) => x + moved[k]), target: this.#last };
      this.#player.setPose(pose, { duration: JOURNEY }).catch(() => {});
    }
    this.#updateButtons();
  }
  #centre(frame) {
    return objectsOf(frame.configuration)?.centreOf(this.#object, frame.time) ?? null;
  }

  /** frame: the one on screen. */
  advance(frame) {
    this.#frame = frame;
    if (this.#object === null) return;
    const centre = this.#centre(frame);
    if (!centre) return;
    if (this.#last) this.#carry(subtract(centre, this.#last));
    else this.follow(this.#object);
    this.#last = centre;
  }
  forget() {
    this.#object = this.#last = this.#frame = this.#shown = null;
    this.#items.replaceChildren();
  }

  update(frame, isWanted) {
    const objects = frame && objectsOf(frame.configuration);
    this.node.hidden = !isWanted || !objects;
    if (!objects || this.#shown === objects) return;
    this.#shown = objects;
    this.#buttons.clear();
    // Who names some means these: the others are hoops and shadows.
    const named = objects.list.filter(({ name }) => name);
    this.#items.replaceChildren(
      ...(named.length ? named : objects.list).map((object) => {
        const toggle = () => this.follow(this.#object === object.id ? null : object.id);
        const name = nameOf(object);
        const button = element(
          "button",
          { type: "button", class: "text", "aria-pressed": "false", onclick: toggle },
          `Follow ${name}`,
        );
        this.#buttons.set(object.id, button);
        return element("li", {}, button);
      }),
    );
  }
  #updateButtons() {
    for (const [id, button] of this.#buttons) button.setAttribute("aria-pressed", String(id === this.#object));
  }
}
