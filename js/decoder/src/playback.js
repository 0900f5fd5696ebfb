// From the groups of a source to frames in order: seeks, drops damaged frames, and reports them and gaps.

import { Environments } from "./environment.js";
import { unlessAborted } from "./abort.js";
import { FvvError } from "./errors.js";
import { Session } from "./session.js";

export class Playback {
  #reader;
  #choice; // of rungs
  #emit;
  #want;
  #selection; // tracks of video; null: all
  #session;
  #environments;
  #reported = null; // rung
  #taken = null; // time of the last frame
  /** {seekable, frameCount, groups, rungs} */
  about;

  /**
   * emit(type, detail): events of the stream. want: {normals, visibility}. selection:
   * tracks of video, as for select. rung: as for setRung. frugal: a selection will be made before the first frame.
   */
  static async open(source, { module, codec, environment, limits, ...more }) {
    const playback = new Playback(source, more);
    const reader = playback.#reader;
    const read = (offset, out) => reader.index.readInto(offset, out);
    const session = (playback.#session = await Session.create({ module, codec, limits, read }));
    playback.#environments = new Environments({ module: environment, session, emit: more.emit });
    playback.#warn("no-index", await reader.open(session));
    playback.about = reader.about;
    return playback;
  }

  constructor(source, { emit, want, selection, rung = "auto", frugal }) {
    this.#emit = emit;
    this.#want = want;
    this.#selection = selection;
    this.#reader = source.reader({
      rung,
      frugal,
      selection: () => this.#selection,
      environments: () => this.#environments.tracks,
      taken: () => this.#taken,
      warn: (error) => emit("warning", error),
    });
    this.#choice = this.#reader.choice;
  }

  get memoryBytes() {
    return this.#session.memoryBytes;
  }

  /** Reports when the source can no longer be sought in, and all of it when it is complete. */
  #reportAbout() {
    const { about } = this.#reader;
    if (about.seekable === this.about.seekable && about.frameCount === this.about.frameCount) return;
    this.about = about;
    this.#emit("opened", about);
  }

  /** Environments that came with a frame, or before the start of playback. Frames don't wait for them. */
  async #takeEnvironments(state) {
    const session = this.#session;
    const found = state.environments.splice(0);
    if (state.lateGroup !== null) {
      const { tracks } = session.configuration();
      for (const { id } of tracks.filter(({ kind }) => kind === "environment"))
        if (!found.some(({ track }) => track === id)) found.push(await this.#findEnvironment(state, id));
      state.lateGroup = null;
    }
    if (found.length) await unlessAborted(this.#environments.take(found), state.signal);
  }

  async #findEnvironment({ lateGroup, signal }, track) {
    return this.#environments.tracks.has(track) ? null : this.#reader.environment(lateGroup, track, signal);
  }

  /** message null: there is nothing to warn of. */
  #warn(code, message) {
    if (message !== null) this.#emit("warning", FvvError.warning(code, message));
  }

  /** Tracks of video in frames from the next group on; null: all. */
  select(tracks) {
    if (JSON.stringify(tracks) === JSON.stringify(this.#selection)) return;
    this.#selection = tracks;
    this.#reader.renewSelection();
  }

  /** "auto" or a rung, from the next group on. */
  setRung(rung) {
    if (rung === this.#choice.wanted) return;
    this.#choice.wanted = rung;
    this.#reader.renewRung();
  }
  /** Rungs with more pixels than are shown are not chosen. */
  setShownScale(scale) {
    this.#choice.shownScale = scale;
  }
  /** The rung worth fetching for a frame that stays on screen; null: nothing is known of it. */
  lastingRung(plays) {
    return this.about.seekable ? this.#choice.lasting(this.#reader.fetchesRungs, plays) : null;
  }
  /** What the network gave, in bits per second, and the seconds that are buffered; null: not known. */
  get network() {
    return this.#reader.network;
  }
  /** The configuration of the first group, before anything is played; null: not known yet. */
  peek() {
    return this.#reader.peek();
  }

  /**
   * Frames from a place on; one generator at a time. place: {frame} or {time} (ticks); undefined: the beginning.
   * Frames before the place are yielded with skipped: true and their samples, which decoders of video need.
   */
  async *frames(place, signal) {
    const { group: first, skip = -1, until } = this.#reader.seek(place);
    this.#choice.once = place?.rung ?? null;
    this.#taken = null;
    // A seek drops reports that were not taken.
    this.#reported = null;
    const state = {
      number: this.#reader.firstFrameOf(first),
      index: -1, // of the current group
      at: null, // end of its bytes that have arrived, from its beginning on
      skip, // number of frames to skip; -1: skip up to the time until
      until,
      candidate: null, // of a seek by time: the last frame that is not later than until
      gap: null,
      group: null,
      environments: [],
      lateGroup: first > 0 ? first : null,
      known: null, // the configuration that was emitted
      tracks: null, // tracks of video in this group; null: all
      rung: null, // of this group; null: there is no ladder
      reason: null, // for the rung
      signal,
    };
    for await (const item of this.#reader.read(state, first)) {
      if (item) this.#takeReport(state, item);
      else yield* this.#drain(state);
    }
    if (signal?.aborted) return;
    if (state.candidate) yield { ...state.candidate, skipped: false };
    this.#closeGap(state, null);
    this.#warn("truncated", this.#reader.finish(state));
    this.#reportAbout();
  }

  /** Takes an object that a reader yields between events of the session. */
  #takeReport(state, { group, rungs, damage, lost, restart }) {
    if (group) this.#beginGroup(state, group);
    if (rungs) this.#emit("rungs", rungs);
    if (damage) this.#emit("warning", damage);
    if (lost) state.gap ??= { from: lost.from ?? state.lastTime ?? null, error: lost.error };
    if (restart) this.#emit("restart", null);
  }

  #closeGap(state, end) {
    if (!state.gap) return;
    this.#emit("warning", FvvError.gap(state.gap.error, { from: state.gap.from, to: end }));
    state.gap = null;
  }

  async *#drain(state) {
    const session = this.#session;
    for (;;) {
      const kind = session.next();
      if (kind === "need data") return session.prepareCodecs();
      if (kind === "done") {
        state.ended = true;
        return;
      }
      if (kind === "end") state.footer = true;
      if (kind === "configuration") {
        this.#emit("configuration", session.configuration());
        state.fromIndex = false;
      }
      if (kind === "damage" && !state.quiet) this.#reportDamage(state, session.damage(), session.isSpared);
      if (kind === "group") {
        const about = session.about();
        if (await this.#reader.redirects(state, about)) return;
        this.#beginGroup(state, about);
      }
      if (kind === "between") {
        this.#between(state);
        await this.#takeEnvironments(state);
      }
      if (kind === "frame") {
        yield* this.#frame(state);
        await this.#takeEnvironments(state);
      }
    }
  }

  /** isSpared: it costs no frame. */
  #reportDamage(state, error, isSpared = false) {
    error.frame = state.number;
    this.#emit("warning", error);
    // The damage may have happened in transit: the bytes are fetched again when they are needed again.
    this.#reader.forget(state.index, error.offset);
    if (!isSpared) state.gap ??= { from: state.lastTime ?? null, error };
  }

  #beginGroup(state, about) {
    this.#closeGap(state, about.start);
    this.#reportAbout();
    if (state.index >= 0) state.number = this.#reader.firstFrameOf(state.index);
    let configuration; // undefined: that of the group before
    if (state.known !== about.configuration) {
      configuration = this.#session.configuration();
      // A configuration inside the stream was emitted when it arrived.
      if (state.fromIndex) this.#emit("configuration", configuration);
      state.duration = configuration?.frameDuration ?? 0n;
      // Of a group whose configuration is lost there is none; another group may find a repetition of it.
      state.known = about.whole ? about.configuration : null;
    }
    this.#environments.begin(about.configuration);
    state.group = { sequence: about.sequence, start: about.start, end: about.end };
    this.#reader.begin(state, configuration);
    state.ofRung = this.#reader.tracksOf(state.rung);
    state.tracks = this.#shownTracks(state);
    this.#session.takeAll();
    this.#session.leaveOut(this.#unused(state));
    this.#reportRung(state);
  }
  /** Tracks of video in a group; null: all. */
  #shownTracks({ ofRung }) {
    if (!ofRung) return this.#selection;
    const videos = this.#session.configuration().videos.map(({ track }) => track);
    return videos.filter((track) => ofRung.includes(track) && (this.#selection?.includes(track) ?? true));
  }
  /** Tracks of a group that nothing is decoded of. Sound and environments come in every rung. */
  #unused({ ofRung, tracks }) {
    const isUsed = ({ id, kind }) =>
      (["audio", "environment"].includes(kind) || (ofRung?.includes(id) ?? true)) &&
      (kind !== "video" || (tracks?.includes(id) ?? true)) &&
      (kind !== "visibility" || this.#want.visibility);
    return (this.#session.configuration()?.tracks ?? []).filter((track) => !isUsed(track)).map(({ id }) => id);
  }
  #reportRung(state) {
    const { rung, reason } = state;
    if (rung === null || rung === this.#reported) return;
    this.#reported = rung;
    this.#emit("rung", { ...this.#choice.all[rung], reason, ...this.network });
  }

  /** Chunks at a time that is no frame, or that follow their frame. */
  #between(state) {
    try {
      this.#take(state, this.#session.decode(null));
    } catch (error) {
      if (!(error instanceof FvvError) || error.fatal) throw error;
      this.#reportDamage(state, error);
    }
  }
  #take(state, { environments: environments, sounds, ...frame }) {
    state.environments.push(...environments);
    if (sounds.length) this.#emit("sounds", sounds);
    return frame;
  }

  async *#frame(state) {
    const session = this.#session;
    if (session.lacksCodecs) await unlessAborted(session.loadCodecs(), state.signal);
    const started = performance.now();
    const skipped = state.skip > 0;
    let frame;
    try {
      frame = session.decode(skipped ? null : this.#want);
    } catch (error) {
      if (!(error instanceof FvvError) || error.fatal) throw error;
      this.#reportDamage(state, error);
      state.number++;
      if (skipped) state.skip--;
      return;
    }
    frame = this.#take(state, frame);
    frame.decodeMs = performance.now() - started;
    frame.number = state.number++;
    frame.group = state.group;
    frame.tracks = state.tracks;
    this.#reader.arrived(state, { start: frame.time, end: frame.time + state.duration });
    frame.rung = state.rung;
    state.lastTime = this.#taken = frame.time;
    if (state.skip < 0) {
      // A seek by time: the last frame that is not later is wanted.
      if (frame.time <= state.until) {
        if (state.candidate) yield { ...state.candidate, skipped: true };
        state.candidate = frame;
        return;
      }
      state.skip = 0;
      if (state.candidate) yield { ...state.candidate, skipped: false };
      state.candidate = null;
    }
    if (skipped) state.skip--;
    yield { ...frame, skipped };
  }

  /** [{start, end}] in ticks: times that can be played without the network. */
  bufferedTimes() {
    return this.#reader.bufferedTimes();
  }

  close() {
    this.#reader.stop();
    this.#session.close();
  }
}
