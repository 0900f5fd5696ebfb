// All access of this package to networks: every request and every WebSocket goes through a Network, which ends them when
// its source is closed. What is to be done about hosts that do not respond is decided here and nowhere else.

import { onAbort, reasonOf, unlessAborted } from "../abort.js";
import { FvvError } from "../errors.js";

/** The cost of a round trip of 40 ms at 8 Mbit/s: fewer bytes are fetched again rather than split over two requests. */
export const ROUND_TRIP_BYTES = 40000;
/** Concurrent requests; browsers allow six per host with HTTP/1.1. */
export const CONCURRENT = 6;

/** A response with its body, which is read by pieces or bytes, or dropped. */
class Reply {
  #response;
  #abort;
  #received;
  #release;

  /** abort: of the request. received(bytes): called as they come. release(): called when nothing more comes. */
  constructor(response, { abort, received, release }) {
    this.#response = response;
    this.#abort = abort;
    this.#received = received;
    this.#release = release;
  }
  get status() {
    return this.#response.status;
  }
  get ok() {
    return this.#response.ok;
  }
  get headers() {
    return this.#response.headers;
  }
  /** Yields the body as it comes. Throws the reason when the request is aborted. */
  async *pieces() {
    const reader = this.#response.body?.getReader();
    try {
      for (;;) {
        const { done, value } = reader ? await unlessAborted(reader.read(), this.#abort.signal) : { done: true };
        if (done) return;
        this.#received(value.length);
        yield value;
      }
    } finally {
      reader?.cancel().catch(() => {});
      this.#release();
    }
  }
  async bytes() {
    const pieces = [];
    for await (const piece of this.pieces()) pieces.push(piece);
    return joined(pieces);
  }
  /** The body is not wanted. */
  drop() {
    this.#abort.abort();
    this.#release();
  }
}

/** Of one source. */
export class Network {
  #init;
  #open = new Set(); // what to call to end what is under way
  #closed = null; // the reason
  /** Connections count, too. */
  requests = 0;
  bytesRead = 0;

  /** init: of all requests, as for fetch. signal: closes. */
  constructor(init = {}, signal = undefined) {
    this.#init = init;
    onAbort(signal, () => this.close(reasonOf(signal)));
  }

  #track(end) {
    if (this.#closed) end(this.#closed);
    else this.#open.add(end);
    return () => this.#open.delete(end);
  }

  /**
   * more: as for fetch, in addition. Once more if there is no response: a host may close a connection that was not used for some
   * seconds at the moment at which it is used again. Throws FvvError "io" if there is none again, and the reason of a signal.
   */
  async request(url, { signal, headers, ...more } = {}) {
    const abort = new AbortController();
    const untrack = this.#track((reason) => abort.abort(reason));
    const leave = onAbort(signal, () => abort.abort(reasonOf(signal)));
    const release = () => {
      untrack();
      leave();
    };
    const init = { ...this.#init, ...more, headers: { ...this.#init.headers, ...headers }, signal: abort.signal };
    this.requests++;
    try {
      const response = await unlessAborted(withRetry(url, init), abort.signal);
      return new Reply(response, { abort, release, received: (bytes) => (this.bytesRead += bytes) });
    } catch (error) {
      release();
      throw error;
    }
  }

  /** Returns {socket, opened}: a WebSocket, and the promise of its event "open". That throws FvvError "io". */
  connect(WebSocket, url, protocols) {
    const socket = new WebSocket(url, protocols);
    socket.binaryType = "arraybuffer";
    this.requests++;
    const opened = new Promise((resolve, reject) => {
      const untrack = this.#track((reason) => {
        reject(reason);
        socket.close();
      });
      const fail = () =>
        reject(new FvvError({ code: "io", message: `${url}: the WebSocket could not be opened, or failed` }));
      socket.addEventListener("open", resolve);
      socket.addEventListener("error", fail);
      socket.addEventListener("close", () => {
        untrack();
        fail();
      });
    });
    return { socket, opened };
  }

  /** Ends everything that is under way, and every later request. */
  close(reason = new FvvError({ code: "state", message: "the source was closed" })) {
    this.#closed ??= reason;
    for (const end of this.#open) end(this.#closed);
    this.#open.clear();
  }
}

/** One array of all pieces. */
export function joined(pieces) {
  const bytes = new Uint8Array(pieces.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const piece of pieces) {
    bytes.set(piece, at);
    at += piece.length;
  }
  return bytes;
}

async function withRetry(url, init) {
  try {
    return await fetch(url, init);
  } catch (error) {
    if (init.signal.aborted) throw error;
  }
  try {
    return await fetch(url, init);
  } catch (error) {
    if (init.signal.aborted) throw error;
    throw new FvvError({
      code: "io",
      message: `${url}: no response (${causeOf(error)}). ${adviceOn(url)}`,
      cause: error,
    });
  }
}

/** Node has the reason in the cause, browsers have none for scripts. */
const causeOf = ({ message, cause }) => cause?.code ?? cause?.message ?? message;

function adviceOn(url) {
  const page = globalThis.location;
  const { origin, protocol } = new URL(url);
  if (!page || origin === page.origin) return "Is the server running, and reachable from here?";
  if (page.protocol === "https:" && protocol === "http:") return "A page of https: cannot fetch from http:.";
  return (
    `Is the host reachable, and does it allow pages of ${page.origin} (CORS: Access-Control-Allow-Origin, and the request ` +
    "header Range in Access-Control-Allow-Headers)? The browser's console has details."
  );
}

const ADVICE = {
  401: "the host asks for credentials: pass { url, headers } or { url, credentials }",
  403: "the host refuses access: pass { url, headers } or { url, credentials }",
  404: "there is no such file: check the address, also its upper and lower case",
};

/** For a response that is not ok. */
export function failed(url, { status }) {
  const advice = ADVICE[status] ? `, ${ADVICE[status]}` : "";
  return new FvvError({ code: "io", message: `${url}: HTTP status ${status}${advice}` });
}

/** "the stream has no signature" as what the host sent in place of one. type: its Content-Type, or null. */
export function notAStream(url, type, error) {
  const kind = type?.split(";")[0].trim();
  const advice =
    kind === "text/html"
      ? "a page in place of the file, as dev servers send for files that they do not have: check the address"
      : "check that the address is that of an .fvv file, a manifest.json or a live stream";
  const message = `${url}: expected an fvv stream, found ${kind ? `Content-Type ${kind}` : "something else"}: ${advice}`;
  const explained = FvvError.fromPlain({ ...error.toPlain(), message: `${message} [FVV-1001]` });
  explained.cause = error;
  return explained;
}
