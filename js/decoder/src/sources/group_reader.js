// The groups of a source, brought into a session step by step. Each type of source has a reader, which knows what the source can do;
// playback knows readers only. What is the same for all of them is here.

import { BufferedTimes } from "./buffered_times.js";
import { FvvError } from "../errors.js";
import { GroupIndex } from "./group_index.js";
import { RungChoice } from "../rung_choice.js";

/**
 * Playback passes a state to begin, read, ... It has skip and until (as of GroupIndex.locate), signal, tracks (of video in this group; null:
 * all) and what a reader notes there: index (of the current group; -1: not known), rung and reason (null: there is no ladder), picking
 * (whether the group is read without some of its tracks), fromIndex (whether its configuration was read through the index).
 * Playback sets ended and footer when the core reports them.
 */
export class GroupReader {
  source;
  session = null;
  index;
  choice; // of rungs
  buffered;
  wishes;

  /**
   * wishes: {rung, selection(): tracks of video, null: all; environments(): tracks whose environment is known; taken(): time of the last
   * frame that was taken, or null; warn(error)}
   */
  constructor(source, wishes, { available, readsAnywhere } = {}) {
    this.source = source;
    this.wishes = wishes;
    this.choice = new RungChoice(wishes.rung, () => source.rungs);
    this.index = new GroupIndex(source, { available, readsAnywhere });
    this.buffered = new BufferedTimes(source, this.index);
  }

  /** Returns a description of what is wrong with the index, or null. session: reads through readInto of the index. */
  async open(session) {
    this.session = this.index.session = session;
    return this.index.open();
  }
  /** {seekable, frameCount, groups, rungs} */
  get about() {
    const { groups, frameCount = null } = this.index;
    return { seekable: groups !== null, frameCount, groups, rungs: this.source.rungs };
  }
  /** The configuration of the first group, before anything is played; null: not known yet. */
  async peek() {
    const { session, index } = this;
    if (!index.groups?.length) return null;
    return (await index.satisfied(() => session.play(0))) ? session.configuration() : null;
  }
  /** What the network gave, in bits per second, and the seconds that are buffered; null: not known. */
  get network() {
    return { throughput: this.source.throughput ?? this.choice.chooser.throughput, buffer: this.source.buffer };
  }
  /** Whether rungs are fetched one by one. */
  get fetchesRungs() {
    return this.source.rungs !== null;
  }

  /** Another selection, or another rung, is wanted from the next group on. */
  renewSelection() {}
  renewRung() {}

  /** Goes to a place, {frame} or {time}; undefined: to the beginning. Returns {group, skip, until}. */
  seek(place) {
    return place ? this.index.locate(place) : { group: 0, skip: 0 };
  }
  firstFrameOf(group) {
    return group > 0 ? this.index.groups[group].firstFrame : 0;
  }
  /**
   * Brings a group and those after it into the session. Yields null when the session has events, which have to be taken, and objects
   * between them:
   *   {group}     a group begins, as about of the session describes it
   *   {rungs}     the rungs have changed
   *   others      as a SectionSource yields them
   */
  async *read(state, first) {
    for (let group = first; group !== null;) group = yield* this.inOrder(state, group);
  }
  /** Everything was read. Returns a description of what is missing, or null. */
  finish() {
    return null;
  }

  /** Reads bytes in order, from a group on. Returns the group to be read instead, or null at the end. */
  async *inOrder(state, first) {
    const { session, index } = this;
    let at = 0;
    if (first > 0 || this.#recalled(state).has(first)) {
      if (!(await index.satisfied(() => session.play(first), state.signal)))
        throw new FvvError({ code: "io", message: "the configuration of the group cannot be read" });
      state.fromIndex = true;
      at = index.groups[first].offset;
    } else {
      session.start(0);
    }
    state.next = null;
    for await (const bytes of this.source.stream(at, state.signal)) {
      state.at = at += bytes.length;
      for (const _ of session.push(bytes)) {
        yield null;
        if (state.next !== null) break;
      }
      if (state.ended || state.next !== null) break;
    }
    if (state.next !== null) return state.next;
    session.finish();
    yield null;
    return null;
  }

  /** A group begins, as about of the session describes it. Whether it is read again in another way, and nothing of it is to be shown. */
  async redirects(state, about) {
    const { index, session } = this;
    const group = (state.index = index.at(about.offset));
    if (about.whole || session.indexState !== 1 || group < 0 || this.#recalled(state).has(group)) return false;
    // A repetition of its lost configuration may follow it.
    this.#recalled(state).add(group);
    if (!(await index.find(() => session.hasConfiguration(group, about.configuration), state.signal))) return false;
    state.next = group;
    return true;
  }
  /** Groups whose configuration comes from a repetition that follows them. */
  #recalled(state) {
    return (state.recalled ??= new Set());
  }

  /** Notes the rung of a group that is shown. configuration: undefined: that of the group before; null: it is lost. */
  begin(state, configuration) {
    if (configuration) this.choice.learn(configuration);
    [state.rung, state.reason] = [this.choice.local, "chosen"];
  }
  /** Tracks of a rung; null: all that come. */
  tracksOf(rung) {
    return rung === null ? null : this.choice.rungs[rung].tracks;
  }
  /** The environment of a track that is valid for a group, {track, data}; null: none. */
  environment(group, track, signal) {
    return this.index.find(() => this.session.findEnvironment(group, track), signal);
  }

  /** A frame has come: the current group up to its end. state.group: {end}. span: {start, end}. */
  arrived() {}
  /** [{start, end}] in ticks: times that can be played without the network. */
  bufferedTimes() {
    return this.buffered.times(this.wishes.selection());
  }
  /** A group is damaged, and the byte at an offset, perhaps in transit: they are fetched again when they are needed again. */
  forget(group, damaged) {
    for (const offset of [damaged, this.index.groups?.[group]?.offset])
      if (Number.isInteger(offset)) this.source.forget(offset);
  }
  /** Everything that is fetched ahead ends. */
  stop() {}
}
