// Pointing at the picture with a tool: clicks and taps, drawing by dragging, and a cross-hair that keys move.

import { svg } from "./overlay.js";

/** Pixels by which a key moves the cross-hair; with Shift, and while it is held. */
const STEP = 12;
const FINE = 1;
const HELD = 24;
/** Pixels of a pointer up to which it chooses a place, for as long as it likes. */
const CLICK = 5;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Pointing {
  #surface;
  #tool = null;
  #spot = null; // of the cross-hair
  #drawing = null; // {pointer, from, moved}
  #left;
  node = svg(
    "svg",
    { class: "cross-hair", viewBox: "-20 -20 40 40", width: 40, height: 40, "aria-hidden": "true", hidden: "" },
    svg("path", { class: "halo", d: "M-18 0H-5M5 0H18M0-18V-5M0 5V18" }),
    svg("path", { d: "M-18 0H-5M5 0H18M0-18V-5M0 5V18" }),
    svg("circle", { r: 1.5 }),
  );

  /** root: of the player's parts; surface: below its controls; left(): Escape ends the tool. */
  constructor(root, surface, left, signal) {
    this.#surface = surface;
    this.#left = left;
    const listen = (node, type, listener, capture = false) =>
      node.addEventListener(type, (event) => this.#tool && listener(event), { signal, capture });
    listen(surface, "keydown", (event) => this.#press(event));
    listen(surface, "pointermove", (event) => this.#hover(event));
    listen(surface, "pointerleave", () => !this.#drawing && !this.#spot && this.#tool.hover(null));
    // Before the navigation, which listens on the surface itself.
    listen(root, "pointerdown", (event) => this.#begin(event), true);
    listen(root, "pointermove", (event) => this.#drag(event), true);
    listen(root, "pointerup", (event) => this.#end(event), true);
    listen(root, "pointercancel", (event) => this.#end(event), true);
    listen(root, "dblclick", (event) => event.stopPropagation(), true);
  }

  /** {drags, place(spot), hover(spot or null), draw(spot), finish(spot)}; spots: [x, y] in pixels of the picture. null: none. */
  set tool(tool) {
    this.#tool?.hover(null);
    this.#tool = tool;
    this.#drawing = null;
    this.#surface.classList.toggle("pointing", tool !== null);
    this.#surface.classList.toggle("drawing", tool?.drags === true);
    if (!tool) this.#hideCross();
  }
  get tool() {
    return this.#tool;
  }

  #spotOf({ clientX, clientY }) {
    const { left, top } = this.#surface.getBoundingClientRect();
    return [clientX - left, clientY - top];
  }
  #hover(event) {
    if (this.#drawing || event.buttons) return;
    if (event.pointerType === "mouse" && (event.movementX || event.movementY)) this.#hideCross();
    if (!this.#spot) this.#tool.hover(this.#spotOf(event));
  }

  #isOnSurface(event) {
    return event.composedPath().includes(this.#surface);
  }
  #begin(event) {
    if (!this.#isOnSurface(event)) return;
    // A second finger moves the scene.
    if (this.#drawing) {
      if (this.#drawing.moved && this.#tool.drags) this.#tool.cancel();
      this.#drawing = null;
      return;
    }
    if (event.button !== 0 || !event.isPrimary) return;
    this.#drawing = { pointer: event.pointerId, from: this.#spotOf(event), moved: false };
    this.#hideCross();
    if (!this.#tool.drags) return;
    event.stopPropagation();
    this.#surface.setPointerCapture(event.pointerId);
    this.#surface.focus({ preventScroll: true });
  }
  #drag(event) {
    const drawing = this.#drawing;
    if (drawing?.pointer !== event.pointerId) return;
    const spot = this.#spotOf(event);
    const begins = !drawing.moved && Math.hypot(spot[0] - drawing.from[0], spot[1] - drawing.from[1]) > CLICK;
    drawing.moved ||= begins;
    if (!this.#tool.drags) return;
    event.stopPropagation();
    if (begins) this.#tool.place(drawing.from);
    if (drawing.moved) this.#tool.draw(spot);
  }
  #end(event) {
    const drawing = this.#drawing;
    if (drawing?.pointer !== event.pointerId) return;
    this.#drawing = null;
    if (this.#tool.drags) event.stopPropagation();
    // A finger that scrolls the page has chosen nothing.
    if (event.type === "pointercancel") this.#tool.drags && drawing.moved && this.#tool.cancel();
    else if (!drawing.moved) this.#tool.place(this.#spotOf(event));
    else if (this.#tool.drags) this.#tool.finish(this.#spotOf(event));
  }

  #press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = ARROWS[event.key];
    if (event.key === "Escape") this.#left();
    else if (arrow) this.#moveCross(arrow, event);
    else if (event.key === "Enter") {
      if (!this.#spot) this.#moveCross([0, 0], event);
      this.#tool.place([...this.#spot]);
    } else return;
    event.preventDefault();
  }
  #moveCross([dx, dy], { shiftKey, repeat }) {
    const { clientWidth: width, clientHeight: height } = this.#surface;
    const step = shiftKey ? FINE : repeat ? HELD : STEP;
    const [x, y] = this.#spot ?? [width / 2, height / 2];
    this.#spot = [Math.min(width, Math.max(0, x + step * dx)), Math.min(height, Math.max(0, y + step * dy))];
    this.node.removeAttribute("hidden");
    this.node.style.setProperty("--x", `${this.#spot[0]}px`);
    this.node.style.setProperty("--y", `${this.#spot[1]}px`);
    this.#tool.hover(this.#spot);
  }
  #hideCross() {
    this.#spot = null;
    this.node.setAttribute("hidden", "");
  }
}
