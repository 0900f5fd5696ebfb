// From a source to frames in order: seeks through the index, drops damaged frames and reports them.

import { GroupPrefetcher, RangeFetcher } from "./sources/group_prefetcher.js";
import { Environments } from "./environment.js";
import { onAbort, unlessAborted } from "./abort.js";
import { FvvError } from "./errors.js";
import { BufferedTimes, GroupIndex } from "./group_index.js";
import { ByteRanges } from "./sources/byte_ranges.js";
import { RungChoice } from "./rung_choice.js";
import { Session } from "./session.js";
import { RangeSource, SectionSource, SequentialSource } from "./sources/types.js";

export class Playback {
  #source;
  #emit;
  #want;
  #selection; // tracks of video; null: all
  #ranges;
  #index;
  #buffered;
  #session;
  #environments;
  #choice; // of rungs
  #ladder = null; // what GroupPrefetcher has to know of them
  #reported = null; // rung
  #prefetcher = null; // of a ladder that is read in ranges
  #taken = null; // time of the last frame
  /** {seekable, frameCount, groups} */
  about;

  /**
   * emit(type, detail): events of the stream. want: {normals, visibility}. selection:
   * tracks of video, as for select. rung: as for setRung. frugal: a selection will be made before the first frame.
   */
  static async open(source, { module, codec, environment, limits, emit, want, selection, rung, frugal }) {
    const playback = new Playback(source, { emit, want, selection, rung });
    const index = playback.#index;
    if (source instanceof RangeSource) source.frugal = frugal || selection !== null;
    playback.#session = await Session.create({
      module,
      codec,
      limits,
      read: (offset, out) => index.readInto(offset, out),
    });
    index.session = playback.#session;
    playback.#environments = new Environments({ module: environment, session: playback.#session, emit });
    const problem = await index.open();
    if (problem) playback.#warn("no-index", problem);
    await playback.#findLadder();
    if (source instanceof SectionSource)
      source.follow(
        (seconds) => playback.#choice.asked(seconds),
        () => playback.#taken,
      );
    playback.about = playback.#describe();
    return playback;
  }

  constructor(source, { emit, want, selection, rung = "auto" }) {
    this.#source = source;
    this.#emit = emit;
    this.#want = want;
    this.#selection = selection;
    this.#choice = new RungChoice(rung, () => source.rungs);
    this.#ranges = new ByteRanges(source);
    const available = function* () {
      yield* this.#ranges;
      if (this.#prefetcher) yield* this.#prefetcher;
    };
    this.#index = new GroupIndex(source, { [Symbol.iterator]: available.bind(this) });
    this.#buffered = new BufferedTimes(source, this.#index);
  }

  get memoryBytes() {
    return this.#session.memoryBytes;
  }

  #describe() {
    const [index, source] = [this.#index, this.#source];
    // The length of a single response is known at its end.
    const isSequential = source instanceof SequentialSource;
    const known = !isSequential || (source.rewinds && source.front === index.front && source.complete);
    const { groups, frameCount = null } = known ? index : { groups: null };
    return { seekable: isSequential ? source.rewinds : groups !== null, frameCount, groups, rungs: source.rungs };
  }
  /** Of a single response: reports when it can no longer be sought in, and all of it when it is complete. */
  #reportResponse() {
    if (!(this.#source instanceof SequentialSource)) return;
    const about = this.#describe();
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
    if (this.#environments.tracks.has(track)) return null;
    if (this.#source instanceof SectionSource) return this.#loadEnvironment(track, signal);
    return this.#index.find(() => this.#session.findEnvironment(lateGroup, track), signal);
  }

  /** From a source that stores environments separately. */
  async #loadEnvironment(track, signal) {
    try {
      return await this.#source.environment(track, signal);
    } catch (error) {
      this.#emit("warning", Object.assign(FvvError.from(error), { fatal: false }));
      return null;
    }
  }

  #warn(code, message) {
    this.#emit("warning", FvvError.warning(code, message));
  }

  /** Tracks of video in frames from the next group on; null: all. */
  select(tracks) {
    if (JSON.stringify(tracks) === JSON.stringify(this.#selection)) return;
    this.#selection = tracks;
    this.#prefetcher?.renew();
  }

  /** "auto" or a rung, from the next group on. */
  setRung(rung) {
    if (rung === this.#choice.wanted) return;
    this.#choice.wanted = rung;
    this.#prefetcher?.renew();
    if (this.#source instanceof SectionSource) this.#source.renew();
  }
  /** Rungs with more pixels than are shown are not chosen. */
  setShownScale(scale) {
    this.#choice.shownScale = scale;
  }
  /** The rung worth fetching for a frame that stays on screen; null: nothing is known of it. */
  get lastingRung() {
    return this.about.seekable ? this.#choice.lasting(this.#prefetcher !== null || this.#source.rungs !== null) : null;
  }
  /** What the network gave, in bits per second, and the seconds that are buffered; null: not known. */
  get network() {
    return {
      throughput: this.#source.throughput ?? this.#choice.chooser.throughput,
      buffer: this.#prefetcher?.buffer ?? this.#source.buffer,
    };
  }

  /** A file that is read in ranges says at its beginning whether it has a ladder. */
  async #findLadder() {
    const [source, session, index] = [this.#source, this.#session, this.#index];
    const first = index.groups?.[0];
    if (!first || !source.selective || session.indexState !== 1) return;
    // The bytes after it are the first frames.
    if (!source.frugal) index.keep(0, await source.read(0, first.offset));
    if (!(await index.satisfied(() => session.play(0)))) return;
    this.#setRungs(session.configuration());
    if (this.#choice.rungs.length < 2) return;
    source.frugal = true;
    // The table of the group and the bytes of its first picture come at the same time.
    const began = performance.now();
    const measured = (bytes) => this.#choice.chooser.began(bytes, (performance.now() - began) / 1000);
    source.lead().then(measured, () => {}); // who reads them reports the error
    this.#lookAhead();
  }
  #lookAhead() {
    this.#prefetcher?.stop();
    const { groups } = this.#index;
    const fetcher = new RangeFetcher(this.#source, groups, this.#ladder);
    this.#prefetcher =
      this.#choice.rungs.length > 1 ? new GroupPrefetcher(fetcher, groups, this.#ladder, () => this.#taken) : null;
  }
  #setRungs(configuration) {
    if (!this.#choice.learn(configuration)) return;
    const { rungs } = this.#choice;
    const { numerator, denominator } = configuration.timeBase;
    const all = configuration.tracks.map(({ id }) => id);
    this.#ladder = {
      ...this.#choice.asked((ticks) => (Number(ticks) * numerator) / denominator),
      rungs,
      leftOut: (rung) => {
        const taken = rungs[rung].tracks;
        return [
          ...new Set([
            ...all.filter((id) => !taken.includes(id)),
            ...this.#videosLeftOut(configuration),
            ...this.#environments.tracks,
          ]),
        ];
      },
    };
  }
  /** The configuration of the first group, before anything is played; null: not known yet. */
  async peek() {
    const [session, source, index] = [this.#session, this.#source, this.#index];
    if (!index.groups?.length || source instanceof SectionSource) return null;
    return (await index.satisfied(() => session.play(0))) ? session.configuration() : null;
  }

  /**
   * Frames from a place on; one generator at a time. place: {frame} or {time} (ticks); undefined: the beginning.
   * Frames before the place are yielded with skipped: true and their samples, which decoders of video need.
   */
  async *frames(place, signal) {
    const [session, source, index] = [this.#session, this.#source, this.#index];
    if (place && source instanceof SequentialSource) index.openKept();
    const { group: first, skip = -1, until } = place ? index.locate(place) : { group: 0, skip: 0 };
    this.#taken = null;
    // A seek drops reports that were not taken.
    this.#reported = null;
    const state = {
      number: first > 0 ? index.groups[first].firstFrame : 0,
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
      whole: new Set(), // groups that cannot be picked from
      recalled: new Set(), // groups whose configuration comes from a repetition that follows them
      next: null, // the group to be picked from instead of being read in order
      signal,
    };
    this.#ranges.clear();
    this.#prefetcher?.stop();
    for (let group = first; group !== null;)
      group = yield* this.#picks(state, group) ? this.#pick(state, group, signal) : this.#stream(state, group, signal);
    if (signal?.aborted) return;
    if (state.candidate) yield { ...state.candidate, skipped: false };
    this.#closeGap(state, null);
    if (!state.footer && source instanceof RangeSource && index.groups && session.indexState === 1)
      this.#warn("truncated", "the stream ends before its footer");
    if (source.complete && source.rewinds) index.openKept();
    this.#reportResponse();
  }

  /** Whether a group should be read without some of its tracks. */
  #picks(state, group) {
    const [source, session] = [this.#source, this.#session];
    const wanted = this.#selection !== null || this.#prefetcher !== null;
    return wanted && source.selective && session.indexState === 1 && !state.whole.has(group);
  }

  /** Reads bytes in order, from a group on. Returns the group to be picked from, or null at the end. */
  async *#stream(state, first, signal) {
    const [session, source] = [this.#session, this.#source];
    if (!(source instanceof SectionSource) && (first > 0 || state.recalled.has(first))) {
      if (!(await this.#index.satisfied(() => session.play(first), signal)))
        throw new FvvError({ code: "io", message: "the configuration of the group cannot be read" });
      state.fromIndex = true;
    } else if (!(source instanceof SectionSource)) {
      session.start(0);
    }
    const from =
      source instanceof SectionSource || !(first || state.recalled.has(first))
        ? first
        : this.#index.groups[first].offset;
    let at = source instanceof SectionSource ? null : from;
    for await (const item of source.stream(from, signal)) {
      if (item.rung !== undefined) {
        [state.rung, state.reason] = [item.rung, item.reason];
        continue;
      }
      if (item.rungs !== undefined) {
        this.#emit("rungs", item.rungs);
        continue;
      }
      if (!(item instanceof Uint8Array)) {
        yield* this.#takeReport(state, item);
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
    if (source instanceof SectionSource) {
      yield* this.#endSection(state);
    } else {
      session.finish();
      yield* this.#drain(state);
    }
    return null;
  }

  /** Reads a group without unselected tracks. Returns the next group, or the same one if it has to be read whole. */
  async *#pick(state, group, signal) {
    if (this.#prefetcher) return yield* this.#pickRung(state, group, signal);
    const [session, index] = [this.#session, this.#index];
    const { reads } = index;
    state.at = null;
    const abort = new AbortController();
    const unregister = onAbort(signal, () => abort.abort());
    this.#source.leave();
    try {
      await this.#ranges.prepare(index.groups, group, signal);
      const leftOut = (await this.#begin(state, group)) ? this.#leftOut() : [];
      if (!leftOut.length) {
        state.whole.add(group);
        return group;
      }
      session.leaveOut(leftOut);
      const picked = session.picked();
      for await (const _ of this.#ranges.fetch(picked, abort.signal)) {
        yield* this.#drain(state);
        if (state.ended) break;
      }
      yield* this.#drain(state);
      if (!state.ended) throw new FvvError({ code: "io", message: "a part of a group cannot be read" });
      const ranges = [...this.#ranges.tableOf(index.groups, group), ...picked];
      this.#buffered.cover(group, index.groups[group].end, ranges, state.tracks);
    } finally {
      state.picking = state.ended = false;
      unregister();
      abort.abort();
      index.forgetReads(reads);
    }
    if (group + 1 < index.groups.length) return group + 1;
    // The rest was checked when the index was read.
    state.footer = true;
    return null;
  }

  /** The same with a ladder: the group comes in the rung that was chosen when it was fetched. */
  async *#pickRung(state, group, signal) {
    const [session, prefetcher, index] = [this.#session, this.#prefetcher, this.#index];
    const { reads } = index;
    state.at = null;
    if (!prefetcher.running) prefetcher.start(group, signal);
    const pending = await prefetcher.take(group);
    if (!pending || signal?.aborted) return null;
    if (pending.error) throw pending.error;
    [state.rung, state.reason] = [pending.rung, pending.reason];
    const ladder = this.#ladder;
    try {
      if (!(await this.#begin(state, group))) {
        prefetcher.stop();
        state.whole.add(group);
        return group;
      }
      if (ladder !== this.#ladder) {
        // Another configuration, with other tracks than those that were fetched.
        this.#lookAhead();
        return group;
      }
      session.leaveOut(pending.leftOut);
      for await (const _ of prefetcher.arrivals(pending)) {
        yield* this.#drain(state);
        if (state.ended) break;
      }
      if (!state.ended) throw new FvvError({ code: "io", message: "a part of a group cannot be read" });
      const ranges = [...this.#ranges.tableOf(index.groups, group), ...pending.ranges];
      this.#buffered.cover(group, index.groups[group].end, ranges, state.tracks);
    } finally {
      state.picking = state.ended = false;
      index.forgetReads(reads);
    }
    if (group + 1 < index.groups.length) return group + 1;
    prefetcher.stop();
    state.footer = true;
    return null;
  }

  /** false: the group is damaged, and all of its bytes have to be read for a report. */
  async #begin(state, group) {
    const session = this.#session;
    try {
      if (!(await this.#index.satisfied(() => session.pick(group), state.signal))) return false;
    } catch (error) {
      if (!["damaged", "invalid", "truncated"].includes(error.code)) throw error;
      this.#source.forget(this.#index.groups[group].offset);
      return false;
    }
    state.picking = state.fromIndex = true;
    if (session.next() !== "group") return false;
    this.#beginGroup(state, session.about());
    return true;
  }

  #videosLeftOut({ videos } = this.#session.configuration()) {
    if (this.#selection === null) return [];
    return videos.map(({ track }) => track).filter((track) => !this.#selection.includes(track));
  }
  /** Tracks of a group that need not be fetched: unselected video and known environments. */
  #leftOut() {
    const videos = this.#videosLeftOut();
    return videos.length ? [...videos, ...this.#environments.tracks] : [];
  }

  /** Takes an object that a source in sections yields between bytes (see sources/open.js). */
  async *#takeReport(state, { header, damage, lost, restart }) {
    yield* this.#endSection(state);
    if (damage) this.#emit("warning", damage);
    if (lost) state.gap ??= { from: lost.from ?? state.lastTime ?? null, error: lost.error };
    if (restart) this.#emit("restart", null);
    if (!header) return;
    this.#session.join();
    state.inSection = true;
    for (const _ of this.#session.push(header)) yield* this.#drain(state);
  }

  /** A section may end anywhere: an incomplete last frame is not damage. */
  async *#endSection(state) {
    if (!state.inSection) return;
    this.#session.finish();
    state.quiet = true;
    yield* this.#drain(state);
    state.quiet = state.inSection = state.ended = false;
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
      if (kind === "damage" && !state.quiet) this.#reportDamage(state, session.damage());
      if (kind === "group" && ((await this.#recalls(state)) || !this.#beginGroup(state, session.about()))) return;
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

  #reportDamage(state, error) {
    error.frame = state.number;
    this.#emit("warning", error);
    // The damage may have happened in transit: the bytes are fetched again when they are needed again.
    for (const offset of [error.offset, this.#index.groups?.[state.index]?.offset])
      if (Number.isInteger(offset)) this.#source.forget(offset);
    state.gap ??= { from: state.lastTime ?? null, error };
  }

  /** Whether the group that begins is read again because a repetition of its lost configuration follows it. */
  async #recalls(state) {
    const { offset, whole, configuration } = this.#session.about();
    if (whole || this.#source instanceof SectionSource || this.#session.indexState !== 1) return false;
    const group = this.#index.at(offset);
    if (group < 0 || state.recalled.has(group)) return false;
    state.recalled.add(group);
    if (!(await this.#index.find(() => this.#session.hasConfiguration(group, configuration), state.signal)))
      return false;
    state.next = group;
    return true;
  }

  /** false: the group is to be picked from, and nothing of it was emitted. */
  #beginGroup(state, about) {
    const inSections = this.#source instanceof SectionSource;
    const { groups } = this.#index;
    const index = inSections ? this.#index.numbered(about.sequence) : this.#index.at(about.offset);
    const leavesOut = () => this.#prefetcher !== null || this.#videosLeftOut().length > 0;
    if (index >= 0 && !state.picking && this.#picks(state, index) && leavesOut()) {
      state.next = index;
      return false;
    }
    this.#closeGap(state, about.start);
    this.#reportResponse();
    state.index = index;
    if (index >= 0) state.number = groups[index].firstFrame;
    if (state.known !== about.configuration) {
      const configuration = this.#session.configuration();
      // A configuration inside the stream was emitted when it arrived.
      if (state.fromIndex) this.#emit("configuration", configuration);
      state.duration = configuration?.frameDuration ?? 0n;
      // Of a group whose configuration is lost there is none; another group may find a repetition of it.
      state.known = about.whole ? about.configuration : null;
      if (configuration) this.#setRungs(configuration);
      const named = this.#source.rungs && this.#source.rungOf(configuration?.tracks.map(({ id }) => id) ?? []);
      if (named) [state.rung, state.reason] = [named.rung, named.reason];
    }
    this.#environments.begin(about.configuration);
    state.group = { sequence: about.sequence, start: about.start, end: about.end };
    if (!state.picking && !this.#source.rungs) [state.rung, state.reason] = [this.#choice.local, "chosen"];
    state.tracks = this.#shownTracks(state.rung);
    this.#reportRung(state);
    return true;
  }
  /** Tracks of video in a rung; null: all. */
  #shownTracks(rung) {
    if (rung === null || this.#source.rungs) return this.#selection;
    const { tracks } = this.#choice.rungs[rung];
    const videos = this.#session.configuration().videos.map(({ track }) => track);
    return videos.filter((track) => tracks.includes(track) && (this.#selection?.includes(track) ?? true));
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
    this.#cover(state, frame.time);
    frame.rung = state.rung;
    if (state.tracks) frame.samples = frame.samples.filter(({ track }) => state.tracks.includes(track));
    if (state.rung !== null && !this.#source.rungs) {
      const { tracks } = this.#choice.rungs[state.rung];
      frame.meshes = frame.meshes.filter(({ track }) => tracks.includes(track));
      frame.visibility = frame.visibility.filter(({ track }) => tracks.includes(track));
    }
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

  /** Notes that everything up to the end of a frame is in the cache. */
  #cover({ index, at, duration, group }, time) {
    const end = time + duration;
    if (this.#source instanceof SequentialSource) this.#buffered.append(time, end);
    else if (index >= 0 && at !== null) {
      const { offset, size } = this.#index.groups[index];
      const ranges = [{ from: offset, end: Math.min(at, offset + size) }];
      this.#buffered.cover(index, end < group.end ? end : group.end, ranges, null);
    }
  }
  /** [{start, end}] in ticks: times that can be played without the network. */
  bufferedTimes() {
    return this.#buffered.times(this.#selection);
  }

  close() {
    this.#prefetcher?.stop();
    this.#session.close();
  }
}
