// @fvv/decoder: free-viewpoint video out of fvv streams. index.d.ts is its documentation in types.

import { Decoder, FvvEvent } from "./decoder.js";
import { FvvError } from "./errors.js";
import { camerasFor } from "./viewpoint.js";

export { FvvError, FvvEvent, camerasFor };

/** A WritableStream and what takes from it, a piece at a time: who writes waits. */
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
  throw new FvvError({ code: "argument", message: "a stream has to yield bytes" });
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
    const { href: url, protocol, pathname } = new URL(source.url, base);
    const init = { headers, credentials };
    if (protocol === "ws:" || protocol === "wss:") {
      // Constructors can't be sent to workers.
      const here = WebSocket && { worker: false };
      return { source: { live: { url, protocols, reconnect, WebSocket } }, ...here };
    }
    if (source.segments ?? pathname.endsWith(".json")) return { source: { segments: { url, init } } };
    return { source: { url, seekable, init } };
  }
  throw new FvvError({ code: "argument", message: "a source is a URL, a Blob, bytes, or a stream of them" });
}

export async function createDecoder(options = {}) {
  const { worker, limits = {}, normals = true, visibility = true, shares = false, queue = 4, signal } = options;
  const { tracks = null, look = null, videoFallback } = options;
  if (videoFallback !== undefined && typeof videoFallback !== "function")
    throw new FvvError({ code: "argument", message: "videoFallback is a function that imports the package" });
  if (limits.cacheBytes !== undefined && !(limits.cacheBytes >= 0))
    throw new FvvError({ code: "argument", message: "limits.cacheBytes is a number of bytes; 0 keeps nothing" });
  const video = options.video ?? (typeof VideoDecoder === "function" || videoFallback ? "pictures" : "samples");
  return Decoder.create({
    worker,
    ...describe(options.source),
    limits,
    normals,
    visibility,
    shares,
    video,
    videoFallback,
    queue,
    tracks,
    look,
    signal,
  });
}
