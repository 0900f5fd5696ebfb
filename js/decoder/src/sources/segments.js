// A stream as a folder (spec/segments.schema.json): a manifest, the configuration, and a file for each group.

import { GroupPrefetcher } from "./group_prefetcher.js";
import { FILE_HEADER_SIZE, beginsWithFileHeader, chunkPayload, crc32c } from "../chunks.js";
import { FvvError } from "../errors.js";
import { joined } from "../joined.js";
import { asTransient, failed, isTransient, Network } from "./network.js";
import { SectionSource } from "./types.js";

const invalid = (url, message) => new FvvError({ code: "invalid", message: `${url}: ${message}` });
const isCount = (n) => Number.isSafeInteger(n) && n >= 0;
const NAME = /^(?:[0-9A-Za-z][0-9A-Za-z._-]*\/)?[0-9A-Za-z][0-9A-Za-z._-]*$/;
const TICKS = /^-?\d{1,19}$/;

const CRC = /^[0-9a-f]{8}$/;

function checkFile(url, { file, bytes, crc32c: crc } = {}, what) {
  if (typeof file !== "string" || !NAME.test(file) || !isCount(bytes) || !CRC.test(crc))
    throw invalid(url, `${what} lacks its file name, size or CRC`);
}

/** backgrounds: the former name of environments. */
function environmentsOf(url, { environments, backgrounds = [] }) {
  const listed = environments ?? backgrounds;
  if (!Array.isArray(listed)) throw invalid(url, "environments is not a list");
  for (const one of listed) {
    checkFile(url, one ?? {}, "an environment");
    if (!isCount(one.track)) throw invalid(url, "an environment has no track");
  }
  return listed;
}

/** The groups as playback expects them, with their files. */
function groupsOf(url, manifest) {
  if (manifest?.fvv_segments !== 1) throw invalid(url, "not a manifest of segments, or of an unknown version");
  checkFile(url, manifest.configuration, "configuration");
  if (!Array.isArray(manifest.groups) || !manifest.groups.length) throw invalid(url, "there are no groups");
  let offset = manifest.configuration.bytes;
  return manifest.groups.map((group, i) => {
    const { file, bytes, crc32c: crc, sequence, start, end, frames } = group ?? {};
    checkFile(url, group ?? {}, `group ${i}`);
    if (!isCount(sequence) || !isCount(frames) || !TICKS.test(start) || !TICKS.test(end))
      throw invalid(url, `group ${i} lacks its sequence number, times or frames`);
    const times = { start: BigInt(start), end: BigInt(end) };
    const place = { offset, size: bytes, configurationOffset: 0, configurationSize: 0 };
    offset += bytes;
    return { file, bytes, crc32c: crc, ...place, sequence, ...times, frameCount: frames, intact: true, endSize: 0 };
  });
}

/** The rungs as rungsOf returns them, with their files; null: there is no ladder. */
function rungsOf(url, { rungs, groups }) {
  if (rungs === undefined) return null;
  if (!Array.isArray(rungs) || !rungs.length) throw invalid(url, "rungs is not a list of rungs");
  return rungs.map((rung, i) => {
    const { configuration, groups: files, bit_rate: bitRate = 0, size = 0, scale = null, tracks = [] } = rung ?? {};
    checkFile(url, configuration, `the configuration of rung ${i}`);
    if (!Array.isArray(files) || files.length !== groups.length)
      throw invalid(url, `rung ${i} does not have ${groups.length} groups`);
    files.forEach((file, k) => checkFile(url, file ?? {}, `group ${k} of rung ${i}`));
    if (!isCount(bitRate) || !isCount(size) || !(scale === null || scale > 0) || !Array.isArray(tracks))
      throw invalid(url, `rung ${i} has no sensible rate, size, scale or tracks`);
    return { rung: i, bitRate, size, scale, tracks, configuration, files };
  });
}

/** Each file has a place in the cache; those of the best rung have that of their group. */
function placeFiles(rungs, groups) {
  let end = groups.at(-1).offset + groups.at(-1).size;
  for (const { rung, files } of rungs)
    for (const [i, file] of files.entries()) {
      file.offset = rung ? end : groups[i].offset;
      if (rung) end += file.bytes;
    }
}

/** Seconds for each tick. */
function tickOf(url, { time_base: base }) {
  const [numerator, denominator] = Array.isArray(base) ? base : [];
  if (!(numerator > 0) || !(denominator > 0)) throw invalid(url, "time_base is not two positive numbers");
  return numerator / denominator;
}

/** A file with wrong bytes is reported as damage; the gap is reported either way. Throws what is no loss of this file alone. */
function* lossOf(error) {
  if (isTransient(error)) throw error;
  const damaged = error.code === "damaged" || error.code === "changed";
  if (damaged) yield { damage: Object.assign(error, { fatal: false }) };
  yield { lost: { error: FvvError.warning(damaged ? error.code : "io", `a group is missing: ${error.message}`) } };
}

export class SegmentSource extends SectionSource {
  #url;
  #network;
  #cache;
  #manifestCrc = null;
  #configuration = null;
  #environments = [];
  #heads = new Map(); // bytes of configurations, by file
  #current = null; // the group that was yielded last
  #files = null; // of rungs: {rung, bitRate, ..., configuration, files}; null: there is no ladder
  #tick; // seconds
  #follows = null;
  #prefetcher = null;
  groups = [];

  /** cache: for files of groups. */
  static async open({ url, init }, { cache, ...access }) {
    const segments = new SegmentSource(url, new Network(init, access), cache);
    const bytes = await segments.#loadManifest();
    segments.#manifestCrc = crc32c(bytes);
    let manifest;
    try {
      manifest = JSON.parse(new TextDecoder().decode(bytes));
    } catch {
      throw invalid(url, "not JSON");
    }
    segments.groups = groupsOf(url, manifest);
    segments.#configuration = manifest.configuration;
    segments.#environments = environmentsOf(url, manifest);
    segments.#files = rungsOf(url, manifest);
    if (segments.#files) {
      segments.#tick = tickOf(url, manifest);
      placeFiles(segments.#files, segments.groups);
    }
    segments.#network.opened();
    return segments;
  }

  constructor(url, network, cache) {
    super();
    this.#url = url;
    this.#network = network;
    this.#cache = cache;
  }
  get requests() {
    return this.#network.requests;
  }
  get bytesRead() {
    return this.#network.bytesRead;
  }

  /** Yields the sizes of pieces, and returns all bytes. size: what is expected. From its beginning again when it breaks off. */
  async *#receive(url, signal, size = 0, more = {}) {
    const outage = this.#network.outage(url, signal);
    let wasShort = false;
    for (;;) {
      const pieces = [];
      try {
        const reply = await this.#network.request(url, { ...more, signal, outage });
        if (!reply.ok) throw failed(url, reply);
        for await (const piece of reply.pieces()) {
          pieces.push(piece);
          yield piece.length;
        }
        const bytes = joined(pieces);
        // Once: a cache or a proxy has cut it off, or the file is another one.
        if (bytes.length < size && !wasShort) {
          wasShort = true;
          throw asTransient(new FvvError({ code: "io", message: `${url}: ${bytes.length} bytes of ${size}` }));
        }
        outage.progress();
        return bytes;
      } catch (error) {
        await outage.wait(error);
      }
    }
  }
  async #load(url, signal, size, more) {
    const pieces = this.#receive(url, signal, size, more);
    for (;;) {
      const { done, value } = await pieces.next();
      if (done) return value;
    }
  }
  /** As the host has it now: a manifest that a browser has kept may be of a folder that was replaced since. */
  async #loadManifest(signal) {
    return this.#load(this.#url, signal, 0, { cache: "no-cache" });
  }
  async #isReplaced(signal) {
    try {
      return crc32c(await this.#loadManifest(signal)) !== this.#manifestCrc;
    } catch (error) {
      if (signal?.aborted || isTransient(error)) throw error;
      return false; // it is missing, too
    }
  }
  /** A file of a folder that was replaced is not lost: the folder is opened again. */
  async *#lossOf(error, signal) {
    if (!isTransient(error) && (await this.#isReplaced(signal)))
      throw new FvvError({ code: "changed", message: `${this.#url} changed while it was read (${error.message})` });
    yield* lossOf(error);
  }
  /** Throws unless these are the bytes that the manifest lists. */
  #check(url, bytes, { bytes: size, crc32c: expected }) {
    if (bytes.length !== size) {
      const message = `${url}: ${bytes.length} bytes, expected ${size} by the manifest`;
      throw new FvvError({ code: "changed", message });
    }
    const found = crc32c(bytes).toString(16).padStart(8, "0");
    if (found === expected) return;
    const message = `${url}: CRC-32C is ${found}, expected ${expected} by the manifest`;
    throw new FvvError({ code: "damaged", message });
  }
  async #file(entry, signal) {
    const url = new URL(entry.file, this.#url).href;
    const bytes = await this.#load(url, signal, entry.bytes);
    this.#check(url, bytes, entry);
    return bytes;
  }

  async #group(group, signal) {
    const { offset, size } = group;
    const kept = this.#cache.take(offset, offset + size);
    // A file is put there in one piece.
    if (kept?.length === size) {
      this.#cache.hits++;
      return kept;
    }
    const bytes = await this.#file(group, signal);
    this.#cache.put(offset, bytes);
    return bytes;
  }

  /** The environment of a track, {track, data}; null: the manifest lists none. */
  async environment(track, signal) {
    const entry = this.#environments.find((one) => one.track === track);
    if (!entry) return null;
    const bytes = await this.#file(entry, signal);
    const data = chunkPayload(bytes);
    if (!data) throw invalid(this.#url, `${entry.file} contains no complete chunk`);
    return { track, data };
  }

  /** Header and block of a configuration. */
  async #begin(entry, signal) {
    const head = this.#heads.get(entry.file) ?? (await this.#file(entry, signal));
    this.#heads.set(entry.file, head);
    if (!beginsWithFileHeader(head)) throw invalid(this.#url, "the configuration does not begin as an fvv stream");
    return [{ header: head.subarray(0, FILE_HEADER_SIZE) }, head.subarray(FILE_HEADER_SIZE)];
  }

  get rungs() {
    return (
      this.#files?.map(({ rung, bitRate, size, scale, tracks }) => ({ rung, bitRate, size, scale, tracks })) ?? null
    );
  }
  follow(choices, position) {
    if (this.#files) this.#follows = { choices, position };
  }
  renew() {
    this.#prefetcher?.renew();
  }
  get buffer() {
    return this.#prefetcher?.buffer ?? null;
  }

  /** What GroupPrefetcher fetches: of each rung a file for each group. */
  get #fetcher() {
    const bytesRead = () => this.bytesRead;
    return {
      get bytesRead() {
        return bytesRead();
      },
      plans: async (i) => this.#files.map(({ rung, files }) => ({ rung, file: files[i], size: files[i].bytes })),
      fetch: (pending, signal) => this.#pieces(pending, signal),
    };
  }
  /** Yields the sizes of pieces of a file; in the end the group has its bytes. */
  async *#pieces(pending, signal) {
    const { file, bytes: size, offset } = pending.file;
    const kept = this.#cache.take(offset, offset + size);
    if (kept?.length === size) {
      this.#cache.hits++;
      pending.bytes = kept;
      yield size;
      return;
    }
    const url = new URL(file, this.#url).href;
    pending.bytes = yield* this.#receive(url, signal, size);
    this.#check(url, pending.bytes, pending.file);
    this.#cache.put(offset, pending.bytes);
  }

  /** From a group on, each in the rung that was chosen when it was fetched. */
  async *#rungStream(first, signal) {
    const { groups } = this;
    const { choices, position } = this.#follows;
    const seconds = (ticks) => Number(ticks) * this.#tick;
    const prefetcher = (this.#prefetcher = new GroupPrefetcher(this.#fetcher, groups, choices(seconds), position));
    prefetcher.start(first, signal);
    let known = null;
    for (let i = first; i < groups.length; i++) {
      const pending = await prefetcher.take(i);
      if (!pending || signal?.aborted) return;
      try {
        for await (const _ of prefetcher.arrivals(pending));
        const [header, block] = await this.#begin(this.#files[pending.rung].configuration, signal);
        if (known === null) yield header;
        yield { rung: pending.rung, reason: pending.reason };
        if (known !== pending.rung) yield block;
        known = pending.rung;
      } catch (error) {
        if (signal?.aborted) return;
        yield* this.#lossOf(error, signal);
        known = null;
        continue;
      }
      this.#current = null;
      yield pending.bytes;
    }
    prefetcher.stop();
  }

  /** From a group on; the next one is fetched while one is decoded. */
  async *stream(first, signal) {
    if (this.#follows) {
      yield* this.#rungStream(first, signal);
      return;
    }
    const { groups } = this;
    const ask = (i) => {
      const file = i < groups.length ? this.#group(groups[i], signal) : null;
      file?.catch(() => {});
      return file;
    };
    let pending = ask(first);
    let inSection = false;
    for (let i = first; i < groups.length; i++) {
      const file = pending;
      let bytes;
      try {
        if (!inSection) yield* await this.#begin(this.#configuration, signal);
        inSection = true;
        bytes = await file;
      } catch (error) {
        if (signal?.aborted) return;
        if (!inSection) throw error;
        yield* this.#lossOf(error, signal);
        inSection = false;
      }
      pending = ask(i + 1);
      this.#current = groups[i];
      if (bytes) yield bytes;
    }
  }

  divide(offsets) {
    const others = this.#files?.slice(1).flatMap(({ files }) => files.map(({ offset }) => offset)) ?? [];
    this.#cache.divide([...offsets, ...others]);
  }
  holds(from, end) {
    return this.#cache.coveredUntil(from, end) >= end;
  }
  /** The file that is read now has a good CRC but violates the rules. */
  forget() {
    if (this.#current) this.#cache.drop(this.#current.offset);
  }
  close() {
    this.#prefetcher?.stop();
    this.#network.close();
    this.#cache.clear();
  }
}
