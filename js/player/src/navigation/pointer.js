// Mouse, pen and touch on the picture. One finger or the left button rotates, two fingers or the right button pan, and pinch
// or wheel zoom. When flying, rotation is around the eye. If the style allows it, one finger scrolls the page in one direction:
// the browser then cancels its pointer.

/** Radians per height of the picture. */
const TURN = Math.PI;
const LOOK = Math.PI / 2;
const WHEEL = 0.0015;
const LINE = 16;
/** Limits of a click in pixels and milliseconds. */
const CLICK_PIXELS = 5;
const CLICK_MS = 350;

const middle = (points) => {
  const n = points.length;
  return [points.reduce((sum, { x }) => sum + x, 0) / n, points.reduce((sum, { y }) => sum + y, 0) / n];
};
const spread = ([a, b]) => Math.hypot(a.x - b.x, a.y - b.y);

export class PointerControls {
  #surface;
  #navigator;
  #points = new Map();
  #button = 0;
  #pressed = null;
  flying = false;

  /** clicked(event): pressed and released without movement. */
  constructor(surface, navigator, clicked, signal) {
    this.#surface = surface;
    this.#navigator = navigator;
    const listen = (type, listener, options = {}) => surface.addEventListener(type, listener, { ...options, signal });
    listen("pointerdown", (event) => this.#press(event));
    listen("pointermove", (event) => this.#move(event));
    listen("pointerup", (event) => this.#release(event, clicked));
    listen("pointercancel", (event) => this.#release(event));
    // Two fingers never scroll the page.
    listen("touchstart", (event) => event.touches.length > 1 && event.cancelable && event.preventDefault(), {
      passive: false,
    });
    listen("wheel", (event) => this.#wheel(event), { passive: false });
    listen("contextmenu", (event) => event.preventDefault());
  }

  #press(event) {
    this.#surface.setPointerCapture(event.pointerId);
    this.#points.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.#button = event.shiftKey || event.ctrlKey || event.metaKey ? 2 : event.button;
    const { clientX: x, clientY: y, timeStamp } = event;
    this.#pressed = this.#points.size === 1 ? { x, y, timeStamp } : null;
  }

  #move(event) {
    const point = this.#points.get(event.pointerId);
    if (!point) return;
    const { height } = this.#surface.getBoundingClientRect();
    const before = [...this.#points.values()].map(({ x, y }) => ({ x, y }));
    Object.assign(point, { x: event.clientX, y: event.clientY });
    const after = [...this.#points.values()];
    const [from, to] = [middle(before), middle(after)];
    const [dx, dy] = [(to[0] - from[0]) / height, (to[1] - from[1]) / height];
    const pressed = this.#pressed;
    if (pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > CLICK_PIXELS)
      this.#pressed = null;
    if (after.length >= 2) {
      this.#navigator.panBy(dx, dy);
      const [was, is] = [spread(before), spread(after)];
      if (was > 0 && is > 0) this.#navigator.dollyBy(Math.log(was / is));
    } else if (this.#button !== 0) this.#navigator.panBy(dx, dy);
    else if (this.flying || event.altKey) this.#navigator.lookBy(-LOOK * dx, LOOK * dy);
    else this.#navigator.orbitBy(-TURN * dx, -TURN * dy);
  }

  #release(event, clicked) {
    this.#points.delete(event.pointerId);
    const pressed = this.#pressed;
    this.#pressed = null;
    if (pressed && event.button === 0 && event.timeStamp - pressed.timeStamp < CLICK_MS) clicked?.(event);
  }

  #wheel(event) {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? LINE : event.deltaMode === 2 ? 20 * LINE : 1);
    // Trackpads send small values for a pinch.
    const amount = Math.max(-1, Math.min(1, WHEEL * pixels * (event.ctrlKey ? 6 : 1)));
    if (this.flying) this.#navigator.moveBy(0, 0, -amount * this.#navigator.extent.radius);
    else this.#navigator.dollyBy(amount);
  }
}
