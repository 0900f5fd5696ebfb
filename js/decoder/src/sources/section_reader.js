// The groups of a SectionSource, which has chosen their rungs and knows what is lost.

import { FvvError } from "../errors.js";
import { GroupReader } from "./group_reader.js";

export class SectionReader extends GroupReader {
  async open(session) {
    const problem = await super.open(session);
    this.source.follow((seconds) => this.choice.asked(seconds), this.wishes.taken);
    return problem;
  }
  async peek() {
    return null;
  }
  renewRung() {
    this.source.renew();
  }

  async *read(state, first) {
    let inSection = false;
    // A section may end anywhere: an incomplete last frame is not damage.
    const end = function* () {
      if (!inSection) return;
      this.session.finish();
      state.quiet = true;
      yield null;
      state.quiet = state.ended = inSection = false;
    }.bind(this);
    for await (const item of this.source.stream(first, state.signal)) {
      if (item instanceof Uint8Array) {
        yield* this.#push(item);
      } else if (item.rung !== undefined) {
        [state.rung, state.reason] = [item.rung, item.reason];
      } else if (item.rungs !== undefined) {
        yield item;
      } else {
        yield* end();
        yield item;
        if (!item.header) continue;
        this.session.join();
        inSection = true;
        yield* this.#push(item.header);
      }
      if (state.ended) break;
    }
    yield* end();
  }
  *#push(bytes) {
    for (const _ of this.session.push(bytes)) yield null;
  }

  async redirects(state, about) {
    state.index = this.index.numbered(about.sequence);
    return false;
  }
  begin(state, configuration) {
    if (!this.source.rungs) return super.begin(state, configuration);
    if (configuration === undefined) return;
    if (configuration) this.choice.learn(configuration);
    const named = this.source.rungOf(configuration?.tracks.map(({ id }) => id) ?? []);
    if (named) [state.rung, state.reason] = [named.rung, named.reason];
  }
  tracksOf(rung) {
    return this.source.rungs ? null : super.tracksOf(rung);
  }

  async environment(group, track, signal) {
    try {
      return await this.source.environment(track, signal);
    } catch (error) {
      this.wishes.warn(Object.assign(FvvError.from(error), { fatal: false }));
      return null;
    }
  }
}
