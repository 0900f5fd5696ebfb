// The clips of components. A component that suspends keeps no state, so that its clip is kept here, by its source; one that no
// component uses any more, or ever used, is disposed of.

/** Milliseconds until a clip without users is disposed of: a component may be mounted again at once, as in StrictMode. */
const UNUSED_MS = 500;
/** The same of a clip that was loaded, and whose component has not been mounted yet. */
const UNMOUNTED_MS = 30000;

/** The same of one that could not be loaded: a component that is mounted later tries again. */
const FAILED_MS = 2000;

class SharedClip {
  #users = new Map(); // user -> the object that it shows
  #loaded = null;
  #timer = null;
  #isOver = false;
  #forget;
  clip; // promise

  constructor(load, forget) {
    this.#forget = forget;
    this.clip = load().then(
      (clip) => {
        this.#loaded = clip;
        if (this.#isOver) clip.dispose();
        else if (!this.#users.size) this.#expire(UNMOUNTED_MS);
        return clip;
      },
      (error) => {
        this.#timer = setTimeout(forget, FAILED_MS);
        throw error;
      },
    );
    this.clip.catch(() => {});
  }

  #expire(milliseconds) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.#isOver = true;
      this.#forget();
      this.#loaded?.dispose();
    }, milliseconds);
  }

  /** The object for a user: the clip itself for the first one, then instances. */
  join(user) {
    clearTimeout(this.#timer);
    const isFree = ![...this.#users.values()].includes(this.#loaded);
    const object = isFree ? this.#loaded : this.#loaded.instance();
    this.#users.set(user, object);
    return object;
  }
  leave(user) {
    const object = this.#users.get(user);
    this.#users.delete(user);
    if (object && object !== this.#loaded) object.dispose();
    if (!this.#users.size) this.#expire(UNUSED_MS);
  }
}

export class SharedClips {
  #renderers = new WeakMap(); // renderer -> Map from key to SharedClip
  #sources = new WeakMap(); // of sources that are objects: their numbers
  #count = 0;

  #numberOf(source) {
    if (typeof source === "string") return source;
    if (!this.#sources.has(source)) this.#sources.set(source, ++this.#count);
    return this.#sources.get(source);
  }

  /** The clip of a source; components with the same id share it. options: those of the first one count. */
  get(renderer, src, id = "", options = {}) {
    if (!this.#renderers.has(renderer)) this.#renderers.set(renderer, new Map());
    const clips = this.#renderers.get(renderer);
    const key = `${id} ${this.#numberOf(src)}`;
    if (!clips.has(key))
      clips.set(
        key,
        new SharedClip(
          () => load(renderer, src, options),
          () => clips.delete(key),
        ),
      );
    return clips.get(key);
  }
}

/** Only what the renderer needs is loaded. */
async function load(renderer, src, options) {
  const { FvvClip } = renderer.isWebGPURenderer ? await import("../webgpu.js") : await import("../index.js");
  const clip = new FvvClip({ ...options, src, renderer });
  try {
    return await clip.ready;
  } catch (error) {
    clip.dispose();
    throw error;
  }
}
