// @fvv/decoder: decodes free-viewpoint video from fvv streams. index.d.ts documents the types.

import { camerasFor } from "./camera.js";
import { Decoder, FvvEvent } from "./decoder.js";
import { FvvError } from "./errors.js";

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

function describe(source) {
  const base = globalThis.document?.baseURI ?? globalThis.location?.href;
  if (source === undefined || source === null) return { source: { pull: true }, feed: createFeed() };
  if (typeof source === "string" || source instanceof URL) return describe({ url: source });
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return { source: { bytes: toBytes(source) } };
  if (typeof Blob === "function" && source instanceof Blob) return { source: { blob: source } };
  if (source.getReader || source[Symbol.asyncIterator]) return { source: { pull: true }, feed: feedOf(source) };
  if (source.url) {
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
  throw new FvvError({ code: "argument", message: "source: expected a URL, a Blob, bytes, or a stream of bytes" });
}

export async function createDecoder(options = {}) {
  const { worker, limits = {}, normals = true, visibility = true, queue = 4, signal } = options;
  const { tracks = null, look = null, quality = "auto", videoFallback, audioFallback } = options;
  for (const [name, fallback] of Object.entries({ videoFallback, audioFallback }))
    if (fallback !== undefined && typeof fallback !== "function")
      throw new FvvError({ code: "argument", message: `${name}: expected a function that imports the package` });
  if (limits.cacheBytes !== undefined && !(limits.cacheBytes >= 0))
    throw new FvvError({ code: "argument", message: "limits.cacheBytes: expected a number of bytes; 0 keeps nothing" });
  const audio = options.audio ?? false;
  if (![false, "samples", "packets"].includes(audio))
    throw new FvvError({ code: "argument", message: 'audio: expected false, "samples" or "packets"' });
  const video = options.video ?? (typeof VideoDecoder === "function" || videoFallback ? "pictures" : "samples");
  return Decoder.create({
    worker,
    ...describe(options.source),
    limits,
    normals,
    visibility,
    video,
    audio,
    videoFallback,
    audioFallback,
    queue,
    tracks,
    look,
    quality,
    signal,
  });
}
