// Whether the browser offers WebXR, and the session of a player. The session's module is loaded only if it does.

export const IMMERSIVE_MODES = ["vr", "ar"];

export class Immersive extends EventTarget {
  #module = null;
  #immersion = null;
  #entering = false;
  /** Those of IMMERSIVE_MODES that the browser offers. */
  modes = [];

  /** Events: "change", of modes or mode. */
  constructor(signal) {
    super();
    const { xr } = navigator;
    if (!xr) return;
    xr.addEventListener("devicechange", () => this.#detect(xr), { signal });
    signal.addEventListener("abort", () => this.exit());
    this.#detect(xr);
  }

  async #detect(xr) {
    const offered = await Promise.all(
      IMMERSIVE_MODES.map((mode) => xr.isSessionSupported(`immersive-${mode}`).catch(() => false)),
    );
    this.modes = IMMERSIVE_MODES.filter((_, i) => offered[i]);
    // A session has to be requested soon after the click.
    if (this.modes.length) this.#module ??= import("./immersion.js");
    this.#changed();
  }

  /** "vr", "ar", or null. */
  get mode() {
    return this.#immersion?.kind.replace("immersive-", "") ?? null;
  }
  get placement() {
    return this.#immersion?.placement ?? null;
  }

  /** parts: as Immersion.begin takes them. */
  async enter(mode, parts) {
    if (!this.modes.includes(mode)) throw new DOMException(`the browser does not offer ${mode}`, "NotSupportedError");
    if (this.#entering || this.#immersion)
      throw new DOMException("there is an immersive session already", "InvalidStateError");
    this.#entering = true;
    const { stage } = parts;
    try {
      const { Immersion } = await this.#module;
      const ended = () => {
        this.#immersion = null;
        stage.immersed = false;
        this.#changed();
      };
      this.#immersion = await Immersion.begin(`immersive-${mode}`, { ...parts, ended });
      stage.immersed = true;
    } finally {
      this.#entering = false;
    }
    this.#changed();
  }
  async exit() {
    await this.#immersion?.end();
  }

  #changed() {
    this.dispatchEvent(new Event("change"));
  }
}
