// A WebXR session: draws the scene for both eyes of a headset, or over the camera of a phone, and obeys its controllers.
// Loaded when the browser offers such sessions.

import { subtract } from "@fvv/shading";

import { Placement } from "./placement.js";

/** Radians of one turn: smooth turns of all surroundings make people sick. */
const TURN = Math.PI / 6;
/** Deflections of a stick that count as a turn, and that end it. */
const FLICK = 0.7;
const RELEASE = 0.35;
const DEAD = 0.2;
/** Natural logarithm of the scale, and frames of the stream, per second of full deflection. */
const SCALING = 1.2;
const SCRUBBING = 25;
/** Radians for a finger that crosses the screen. */
const SWIPE = Math.PI;

const SPACES = ["local-floor", "local"];

export class Immersion {
  #session;
  #space;
  #floorKnown;
  #layer;
  #stage;
  #player;
  #placement;
  #placed = false;
  #last = null;
  #held = new Map(); // input source -> place of its grip, while it is squeezed
  #swiped = new Map(); // input source -> place of the finger, while it touches
  #flicked = new Set(); // input sources whose stick has turned the scene
  #scrubbed = 0; // frames that were not made yet

  /** kind: "immersive-vr" or "immersive-ar". overlay: the element that is shown over the scene on screens. */
  static async begin(kind, { stage, player, overlay, ended }) {
    const session = await navigator.xr.requestSession(kind, {
      optionalFeatures: ["local-floor", "dom-overlay"],
      domOverlay: { root: overlay },
    });
    try {
      session.addEventListener("end", ended, { once: true });
      const layer = await stage.renderer.layerFor(session);
      session.updateRenderState({ baseLayer: layer });
      for (const type of SPACES) {
        const space = await session.requestReferenceSpace(type).catch(() => null);
        if (space) return new Immersion({ kind, session, layer, space, floorKnown: type === SPACES[0], stage, player });
      }
      throw new Error("the session has no reference space");
    } catch (error) {
      await session.end().catch(() => {});
      throw error;
    }
  }

  constructor({ kind, session, layer, space, floorKnown, stage, player }) {
    this.kind = kind;
    this.#session = session;
    this.#layer = layer;
    this.#space = space;
    this.#floorKnown = floorKnown;
    this.#stage = stage;
    this.#player = player;
    this.#placement = new Placement(stage.place);
    session.addEventListener("select", ({ inputSource }) => {
      // On a screen, a finger turns the scene.
      if (inputSource.targetRayMode === "screen") return;
      if (player.paused) player.play();
      else player.pause();
    });
    session.addEventListener("inputsourceschange", ({ removed }) => {
      for (const source of removed) for (const known of [this.#held, this.#swiped, this.#flicked]) known.delete(source);
    });
    session.requestAnimationFrame((now, frame) => this.#draw(now, frame));
  }

  /** How the scene is placed in the room. */
  get placement() {
    return this.#placement;
  }
  end() {
    return this.#session.end();
  }

  #draw(now, frame) {
    this.#session.requestAnimationFrame((then, next) => this.#draw(then, next));
    const seconds = this.#last === null ? 0 : Math.min(0.1, (now - this.#last) / 1000);
    this.#last = now;
    const viewer = frame.getViewerPose(this.#space);
    if (!viewer) return;
    if (!this.#placed) this.#placement.face(viewer.transform.matrix, this.#floorKnown);
    this.#placed = true;
    this.#obey(frame, seconds);
    const views = viewer.views.map(({ transform, projectionMatrix }, i) =>
      this.#placement.view(transform.matrix, projectionMatrix, this.#layer.getViewport(viewer.views[i])),
    );
    this.#stage.drawEyes(views, this.#layer.framebuffer, this.kind === "immersive-ar");
  }

  #obey(frame, seconds) {
    const sources = [...this.#session.inputSources];
    for (const source of sources)
      if (source.targetRayMode === "screen") this.#swipe(source);
      else if (source.gamepad) this.#steer(source, seconds);
    this.#grip(sources, frame);
  }

  /** The right stick turns and scales the scene; the left one scrubs and scales. */
  #steer(source, seconds) {
    const [x = 0, y = 0] = source.gamepad.axes.slice(-2);
    if (Math.abs(y) > DEAD) this.#placement.scaleBy(Math.exp(-SCALING * y * seconds));
    if (source.handedness === "left") return this.#scrub(x, seconds);
    if (Math.abs(x) < RELEASE) this.#flicked.delete(source);
    if (Math.abs(x) < FLICK || this.#flicked.has(source)) return;
    this.#flicked.add(source);
    this.#placement.turnBy(Math.sign(x) * TURN);
  }
  #scrub(x, seconds) {
    if (Math.abs(x) < DEAD) {
      this.#scrubbed = 0;
      return;
    }
    this.#scrubbed += SCRUBBING * x * seconds;
    const whole = Math.trunc(this.#scrubbed);
    // A step that is not finished yet would be replaced by the next one.
    if (!whole || this.#player.seeking) return;
    this.#scrubbed -= whole;
    this.#player.step(whole);
  }

  #swipe(source) {
    const [x] = source.gamepad?.axes ?? [];
    if (x === undefined) return;
    const former = this.#swiped.get(source);
    if (former !== undefined) this.#placement.turnBy((SWIPE / 2) * (x - former));
    this.#swiped.set(source, x);
  }

  /** One squeezed controller moves the scene, two also turn and scale it. */
  #grip(sources, frame) {
    const now = new Map();
    for (const source of sources) {
      if (!source.gamepad?.buttons[1]?.pressed || !source.gripSpace) continue;
      const place = frame.getPose(source.gripSpace, this.#space)?.transform.position;
      if (place) now.set(source, [place.x, place.y, place.z]);
    }
    const both = [...now.keys()].filter((source) => this.#held.has(source));
    const [before, after] = [this.#held, now].map((places) => both.map((source) => places.get(source)));
    if (both.length === 2) this.#placement.hold(before, after);
    else if (both.length === 1) this.#placement.moveBy(subtract(after[0], before[0]));
    this.#held = now;
  }
}
