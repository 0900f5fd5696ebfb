// From a source to frames in order: seeks through the index, drops what is damaged, says so.

import { FvvError } from "./errors.js";
import { readBackground } from "./background.js";
import { Session } from "./session.js";

/** So many reads and bytes to find the index; a file that needs more is read from front to back. */
const INDEX_READS = 64;
const INDEX_BYTES = 2 ** 26;
const READ_LEAST = 1 << 14;

export class Playback {
  /** emit(type, detail): events of the stream. want: {normals, visibility, shares} */
  static async open(source, { module, codec, background, limits, emit, want }) {
    const playback = new Playback();
    const held = [];
    Object.assign(playback, { source, emit, want, held, groups: null, missing: null, background });
    playback.surroundings = { configuration: null, tracks: new Set() };
    playback.session = await Session.create({
      module,
      codec,
      limits,
      read: (offset, out) => playback.#answer(offset, out),
    });
    if (source.size !== undefined) await playback.#openIndex();
    if (source.groups) playback.#number(source.groups);
    return playback;
  }

  /** What the core reads of the index, out of what is held; else what is missing is noted. */
  #answer(offset, out) {
    for (const { at, bytes } of this.held)
      if (offset >= at && offset + out.length <= at + bytes.length) {
        out.set(bytes.subarray(offset - at, offset - at + out.length));
        return true;
      }
    this.missing = { offset, size: out.length };
    return false;
  }

  /** Calls step until it has what it reads; false: that would be too much. */
  async #satisfied(step) {
    let total = 0;
    for (let reads = 0; !step(); reads++) {
      const { offset, size } = this.missing;
      total += size;
      if (reads >= INDEX_READS || total > INDEX_BYTES) return false;
      const wanted = Math.min(Math.max(size, READ_LEAST), this.source.size - offset);
      const bytes = await this.source.read(offset, wanted);
      if (bytes.length < size) throw new FvvError({ code: "io", message: `${size} bytes at ${offset} can't be read` });
      this.held.push({ at: offset, bytes });
    }
    return true;
  }

  /** Environments that came with a frame, or in front of where playing began. Frames don't wait for them. */
  async #takeBackgrounds(state) {
    const { session } = this;
    const found = state.backgrounds.splice(0);
    if (state.lateGroup !== null) {
      const { tracks } = session.configuration();
      for (const { id } of tracks.filter(({ kind }) => kind === "background"))
        if (!found.some(({ track }) => track === id)) found.push(await this.#findBackground(state.lateGroup, id));
      state.lateGroup = null;
    }
    for (const payload of found) {
      if (!payload || this.surroundings.tracks.has(payload.track)) continue;
      this.surroundings.tracks.add(payload.track);
      try {
        this.emit("background", await readBackground(payload, { module: this.background, session }));
      } catch (error) {
        if (!(error instanceof FvvError)) throw error;
        error.fatal = false;
        this.emit("corrupt", error);
      }
    }
  }

  async #findBackground(group, track) {
    if (this.surroundings.tracks.has(track)) return null;
    let found;
    const step = () => {
      this.missing = null;
      found = this.session.findBackground(group, track);
      // What is not there may only not have been read.
      return found || !this.missing;
    };
    return (await this.#satisfied(step)) ? found : null;
  }

  async #openIndex() {
    const { source } = this;
    if (source.bytes) this.held.push({ at: 0, bytes: source.bytes });
    const found = await this.#satisfied(() => this.session.open(source.size));
    if (!found) {
      this.#warn("no-index", "there is no index: the file is read from front to back");
      return;
    }
    if (this.session.indexState === 2) this.#warn("no-index", "there is no good index: it was rebuilt from all bytes");
    this.#number(this.session.groups());
  }

  #number(groups) {
    this.groups = groups;
    let first = 0;
    for (const group of groups) {
      group.firstFrame = first;
      first += group.frameCount;
    }
    this.frameCount = first;
  }

  #warn(code, message) {
    this.emit("warning", new FvvError({ code, message, severity: "warning", fatal: false }));
  }

  /** Group and the frames in it to pass over, for frame number n. */
  locate(n) {
    const { groups } = this;
    let i = groups.findLastIndex((group) => group.firstFrame <= n && group.frameCount);
    if (i < 0) i = 0;
    return { group: i, skip: n - groups[i].firstFrame };
  }
  /** The same for a time: the frame that is shown then, the last one at or before it. */
  locateTime(time) {
    const { groups } = this;
    let i = groups.findLastIndex((group) => group.start <= time && group.frameCount);
    if (i < 0) i = groups.findIndex((group) => group.frameCount);
    return { group: Math.max(i, 0), until: time };
  }

  /**
   * Frames from a place on; one generator at a time. place: {group, skip | until}, or nothing for the beginning.
   * Frames that are passed over come with skipped: true and their samples, which decoders of video need.
   */
  async *frames(place, signal) {
    const { session, source } = this;
    let number = 0;
    const seeking = place && (place.group > 0 || place.skip || place.until !== undefined);
    if (place && place.group > 0) {
      number = this.groups[place.group].firstFrame;
      if (!source.inRuns && !(await this.#satisfied(() => session.play(place.group))))
        throw new FvvError({ code: "io", message: "the configuration of the group can't be read" });
      if (!source.inRuns) this.emit("configuration", session.configuration());
    } else if (!source.inRuns) {
      session.start(0);
    }
    const state = {
      number,
      skip: place?.skip ?? 0,
      until: place?.until,
      first: place?.group ?? 0,
      held: null,
      gap: null,
      group: null,
      backgrounds: [],
      lateGroup: place?.group > 0 ? place.group : null,
    };
    const group = place?.group ?? 0;
    const from = source.inRuns || !group ? group : this.groups[group].offset;
    if (seeking && place.until !== undefined) state.skip = -1;
    for await (const item of source.stream(from, signal)) {
      if (!(item instanceof Uint8Array)) {
        yield* this.#turn(state, item);
        continue;
      }
      for (const _ of session.push(item)) yield* this.#drain(state);
      if (state.ended) break;
    }
    if (source.inRuns) {
      yield* this.#endRun(state);
    } else {
      session.finish();
      yield* this.#drain(state);
    }
    if (state.held) yield { ...state.held, skipped: false };
    this.#closeGap(state, null);
    if (!state.footer && source.size !== undefined && this.groups && session.indexState === 1)
      this.#warn("truncated", "the stream ends before its footer");
  }

  /** What a source in runs says between bytes (runs.js). */
  async *#turn(state, { header, lost, restart }) {
    yield* this.#endRun(state);
    if (lost) state.gap ??= { from: lost.from ?? state.lastTime ?? null, error: lost.error };
    if (restart) this.emit("restart", null);
    if (!header) return;
    this.session.join(header);
    state.running = true;
  }

  /** A run may end anywhere: that its last frame is not whole is no damage. */
  async *#endRun(state) {
    if (!state.running) return;
    this.session.finish();
    state.quiet = true;
    yield* this.#drain(state);
    state.quiet = state.running = state.ended = false;
  }

  #closeGap(state, end) {
    if (!state.gap) return;
    this.emit("gap", { from: state.gap.from, to: end, error: state.gap.error });
    state.gap = null;
  }

  async *#drain(state) {
    const { session } = this;
    for (;;) {
      const kind = session.next();
      if (kind === "need data") return;
      if (kind === "done") {
        state.ended = true;
        return;
      }
      if (kind === "end") state.footer = true;
      if (kind === "configuration") this.emit("configuration", session.configuration());
      if (kind === "damage" && !state.quiet) this.#corrupt(state, session.damage());
      if (kind === "group") this.#beginGroup(state, session.about());
      if (kind === "frame") {
        yield* this.#frame(state);
        await this.#takeBackgrounds(state);
      }
    }
  }

  #corrupt(state, error) {
    this.emit("corrupt", error);
    state.gap ??= { from: state.lastTime ?? null, error };
  }

  #beginGroup(state, about) {
    this.#closeGap(state, about.start);
    const { inRuns } = this.source;
    const known = this.groups?.find((group) =>
      inRuns ? group.sequence === about.sequence : group.offset === about.offset,
    );
    if (known) state.number = known.firstFrame;
    if (about.configuration !== this.surroundings.configuration) {
      if (this.surroundings.tracks.size) this.emit("background", null);
      this.surroundings = { configuration: about.configuration, tracks: new Set() };
    }
    state.group = { sequence: about.sequence, start: about.start, end: about.end };
  }

  async *#frame(state) {
    const { session } = this;
    if (session.lacksCodecs) await session.loadCodecs();
    const started = performance.now();
    const passing = state.skip > 0;
    let frame;
    try {
      frame = session.decode(passing ? null : this.want);
    } catch (error) {
      if (!(error instanceof FvvError) || error.fatal) throw error;
      this.#corrupt(state, error);
      state.number++;
      if (passing) state.skip--;
      return;
    }
    const { backgrounds, ...rest } = frame;
    state.backgrounds.push(...backgrounds);
    frame = rest;
    frame.decodeMs = performance.now() - started;
    frame.number = state.number++;
    frame.group = state.group;
    state.lastTime = frame.time;
    if (state.skip < 0) {
      // A time is sought: the last frame that is not later is the one.
      if (frame.time <= state.until) {
        if (state.held) yield { ...state.held, skipped: true };
        state.held = frame;
        return;
      }
      state.skip = 0;
      if (state.held) yield { ...state.held, skipped: false };
      state.held = null;
    }
    if (passing) state.skip--;
    yield { ...frame, skipped: passing };
  }

  close() {
    this.session.close();
  }
}
