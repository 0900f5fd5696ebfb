// From a source to frames in order: seeks through the index, drops what is damaged, says so.

import { FvvError } from "./errors.js";
import { Environments } from "./background.js";
import { GroupIndex } from "./group_index.js";
import { Held } from "./held.js";
import { Parts } from "./parts.js";
import { Session } from "./session.js";

export class Playback {
  /**
   * emit(type, detail): events of the stream. want: {normals, visibility, shares}. selection: tracks of video, as
   * for select. frugal: there will be one before the first frame.
   */
  static async open(source, { module, codec, background, limits, emit, want, selection, frugal }) {
    const playback = new Playback();
    const parts = new Parts(source);
    const index = new GroupIndex(source, parts);
    const held = new Held(source, index);
    Object.assign(playback, { source, emit, want, selection, parts, index, held });
    source.frugal = frugal || selection !== null;
    playback.session = await Session.create({
      module,
      codec,
      limits,
      read: (offset, out) => index.answer(offset, out),
    });
    index.session = playback.session;
    playback.environments = new Environments({ module: background, session: playback.session, emit });
    const trouble = await index.open();
    if (trouble) playback.#warn("no-index", trouble);
    playback.about = playback.#describe();
    return playback;
  }

  #describe() {
    const { index, source } = this;
    // Of one answer it is known in the end how many there are.
    const known = source.front === undefined || (source.rewinds && source.front === index.front && source.complete);
    const { groups, frameCount = null } = known ? index : { groups: null };
    return { seekable: source.rewinds ?? groups !== null, frameCount, groups };
  }
  /** Of one answer: whether what has gone by can be read again, and when it has ended all about it. */
  #tellOfAnswer() {
    if (this.source.front === undefined) return;
    const about = this.#describe();
    if (about.seekable === this.about.seekable && about.frameCount === this.about.frameCount) return;
    this.about = about;
    this.emit("opened", about);
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
    return this.index.find(() => this.session.findBackground(group, track));
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

  #warn(code, message) {
    this.emit("warning", new FvvError({ code, message, severity: "warning", fatal: false }));
  }

  /** Tracks of video that frames come with from the next group on; null: all. */
  select(tracks) {
    this.selection = tracks;
  }

  /** The configuration of the first group, before anything is played; null: the source does not tell yet. */
  async peek() {
    const { session, source, index } = this;
    if (!index.groups?.length || source.inRuns) return null;
    return (await index.satisfied(() => session.play(0))) ? session.configuration() : null;
  }

  /**
   * Frames from a place on; one generator at a time. place: {frame} or {time} (ticks), or nothing for the beginning.
   * Frames that are passed over come with skipped: true and their samples, which decoders of video need.
   */
  async *frames(place, signal) {
    const { session, source, index } = this;
    if (place && source.front !== undefined) index.openKept();
    const { group: first, skip = -1, until } = place ? index.locate(place) : { group: 0, skip: 0 };
    const state = {
      number: first > 0 ? index.groups[first].firstFrame : 0,
      index: -1, // of the group that is read
      at: null, // up to where its bytes have come, from its beginning on
      skip, // frames to pass over; -1: up to a time, until
      until,
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
    if (!state.footer && source.size !== undefined && index.groups && session.indexState === 1)
      this.#warn("truncated", "the stream ends before its footer");
    if (source.complete && source.rewinds) index.openKept();
    this.#tellOfAnswer();
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
      if (!(await this.index.satisfied(() => session.play(first))))
        throw new FvvError({ code: "io", message: "the configuration of the group can't be read" });
      state.fromIndex = true;
    } else if (!source.inRuns) {
      session.start(0);
    }
    const from = source.inRuns || !first ? first : this.index.groups[first].offset;
    let at = source.inRuns ? null : from;
    for await (const item of source.stream(from, signal)) {
      if (!(item instanceof Uint8Array)) {
        yield* this.#turn(state, item);
        continue;
      }
      if (at !== null) state.at = at += item.length;
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
    const { session, parts, index } = this;
    const { reads } = index;
    state.at = null;
    const abort = new AbortController();
    const stop = () => abort.abort();
    signal?.addEventListener("abort", stop, { once: true });
    this.source.leave();
    try {
      await parts.prepare(index.groups, group, signal);
      const leftOut = (await this.#begin(state, group)) ? this.#leftOut() : [];
      if (!leftOut.length) {
        state.whole.add(group);
        return group;
      }
      session.leaveOut(leftOut);
      const picked = session.picked();
      for await (const _ of parts.fetch(picked, abort.signal)) {
        yield* this.#drain(state);
        if (state.ended) break;
      }
      yield* this.#drain(state);
      if (!state.ended) throw new FvvError({ code: "io", message: "a part of a group can't be read" });
      const ranges = [...parts.tableOf(index.groups, group), ...picked];
      this.held.reach(group, index.groups[group].end, ranges, state.tracks);
    } finally {
      state.picking = state.ended = false;
      signal?.removeEventListener("abort", stop);
      abort.abort();
      index.forgetReads(reads);
    }
    if (group + 1 < index.groups.length) return group + 1;
    // What follows was checked when the index was read.
    state.footer = true;
    return null;
  }

  /** false: only all of its bytes tell what is wrong with the group. */
  async #begin(state, group) {
    const { session } = this;
    try {
      if (!(await this.index.satisfied(() => session.pick(group)))) return false;
    } catch (error) {
      if (!["damaged", "invalid", "truncated"].includes(error.code)) throw error;
      this.source.forget?.(this.index.groups[group].offset);
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
    // Damage may be of the way and not of the file: what is asked for again is fetched again.
    for (const offset of [error.offset, this.index.groups?.[state.index]?.offset])
      if (Number.isInteger(offset)) this.source.forget?.(offset);
    state.gap ??= { from: state.lastTime ?? null, error };
  }

  /** false: the group is to be picked from, and nothing of it was told. */
  #beginGroup(state, about) {
    const { inRuns } = this.source;
    const { groups } = this.index;
    const index =
      groups?.findIndex((group) => (inRuns ? group.sequence === about.sequence : group.offset === about.offset)) ?? -1;
    if (index >= 0 && !state.picking && this.#picks(state, index) && this.#videosLeftOut().length) {
      state.next = index;
      return false;
    }
    this.#closeGap(state, about.start);
    this.#tellOfAnswer();
    state.index = index;
    if (index >= 0) state.number = groups[index].firstFrame;
    if (state.known !== about.configuration) {
      const configuration = this.session.configuration();
      // One that stands in the stream was told as it came.
      if (state.fromIndex) this.emit("configuration", configuration);
      state.duration = configuration?.frameDuration ?? 0n;
      state.known = about.configuration;
    }
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
    this.#reach(state, frame.time);
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

  /** What plays again without the network up to the end of a frame. */
  #reach({ index, at, duration, group }, time) {
    const end = time + duration;
    if (this.source.front !== undefined) this.held.pass(time, end);
    else if (index >= 0 && at !== null) {
      const { offset, size } = this.index.groups[index];
      const ranges = [{ from: offset, end: Math.min(at, offset + size) }];
      this.held.reach(index, end < group.end ? end : group.end, ranges, null);
    }
  }
  /** [{start, end}] in ticks: what plays without the network. */
  heldTimes() {
    return this.held.times(this.selection);
  }

  close() {
    this.session.close();
  }
}
