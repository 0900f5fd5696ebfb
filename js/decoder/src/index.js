// @fvv/decoder: decodes free-viewpoint video from fvv streams. index.d.ts documents the types.

import { camerasFor } from "./camera.js";
import { Decoder, FvvEvent } from "./decoder.js";
import { FvvError } from "./errors.js";
import { POLICY } from "./sources/network.js";

export { FvvError, FvvEvent, camerasFor };

/** A WritableStream and a feed that takes one piece at a time: writers wait for it. */
function createFeed() {
  const { readable, writable } = new TransformStream(undefined, undefined, { highWaterMark: 0 });
  return { ...feedOf(readable), writable };
}

function feedOf(stream) {
  const iterator = stream.getReader ? null : stream[Symbol.asyncIterator]();
  const reader = stream.getReader?.();
  return {
    async pull() {
      const { done, value } = reader ? await reader.read() : await iterator.next();
      return done ? null : toBytes(value);
    },
    cancel() {
      const cancelled = reader ? reader.cancel() : iterator.return?.();
      cancelled?.catch?.(() => {});
    },
  };
}

function toBytes(value) {
  if (value instanceof ArrayBuffer) return new Uint8Array(value);
  if (ArrayBuffer.isView(value)) return new Uint8Array(value.buffer, value.byteOffset, value.byteLength);
  throw new FvvError({ code: "argument", message: "source: expected a stream of bytes" });
}

/** A source that is text is a URL: a path is one only on a page, and fetch has no files. */
function addressOf(address, base) {
  let url = null;
  try {
    url = new URL(address, base);
  } catch {
    // Explained below.
  }
  const isFile = url?.protocol === "file:" || /^[a-z]:$/i.test(url?.protocol ?? "");
  if (url && !isFile) return url;
  const advice = base
    ? "pages cannot fetch files: serve the folder, for instance with fvvserve --root, or pass a Blob"
    : 'in Node, pass the content of a file: await openAsBlob("clip.fvv") or await readFile("clip.fvv"), of node:fs and node:fs/promises';
  throw new FvvError({
    code: "argument",
    message: `source: expected a URL of http: or https:, found ${address}; ${advice}`,
  });
}

const SOURCES = "a URL, a Blob, bytes, or a stream of bytes";
const SOURCE_FIELDS = "url headers credentials seekable segments protocols reconnect WebSocket";

function describe(source) {
  const base = globalThis.document?.baseURI ?? globalThis.location?.href;
  if (source === undefined || source === null) return { source: { pull: true }, feed: createFeed() };
  if (typeof source === "string" || source instanceof URL) return describe({ url: source });
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return { source: { bytes: toBytes(source) } };
  if (typeof Blob === "function" && source instanceof Blob) return { source: { blob: source } };
  if (source.getReader || source[Symbol.asyncIterator]) return { source: { pull: true }, feed: feedOf(source) };
  if (source.url) {
    checkNames("source", source, SOURCE_FIELDS);
    const { headers, credentials, seekable, protocols, reconnect, WebSocket } = source;
    const { href: url, protocol, pathname } = addressOf(source.url, base);
    const init = { headers, credentials };
    if (protocol === "ws:" || protocol === "wss:") {
      // Constructors can't be sent to workers.
      const here = WebSocket && { worker: false };
      return { source: { live: { url, protocols, reconnect, WebSocket } }, ...here };
    }
    if (source.segments ?? pathname.endsWith(".json")) return { source: { segments: { url, init } } };
    return { source: { url, seekable, init } };
  }
  throw new FvvError({ code: "argument", message: `source: expected ${SOURCES}` });
}

/** Options and values of 0.1 by those of today. They remain for one version. */
const RENAMED = { quality: "rung", audio: "sound", audioFallback: "soundFallback" };
const RENAMED_VALUES = {
  video: { pictures: "decoded", samples: "encoded" },
  sound: { samples: "decoded", packets: "encoded" },
};

function renamed(options) {
  const given = { ...options };
  const warn = (former, now) => console.warn(`@fvv/decoder: the option ${former} is now ${now}`);
  for (const [former, now] of Object.entries(RENAMED))
    if (given[former] !== undefined) {
      warn(former, now);
      given[now] ??= given[former];
      delete given[former];
    }
  for (const [option, values] of Object.entries(RENAMED_VALUES)) {
    const now = values[given[option]] ?? null;
    if (now === null) continue;
    warn(`${option}: "${given[option]}"`, `"${now}"`);
    given[option] = now;
  }
  return given;
}

const OPTIONS =
  "source worker limits normals visibility queue signal tracks look rung video videoFallback sound soundFallback network onOutage " +
  "renewAddress";
/** A name that is mistyped would otherwise be a decoder that waits endlessly. */
function checkNames(what, given, expected) {
  const known = expected.split(" ");
  const found = Object.keys(given).find((name) => !known.includes(name));
  if (found === undefined) return;
  throw new FvvError({ code: "argument", message: `${what}: expected ${known.join(", ")}, found ${found}` });
}

function checkMode(name, mode, expected) {
  if (expected.includes(mode)) return;
  const message = `${name}: expected ${expected.map((one) => JSON.stringify(one)).join(" or ")}, found ${mode}`;
  throw new FvvError({ code: "argument", message });
}

function checkPolicy(network) {
  for (const [name, value] of Object.entries(network)) {
    const known = Object.keys(POLICY);
    if (!known.includes(name))
      throw new FvvError({ code: "argument", message: `network: expected ${known.join(", ")}, found ${name}` });
    if (!(value >= 0))
      throw new FvvError({ code: "argument", message: `network.${name}: expected milliseconds, found ${value}` });
  }
}

export async function createDecoder(given = {}) {
  const options = renamed(given);
  checkNames("options", options, OPTIONS);
  if ("source" in options && (options.source ?? null) === null)
    throw new FvvError({
      code: "argument",
      message: `source: expected ${SOURCES}, found ${options.source}; leave it out to write bytes to decoder.writable`,
    });
  const { worker, limits = {}, normals = true, visibility = true, queue = 4, signal } = options;
  const { tracks = null, look = null, rung = "auto", videoFallback, soundFallback } = options;
  for (const [name, fallback] of Object.entries({ videoFallback, soundFallback }))
    if (fallback !== undefined && typeof fallback !== "function")
      throw new FvvError({ code: "argument", message: `${name}: expected a function that imports the package` });
  const { network = {}, onOutage, renewAddress } = options;
  for (const [name, act] of Object.entries({ onOutage, renewAddress }))
    if (act !== undefined && typeof act !== "function")
      throw new FvvError({ code: "argument", message: `${name}: expected a function` });
  checkPolicy(network);
  if (limits.cacheBytes !== undefined && !(limits.cacheBytes >= 0))
    throw new FvvError({ code: "argument", message: "limits.cacheBytes: expected a number of bytes; 0 keeps nothing" });
  const sound = options.sound ?? false;
  const video = options.video ?? (typeof VideoDecoder === "function" || videoFallback ? "decoded" : "encoded");
  checkMode("sound", sound, [false, "decoded", "encoded"]);
  checkMode("video", video, ["decoded", "encoded"]);
  return Decoder.create({
    worker,
    ...describe(options.source),
    limits,
    normals,
    visibility,
    video,
    sound,
    videoFallback,
    soundFallback,
    queue,
    tracks,
    look,
    rung,
    network,
    onOutage,
    renewAddress,
    signal,
  });
}
