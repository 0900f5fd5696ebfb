// A stream as a folder (spec/segments.schema.json): a manifest, the configuration, and a file for each group.

import { FvvError } from "./errors.js";
import { FILE_HEADER_SIZE, beginsRun, loss } from "./runs.js";

const bad = (url, message) => new FvvError({ code: "invalid", message: `${url}: ${message}` });
const isCount = (n) => Number.isSafeInteger(n) && n >= 0;
const NAME = /^[0-9A-Za-z][0-9A-Za-z._-]*$/;
const TICKS = /^-?\d{1,19}$/;

function checkFile(url, { file, bytes } = {}, what) {
  if (typeof file !== "string" || !NAME.test(file) || !isCount(bytes)) throw bad(url, `${what} names no file`);
}

/** What playback wants to know of groups. */
function groupsOf(url, manifest) {
  if (manifest?.fvv_segments !== 1) throw bad(url, "this is no manifest of segments, or one of another version");
  checkFile(url, manifest.configuration, "configuration");
  if (!Array.isArray(manifest.groups) || !manifest.groups.length) throw bad(url, "there are no groups");
  return manifest.groups.map((group, i) => {
    const { file, bytes, sequence, start, end, frames } = group ?? {};
    checkFile(url, group, `group ${i}`);
    if (!isCount(sequence) || !isCount(frames) || !TICKS.test(start) || !TICKS.test(end))
      throw bad(url, `group ${i} lacks its sequence number, times or frames`);
    return { file, size: bytes, sequence, start: BigInt(start), end: BigInt(end), frameCount: frames, intact: true };
  });
}

export class Segments {
  static async open({ url, init = {} }) {
    const segments = new Segments();
    Object.assign(segments, { url, init, inRuns: true, requests: 0, bytesRead: 0, head: null });
    const text = new TextDecoder().decode(await segments.#load(url));
    let manifest;
    try {
      manifest = JSON.parse(text);
    } catch {
      throw bad(url, "this is no JSON");
    }
    segments.groups = groupsOf(url, manifest);
    segments.configuration = manifest.configuration;
    return segments;
  }

  async #load(url, size, signal) {
    this.requests++;
    const response = await fetch(url, { ...this.init, signal });
    if (!response.ok) throw new FvvError({ code: "io", message: `${url}: HTTP status ${response.status}` });
    const bytes = new Uint8Array(await response.arrayBuffer());
    this.bytesRead += bytes.length;
    if (size !== undefined && bytes.length !== size)
      throw new FvvError({ code: "changed", message: `${url}: ${bytes.length} bytes, the manifest says ${size}` });
    return bytes;
  }
  #file({ file, bytes, size }, signal) {
    return this.#load(new URL(file, this.url).href, bytes ?? size, signal);
  }

  async #begin(signal) {
    this.head ??= await this.#file(this.configuration, signal);
    if (!beginsRun(this.head)) throw bad(this.url, "the configuration is no fvv stream");
    return [{ header: this.head.subarray(0, FILE_HEADER_SIZE) }, this.head.subarray(FILE_HEADER_SIZE)];
  }

  /** From a group on; the next one is on its way while one is decoded. */
  async *stream(first, signal) {
    const { groups } = this;
    const ask = (i) => {
      const file = i < groups.length ? this.#file(groups[i], signal) : null;
      file?.catch(() => {});
      return file;
    };
    let coming = ask(first);
    let running = false;
    for (let i = first; i < groups.length; i++) {
      const file = coming;
      let bytes;
      try {
        if (!running) yield* await this.#begin(signal);
        running = true;
        bytes = await file;
      } catch (error) {
        if (signal?.aborted) return;
        if (!running) throw error;
        yield { lost: { error: loss(`a group is missing: ${error.message}`) } };
        running = false;
      }
      coming = ask(i + 1);
      if (bytes) yield bytes;
    }
  }
}
