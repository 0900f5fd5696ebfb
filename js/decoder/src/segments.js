// A stream as a folder (spec/segments.schema.json): a manifest, the configuration, and a file for each group.

import { FILE_HEADER_SIZE, beginsWithFileHeader, chunkPayload, crc32c } from "./chunks.js";
import { FvvError } from "./errors.js";

const invalid = (url, message) => new FvvError({ code: "invalid", message: `${url}: ${message}` });
const isCount = (n) => Number.isSafeInteger(n) && n >= 0;
const NAME = /^[0-9A-Za-z][0-9A-Za-z._-]*$/;
const TICKS = /^-?\d{1,19}$/;

const CRC = /^[0-9a-f]{8}$/;

function checkFile(url, { file, bytes, crc32c: crc } = {}, what) {
  if (typeof file !== "string" || !NAME.test(file) || !isCount(bytes) || !CRC.test(crc))
    throw invalid(url, `${what} lacks its file name, size or CRC`);
}

function backgroundsOf(url, { backgrounds = [] }) {
  if (!Array.isArray(backgrounds)) throw invalid(url, "backgrounds is not a list");
  for (const one of backgrounds) {
    checkFile(url, one ?? {}, "a background");
    if (!isCount(one.track)) throw invalid(url, "a background has no track");
  }
  return backgrounds;
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

export class Segments {
  #url;
  #init;
  #cache;
  #configuration = null;
  #backgrounds = [];
  #head = null; // bytes of the configuration
  #current = null; // the group that was yielded last
  inSections = true;
  requests = 0;
  bytesRead = 0;
  groups = [];

  /** cache: for files of groups. */
  static async open({ url, init = {} }, cache) {
    const segments = new Segments(url, init, cache);
    const text = new TextDecoder().decode(await segments.#load(url));
    let manifest;
    try {
      manifest = JSON.parse(text);
    } catch {
      throw invalid(url, "not JSON");
    }
    segments.groups = groupsOf(url, manifest);
    segments.#configuration = manifest.configuration;
    segments.#backgrounds = backgroundsOf(url, manifest);
    return segments;
  }

  constructor(url, init, cache) {
    this.#url = url;
    this.#init = init;
    this.#cache = cache;
  }

  async #load(url, size, signal) {
    this.requests++;
    const response = await fetch(url, { ...this.#init, signal });
    if (!response.ok) throw new FvvError({ code: "io", message: `${url}: HTTP status ${response.status}` });
    const bytes = new Uint8Array(await response.arrayBuffer());
    this.bytesRead += bytes.length;
    if (size !== undefined && bytes.length !== size)
      throw new FvvError({
        code: "changed",
        message: `${url}: ${bytes.length} bytes, expected ${size} by the manifest`,
      });
    return bytes;
  }
  async #file({ file, bytes: size, crc32c: expected }, signal) {
    const url = new URL(file, this.#url).href;
    const bytes = await this.#load(url, size, signal);
    const found = crc32c(bytes).toString(16).padStart(8, "0");
    if (found !== expected)
      throw new FvvError({
        code: "damaged",
        message: `${url}: CRC-32C is ${found}, expected ${expected} by the manifest`,
      });
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
  async background(track, signal) {
    const entry = this.#backgrounds.find((one) => one.track === track);
    if (!entry) return null;
    const bytes = await this.#file(entry, signal);
    const data = chunkPayload(bytes);
    if (!data) throw invalid(this.#url, `${entry.file} contains no complete chunk`);
    return { track, data };
  }

  async #begin(signal) {
    this.#head ??= await this.#file(this.#configuration, signal);
    if (!beginsWithFileHeader(this.#head))
      throw invalid(this.#url, "the configuration does not begin as an fvv stream");
    return [{ header: this.#head.subarray(0, FILE_HEADER_SIZE) }, this.#head.subarray(FILE_HEADER_SIZE)];
  }

  /** From a group on; the next one is fetched while one is decoded. */
  async *stream(first, signal) {
    const { groups } = this;
    const ask = (i) => {
      const file = i < groups.length ? this.#group(groups[i], signal) : null;
      file?.catch(() => {});
      return file;
    };
    let coming = ask(first);
    let inSection = false;
    for (let i = first; i < groups.length; i++) {
      const file = coming;
      let bytes;
      try {
        if (!inSection) yield* await this.#begin(signal);
        inSection = true;
        bytes = await file;
      } catch (error) {
        if (signal?.aborted) return;
        if (!inSection) throw error;
        const damaged = error.code === "damaged" || error.code === "changed";
        // A file with wrong bytes is reported as damage; the gap is reported either way.
        if (damaged) yield { damage: Object.assign(error, { fatal: false }) };
        yield {
          lost: { error: FvvError.warning(damaged ? error.code : "io", `a group is missing: ${error.message}`) },
        };
        inSection = false;
      }
      coming = ask(i + 1);
      this.#current = groups[i];
      if (bytes) yield bytes;
    }
  }

  divide(offsets) {
    this.#cache.divide(offsets);
  }
  holds(from, end) {
    return this.#cache.coveredUntil(from, end) >= end;
  }
  /** The file that is read now has a good CRC but violates the rules. */
  forget() {
    if (this.#current) this.#cache.drop(this.#current.offset);
  }
  close() {
    this.#cache.clear();
  }
}
