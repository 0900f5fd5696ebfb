// The tracks of video that a viewpoint needs, of streams that have several. They are chosen for each group, for where the viewer
// may be when it ends; a viewer who has jumped gets the frame on screen again, with the cameras of the new place.

import { camerasFor } from "@fvv/decoder";

/** A frame whose cameras give less of the picture is requested again. */
export const LEAST = 0.8;
/** Seconds of movement that tell the speed. */
const WINDOW = 1;
/** Seconds between a choice and the first frame with it, the group aside: the queue, and a request. */
const LEAD = 0.4;
/** Milliseconds between choices, of which the last one before a group counts. */
const INTERVAL = 250;
/** Parts of the viewer's distance: a longer step is a jump, and a shorter one changes nothing. */
const JUMP = 0.25;
const STILL = 0.03;
/** Milliseconds that a frame with other tracks is awaited before the choice is made again. */
const PATIENCE = 3000;

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

/** Tracks of a rung that show cameras. */
function tracksOf({ rungs }, { videos }, rung) {
  const tiled = videos.filter(({ shows }) => shows === "tiles").map(({ track }) => track);
  const all = rungs[rung ?? 0]?.tracks ?? tiled;
  return tiled.filter((track) => all.includes(track));
}

/** The part of a picture from a viewpoint that the cameras of a frame give; 1 if nothing gives any. */
export function coverage({ cameras, tracks, configuration }, { eye, target }) {
  if (!tracks) return 1;
  const { videos, texturing } = configuration;
  const shown = videos
    .filter(({ track }) => tracks.includes(track))
    .flatMap(({ tiles }) => tiles.map(({ camera }) => camera));
  const needed = camerasFor(cameras, { eye, target, texturing, share: 1 });
  const found = needed.filter(({ camera }) => shown.includes(camera)).reduce((sum, { share }) => sum + share, 0);
  return needed.length ? found : 1;
}

export class ViewpointTracks {
  #decoder;
  #steps = []; // {now, length} of the last second
  #last = null; // {now, eye}
  #frame = null; // on screen: {cameras, tracks, rung, configuration, group}
  #checked = null; // {eye, frame} that coverage was found for
  #chosen = { group: null, now: -Infinity }; // sequence of the group on screen when the tracks were chosen
  #awaited = -Infinity; // when a frame with other tracks was requested
  #isFree = true;

  constructor(decoder) {
    this.#decoder = decoder;
  }

  /** Metres per second, jumps aside. now: milliseconds. */
  speed(now) {
    if (!this.#steps.length) return 0;
    const seconds = Math.min(WINDOW, Math.max(WINDOW / 4, (now - this.#steps[0].now) / 1000));
    return this.#steps.reduce((sum, { length }) => sum + length, 0) / seconds;
  }
  #move({ eye, target }, now) {
    const length = this.#last ? distance(eye, this.#last.eye) : 0;
    if (length > 0 && length < JUMP * distance(eye, target)) this.#steps.push({ now, length });
    while (this.#steps.length && now - this.#steps[0].now > 1000 * WINDOW) this.#steps.shift();
    this.#last = { now, eye };
  }

  /**
   * frame: on screen; free: whether a viewpoint alone decides which pictures are needed. Resolves to whether the frame has to be
   * requested again, because it lacks cameras.
   */
  async follow(frame, { eye, target }, now, free = true) {
    this.#move({ eye, target }, now);
    this.#frame = frame;
    const all = tracksOf(this.#decoder, frame.configuration, frame.rung);
    if (!this.#decoder.seekable || all.length < 2) return false;
    if (free !== this.#isFree) {
      this.#isFree = free;
      this.#chosen = { group: null, now: -Infinity };
      if (!free) await this.#decoder.select({ tracks: null });
    }
    if (!free) return this.#isLate(frame.tracks !== null && !all.every((track) => frame.tracks.includes(track)), now);
    const lacks = this.#lacks({ eye, target });
    if (!lacks) this.#awaited = -Infinity;
    const isKnown = this.#chosen.group === frame.group.sequence && now - this.#chosen.now < INTERVAL;
    if (!lacks && isKnown) return false;
    this.#chosen = { group: frame.group.sequence, now };
    const { numerator, denominator } = frame.configuration.timeBase;
    const seconds = (Number(frame.group.end - frame.group.start) * numerator) / denominator;
    await this.#decoder.look({ eye, target, margin: this.speed(now) * (seconds + LEAD) });
    return this.#isLate(lacks, now);
  }
  #lacks({ eye, target }) {
    const known = this.#checked;
    const isKnown =
      known?.frame.tracks === this.#frame.tracks && known.frame.group.sequence === this.#frame.group.sequence;
    if (isKnown && distance(eye, known.eye) < STILL * distance(eye, target)) return known.lacks;
    const lacks = coverage(this.#frame, { eye, target }) < LEAST;
    this.#checked = { eye, frame: this.#frame, lacks };
    return lacks;
  }
  /** One request at a time. */
  #isLate(lacks, now) {
    if (!lacks || now - this.#awaited < PATIENCE) return false;
    this.#awaited = now;
    return true;
  }
}
