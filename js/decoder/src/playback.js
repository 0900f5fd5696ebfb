// From a source to frames in order: seeks through the index, drops what is damaged, says so.

import { FvvError } from "./errors.js";
import { Environments } from "./background.js";
import { Parts } from "./parts.js";
import { Session } from "./session.js";

/** So many reads and bytes to find the index; a file that needs more is read from front to back. */
const INDEX_READS = 64;
const INDEX_BYTES = 2 ** 26;
const READ_LEAST = 1 << 14;

export class Playback {
  /**
   * emit(type, detail): events of the stream. want: {normals, visibility, shares}. selection: tracks of video, as
   * for select. frugal: there will be one before the first frame.
   */
  static async open(source, { module, codec, background, limits, emit, want, selection, frugal }) {
    const playback = new Playback();
    const held = [];
    Object.assign(playback, { source, emit, want, held, selection, groups: null, missing: null });
    playback.parts = new Parts(source);
    source.frugal = frugal || selection !== null;
    playback.session = await Session.create({
      module,
      codec,
      limits,
      read: (offset, out) => playback.#answer(offset, out),
    });
    playback.environments = new Environments({ module: background, session: playback.session, emit });
    if (source.size !== undefined) await playback.#openIndex();
    if (source.groups) playback.#number(source.groups);
    return playback;
  }

  /** What the core reads of the index, out of what is held; else what is missing is noted. */
  #answer(offset, out) {
    for (const { at, bytes } of [...this.held, ...this.parts])
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
    await this.environments.take(found);
  }

  async #findBackground(group, track) {
    if (this.environments.tracks.has(track)) return null;
    if (this.source.inRuns) return this.#loadBackground(track);
    let found;
    const step = () => {
      this.missing = null;
      found = this.session.findBackground(group, track);
      // What is not there may only not have been read.
      return found || !this.missing;
    };
    return (await this.#satisfied(step)) ? found : null;
  }

  /** Of a source that has environments apart. */
  async #loadBackground(track) {
    try {
      return (await this.source.background?.(track)) ?? null;
    } catch (error) {
      this.emit("corrupt", Object.assign(FvvError.from(error), { fatal: false }));
      return null;
    }
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

  /** Tracks of video that frames come with from the next group on; null: all. */
  select(tracks) {
    this.selection = tracks;
  }

  /** The configuration of the first group, before anything is played; null: the source does not tell yet. */
  async peek() {
    const { session, source, groups } = this;
    if (!groups?.length || source.inRuns) return null;
    return (await this.#satisfied(() => session.play(0))) ? session.configuration() : null;
  }

  /**
   * Frames from a place on; one generator at a time. place: {group, skip | until}, or nothing for the beginning.
   * Frames that are passed over come with skipped: true and their samples, which decoders of video need.
   */
  async *frames(place, signal) {
    const { session, source } = this;
    const first = place?.group ?? 0;
    const state = {
      number: first > 0 ? this.groups[first].firstFrame : 0,
      skip: place?.until !== undefined ? -1 : (place?.skip ?? 0),
      until: place?.until,
      held: null,
      gap: null,
      group: null,
      backgrounds: [],
      lateGroup: first > 0 ? first : null,
      known: null, // which configuration was told
      tracks: null, // of video that this group comes with; null: all
      whole: new Set(), // groups that can't be picked from
      next: null, // the group that is to be picked from, in place of what is being read
    };
    this.parts.clear();
    for (let group = first; group !== null;)
      group = yield* this.#picks(state, group) ? this.#pick(state, group, signal) : this.#stream(state, group, signal);
    if (state.held) yield { ...state.held, skipped: false };
    this.#closeGap(state, null);
    if (!state.footer && source.size !== undefined && this.groups && session.indexState === 1)
      this.#warn("truncated", "the stream ends before its footer");
  }

  /** Whether it is worth while to read a group without some of its tracks. */
  #picks(state, group) {
    const { source, session, selection } = this;
    return selection !== null && source.inParts === true && session.indexState === 1 && !state.whole.has(group);
  }

  /** What comes as bytes, from a group on: answers the group to be picked from, or null at the end. */
  async *#stream(state, first, signal) {
    const { session, source } = this;
    if (!source.inRuns && first > 0) {
      if (!(await this.#satisfied(() => session.play(first))))
        throw new FvvError({ code: "io", message: "the configuration of the group can't be read" });
      state.fromIndex = true;
    } else if (!source.inRuns) {
      session.start(0);
    }
    for await (const item of source.stream(source.inRuns || !first ? first : this.groups[first].offset, signal)) {
      if (!(item instanceof Uint8Array)) {
        yield* this.#turn(state, item);
        continue;
      }
      for (const _ of session.push(item)) {
        yield* this.#drain(state);
        if (state.next !== null) break;
      }
      if (state.ended || state.next !== null) break;
    }
    const { next } = state;
    state.next = null;
    if (next !== null) return next;
    if (source.inRuns) {
      yield* this.#endRun(state);
    } else {
      session.finish();
      yield* this.#drain(state);
    }
    return null;
  }

  /** A group without the tracks that are not selected. Answers the next one, or itself when it has to come whole. */
  async *#pick(state, group, signal) {
    const { session, parts } = this;
    const held = this.held.length;
    const abort = new AbortController();
    const stop = () => abort.abort();
    signal?.addEventListener("abort", stop, { once: true });
    this.source.leave();
    try {
      await parts.prepare(this.groups, group, signal);
      const leftOut = (await this.#begin(state, group)) ? this.#leftOut() : [];
      if (!leftOut.length) {
        state.whole.add(group);
        return group;
      }
      session.leaveOut(leftOut);
      for await (const _ of parts.fetch(session.picked(), abort.signal)) {
        yield* this.#drain(state);
        if (state.ended) break;
      }
      yield* this.#drain(state);
      if (!state.ended) throw new FvvError({ code: "io", message: "a part of a group can't be read" });
    } finally {
      state.picking = state.ended = false;
      signal?.removeEventListener("abort", stop);
      abort.abort();
      this.held.length = held;
    }
    if (group + 1 < this.groups.length) return group + 1;
    // What follows was checked when the index was read.
    state.footer = true;
    return null;
  }

  /** false: only all of its bytes tell what is wrong with the group. */
  async #begin(state, group) {
    const { session } = this;
    try {
      if (!(await this.#satisfied(() => session.pick(group)))) return false;
    } catch (error) {
      if (!["damaged", "invalid", "truncated"].includes(error.code)) throw error;
      return false;
    }
    state.picking = state.fromIndex = true;
    if (session.next() !== "group") return false;
    this.#beginGroup(state, session.about());
    return true;
  }

  #videosLeftOut() {
    const { videos } = this.session.configuration();
    return videos.map(({ track }) => track).filter((track) => !this.selection.includes(track));
  }
  /** Tracks that a group needs not be fetched with: video that is not selected and environments that are known. */
  #leftOut() {
    const videos = this.#videosLeftOut();
    return videos.length ? [...videos, ...this.environments.tracks] : [];
  }

  /** What a source in runs says between bytes (runs.js). */
  async *#turn(state, { header, damage, lost, restart }) {
    yield* this.#endRun(state);
    if (damage) this.emit("corrupt", damage);
    if (lost) state.gap ??= { from: lost.from ?? state.lastTime ?? null, error: lost.error };
    if (restart) this.emit("restart", null);
    if (!header) return;
    this.session.join();
    state.running = true;
    for (const _ of this.session.push(header)) yield* this.#drain(state);
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
      if (kind === "configuration") {
        this.emit("configuration", session.configuration());
        state.fromIndex = false;
      }
      if (kind === "damage" && !state.quiet) this.#corrupt(state, session.damage());
      if (kind === "group" && !this.#beginGroup(state, session.about())) return;
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

  /** false: the group is to be picked from, and nothing of it was told. */
  #beginGroup(state, about) {
    const { inRuns } = this.source;
    const { groups } = this;
    const index = groups?.findIndex((group) =>
      inRuns ? group.sequence === about.sequence : group.offset === about.offset,
    );
    if (index >= 0 && !state.picking && this.#picks(state, index) && this.#videosLeftOut().length) {
      state.next = index;
      return false;
    }
    this.#closeGap(state, about.start);
    if (index >= 0) state.number = groups[index].firstFrame;
    // A configuration that stands in the stream was told as it came.
    if (state.fromIndex && state.known !== about.configuration)
      this.emit("configuration", this.session.configuration());
    state.known = about.configuration;
    this.environments.begin(about.configuration);
    state.group = { sequence: about.sequence, start: about.start, end: about.end };
    state.tracks = this.selection;
    return true;
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
    frame.tracks = state.tracks;
    if (state.tracks) frame.samples = frame.samples.filter(({ track }) => state.tracks.includes(track));
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
