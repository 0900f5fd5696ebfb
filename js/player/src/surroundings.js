// The page around the element: its document and window, which change when the element is moved into another one, such as a
// document picture-in-picture window; whether the element can be seen there; what the user prefers.

export class Surroundings extends EventTarget {
  #element;
  #document = null;
  #entered = null; // AbortController of what listens in the current document
  #intersects = true; // until the browser reports it
  calm = false;

  /**
   * Events: "visible" (it may have changed), "resize", "density" (device pixels for a CSS pixel), "colours", "calm",
   * "fullscreen".
   */
  constructor(element) {
    super();
    this.#element = element;
  }

  /** The window of the element. */
  get view() {
    return this.#element.ownerDocument.defaultView ?? globalThis;
  }

  /** Whether the user may see the element: in a document, not hidden by a tab, scrolled into view, and displayed. */
  get visible() {
    return this.#element.isConnected && !this.#element.ownerDocument.hidden && this.#intersects;
  }

  /** Begins to listen. Returns false if it has listened in this document already. */
  enter() {
    if (this.#document === this.#element.ownerDocument) return false;
    this.leave();
    this.#document = this.#element.ownerDocument;
    this.#entered = new AbortController();
    const { signal } = this.#entered;
    const { view } = this;
    const announce = (type) => this.dispatchEvent(new Event(type));
    this.#document.addEventListener("visibilitychange", () => announce("visible"), { signal });
    this.#document.addEventListener("fullscreenchange", () => announce("fullscreen"), { signal });
    const dark = view.matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => announce("colours"), { signal });
    const calm = view.matchMedia("(prefers-reduced-motion: reduce)");
    const readCalm = () => {
      this.calm = calm.matches;
      announce("calm");
    };
    calm.addEventListener("change", readCalm, { signal });
    readCalm();
    this.#watchDensity(signal);
    this.#observe(view, signal, announce);
    return true;
  }

  /** A query holds for one density: after a change it is another one. */
  #watchDensity(signal) {
    const { view } = this;
    const query = view.matchMedia(`(resolution: ${view.devicePixelRatio}dppx)`);
    const changed = () => {
      this.#watchDensity(signal);
      this.dispatchEvent(new Event("density"));
    };
    query.addEventListener("change", changed, { signal, once: true });
  }

  /** Observers belong to a window: they are served when its document is drawn. */
  #observe(view, signal, announce) {
    const sizes = new view.ResizeObserver(() => announce("resize"));
    const places = new view.IntersectionObserver((entries) => {
      this.#intersects = entries.at(-1).isIntersecting;
      announce("visible");
    });
    for (const observer of [sizes, places]) {
      observer.observe(this.#element);
      signal.addEventListener("abort", () => observer.disconnect());
    }
  }

  leave() {
    this.#entered?.abort();
    this.#entered = this.#document = null;
    this.#intersects = true;
  }
}
