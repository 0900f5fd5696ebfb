// All access of this package to networks: every request and every WebSocket goes through a Network, which ends them when
// its source is closed. What is to be done about hosts that do not respond is decided here and nowhere else.

import { delay, onAbort, reasonOf, unlessAborted } from "../abort.js";
import { crc32c } from "../chunks.js";
import { FvvError } from "../errors.js";
import { joined } from "../joined.js";
import { Pace } from "./pace.js";

/** The cost of a round trip of 40 ms at 8 Mbit/s: fewer bytes are fetched again rather than split over two requests. */
export const ROUND_TRIP_BYTES = 40000;
/** Concurrent requests; browsers allow six per host with HTTP/1.1. */
export const CONCURRENT = 6;

/** The defaults of the decoder's option `network`, in milliseconds. */
export const POLICY = Object.freeze({
  /** Until a host has responded, or a WebSocket is open. */
  connectMs: 10000,
  /** From the response to the first byte of its body. */
  firstByteMs: 10000,
  /** Between two pieces of a body. */
  progressMs: 10000,
  /** A host that responded sooner lately, and of which nothing comes any more for so long or for four times as long as it took, is
   * asked again, then every longestMs; what comes first counts. */
  quickMs: 1500,
  /** A live connection without a message for so long gets a ping, and is lost if as much time passes again. */
  silenceMs: 10000,
  /** Any of these after the event "online": what was under way before it seldom goes on. */
  onlineMs: 1500,
  /** The wait before the second retry, which doubles up to longestMs; half of it is random. The first retry is immediate if
   * there was no response: a host may close a connection that was not used for some seconds as it is used again. */
  firstMs: 250,
  longestMs: 2500,
  /** A host that sends a longer Retry-After is not waited for. */
  retryAfterMaxMs: 120000,
  /** Without a byte for so long, the error is fatal; while the browser is offline the time does not run. */
  budgetMs: 60000,
  /** The same while a source is opened: an address may be wrong. */
  openBudgetMs: 5000,
});

/** Statuses after which the same request may succeed. */
const TRANSIENT = [408, 425, 429, 500, 502, 503, 504];
/** Statuses of an address, or of credentials, that have expired. */
const EXPIRED = [401, 403, 410];

/** Clients to which a host has named one time return within this time after it. */
const SPREAD_MS = 1000;

/** Timers with more milliseconds fire at once. */
export const LONGEST_TIMER = 2 ** 31 - 1;

const transient = new WeakMap(); // errors after which the same request may succeed -> {immediate, retryAfterMs}
/** Marks an error. */
export function asTransient(error, how = {}) {
  transient.set(error, how);
  return error;
}
/** Whether it is one of the network, and not of what the host has. */
export const isTransient = (error) => transient.has(error);

/** Calls act after some milliseconds, and at the latest onlineMs after an event "online". Returns a function that ends this. */
function expire(milliseconds, onlineMs, act) {
  const stop = new AbortController();
  const began = performance.now();
  const late = () => {
    stop.abort();
    act();
  };
  let timer = setTimeout(late, Math.min(milliseconds, LONGEST_TIMER));
  const hurry = () => {
    clearTimeout(timer);
    timer = setTimeout(late, Math.min(began + milliseconds - performance.now(), onlineMs));
  };
  globalThis.addEventListener?.("online", hurry, { signal: stop.signal });
  return () => {
    clearTimeout(timer);
    stop.abort();
  };
}

/** Rejects with late(milliseconds passed) if the promise has not settled in time, as of expire. */
async function within(promise, milliseconds, onlineMs, late) {
  let end;
  const began = performance.now();
  const expired = new Promise((_, reject) => {
    end = expire(milliseconds, onlineMs, () => reject(late(performance.now() - began)));
  });
  try {
    return await Promise.race([promise, expired]);
  } finally {
    end();
  }
}

const secondsOf = (milliseconds) => `${Math.round(milliseconds / 100) / 10} s`;

/** Retry-After in milliseconds, which is a number of seconds or a date; 0: none. */
function retryAfterOf({ headers }) {
  const text = headers.get("retry-after") ?? "";
  if (/^\d+$/.test(text)) return 1000 * Number(text);
  const date = Date.parse(text);
  return date > Date.now() ? date - Date.now() : 0;
}

const isOffline = () => globalThis.navigator?.onLine === false;

/** The wait before a retry, counted from 0: it doubles, and half of it is random, so that not all clients return at once. */
function backoff(attempt, { firstMs, longestMs }) {
  return Math.min(firstMs * 2 ** attempt, longestMs) * (0.5 + Math.random() / 2);
}

/** Resolves after some milliseconds, with the event "online", or when the signal is aborted. */
async function delayUnlessOnline(milliseconds, signal) {
  const stop = new AbortController();
  const leave = onAbort(signal, () => stop.abort());
  globalThis.addEventListener?.("online", () => stop.abort(), { signal: stop.signal });
  await delay(milliseconds, stop.signal);
  stop.abort();
  leave();
}

/** What fails and is tried again: a request, and the body of its response. */
class Outage {
  #url;
  #signals;
  #policy;
  #report;
  #budget;
  #attempt = 0;
  #deadline = null;

  /** signals: any of them ends it. report(outage, detail): detail null: it is over. */
  constructor(url, { signals, policy, report, budgetMs }) {
    this.#url = url;
    this.#signals = signals;
    this.#policy = policy;
    this.#report = report;
    this.#budget = budgetMs;
  }
  /** Bytes have come. */
  progress() {
    this.#attempt = 0;
    this.#deadline = null;
    this.#report(this, null);
  }
  /** Waits until another attempt is due. Throws the error if none is: it is not one of the network, or the budget is spent. */
  async wait(error) {
    const either = new AbortController();
    const leave = this.#signals.map((signal) => onAbort(signal, () => either.abort(reasonOf(signal))));
    try {
      await this.#wait(error, either.signal);
    } finally {
      leave.forEach((end) => end());
    }
    if (either.signal.aborted) throw reasonOf(either.signal);
  }
  async #wait(error, signal) {
    if (signal.aborted) return;
    const how = transient.get(error);
    if (!how) throw this.#fatal(error);
    const { retryAfterMaxMs } = this.#policy;
    const { immediate = false, retryAfterMs = 0 } = how;
    const now = performance.now();
    this.#deadline ??= now + this.#budget;
    if (retryAfterMs > retryAfterMaxMs) throw this.#fatal(error);
    // The host has named the time at which it is back.
    this.#deadline = Math.max(this.#deadline, now + retryAfterMs + (retryAfterMs && this.#budget));
    if (now >= this.#deadline && !isOffline()) throw this.#fatal(error);
    const attempt = this.#attempt++;
    if (immediate && attempt === 0) return;
    const spread = Math.random() * Math.min(retryAfterMs / 20, SPREAD_MS);
    const retryMs = Math.max(backoff(attempt, this.#policy), retryAfterMs + spread);
    this.#report(this, { url: this.#url, reason: error.message, offline: isOffline(), attempt, retryMs });
    if (isOffline()) {
      await delayUnlessOnline(LONGEST_TIMER, signal);
      this.#deadline = performance.now() + this.#budget;
    } else {
      // A host that has asked for time gets it.
      await (retryAfterMs ? delay(retryMs, signal) : delayUnlessOnline(retryMs, signal));
    }
  }
  #fatal(error) {
    this.#report(this, null);
    return error;
  }
}

/** A response with its body, which is read by pieces or bytes, or dropped. */
class Reply {
  #url;
  #response;
  #reader;
  #first = null; // the promise of the first piece, as of a reader
  #abort;
  #policy;
  #pace;
  #received;
  #release;

  /** abort: of the request. received(bytes): called as they come. release(): called when nothing more comes. */
  constructor(url, response, { abort, policy, pace, received, release }) {
    this.#url = url;
    this.#response = response;
    this.#reader = response.body?.getReader() ?? null;
    this.#policy = policy;
    this.#pace = pace;
    this.#abort = abort;
    this.#received = received;
    this.#release = release;
  }
  /** Waits for the first byte, or the end, which pieces yields. Throws as that does. */
  async begin() {
    this.#first = this.#next(this.#policy.firstByteMs);
    await this.#first;
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
  /**
   * Yields the body as it comes. Throws the reason when the request is aborted, and a transient error when the connection breaks
   * or nothing comes.
   */
  async *pieces() {
    if (!this.#first) await this.begin();
    try {
      for (let next = this.#first; ; next = this.#more()) {
        const { done, value } = await next;
        if (done) return;
        this.#received(value.length);
        yield value;
      }
    } finally {
      this.#reader?.cancel().catch(() => {});
      this.#release();
    }
  }
  /** The next piece of a body that is under way: when its host goes silent, the rest is to be requested again. */
  async #more() {
    const began = performance.now();
    const over = new AbortController();
    const silence = this.#pace.silence(began, over.signal).then(() => {
      if (over.signal.aborted) return null;
      const passed = performance.now() - began;
      this.#pace.stalled(passed);
      throw this.#stalled(passed, { immediate: true });
    });
    silence.catch(() => {});
    try {
      const next = await this.#next(this.#policy.progressMs, silence);
      this.#pace.went(performance.now() - began);
      return next;
    } finally {
      over.abort();
    }
  }
  /** failure: a promise that may be rejected. */
  async #next(milliseconds, failure = null) {
    if (!this.#reader) return { done: true };
    const { signal } = this.#abort;
    const { onlineMs } = this.#policy;
    const next = failure ? Promise.race([this.#reader.read(), failure]) : this.#reader.read();
    try {
      return await unlessAborted(
        within(next, milliseconds, onlineMs, (passed) => this.#stalled(passed)),
        signal,
      );
    } catch (error) {
      if (signal.aborted) throw reasonOf(signal);
      this.#abort.abort();
      throw isTransient(error) ? error : this.#broken(`the response broke off (${causeOf(error)})`, { cause: error });
    }
  }
  #stalled(passed, how) {
    return this.#broken(`no byte has come for ${secondsOf(passed)}`, { how });
  }
  #broken(why, { cause, how } = {}) {
    return asTransient(new FvvError({ code: "io", message: `${this.#url}: ${why}`, cause }), how);
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

/** What names the version of a file. */
export const versionOf = (headers) => ({ etag: headers.get("etag"), date: headers.get("last-modified") });

/**
 * Whether two responses with the same size are of the same file. Nodes of a CDN send weak and strong ETags of one file, and some
 * ETags of their own: then the date decides, and without one the bytes: of a file that is read by ranges those of its footer, which
 * has the digest of the index, and of one that is read from front to back those that have come.
 */
export function sameVersion(one, other) {
  const opaque = ({ etag }) => etag?.replace(/^W\//, "") ?? null;
  return opaque(one) === opaque(other) || (one.date !== null && one.date === other.date);
}

/** The bytes of a whole body that have come, and whether another response goes on with the same file. */
class Received {
  #url;
  #version;
  #size;
  #length = 0;
  #digest = 0;

  constructor(url, { headers }) {
    this.#url = url;
    this.#version = versionOf(headers);
    this.#size = this.#sizeOf(headers);
  }
  /** null: not said, or of the compressed body. */
  #sizeOf(headers) {
    const text = headers.get("content-encoding") ? null : headers.get("content-length");
    return text === null ? null : Number(text);
  }
  #changed(why) {
    return new FvvError({ code: "changed", message: `${this.#url} changed while it was read: ${why}` });
  }
  /** Yields what follows in a response, which begins with the first byte of the file. */
  async *continued(reply) {
    try {
      this.#check(reply);
    } catch (error) {
      reply.drop();
      throw error;
    }
    const named = sameVersion(versionOf(reply.headers), this.#version);
    let at = 0;
    let digest = 0;
    const skipped = this.#length;
    for await (const piece of reply.pieces()) {
      const again = piece.subarray(0, Math.max(0, skipped - at));
      at += piece.length;
      if (again.length && !named) digest = crc32c(again, digest);
      if (again.length === piece.length && at < skipped) continue;
      if (again.length && !named && digest !== this.#digest) throw this.#changed("other bytes come now");
      const more = piece.subarray(again.length);
      if (!more.length) continue;
      this.#digest = crc32c(more, this.#digest);
      this.#length += more.length;
      yield more;
    }
    if (at < skipped) throw this.#changed(`${at} bytes, where ${skipped} had come`);
  }
  #check(reply) {
    if (!reply.ok) throw failed(this.#url, reply);
    const size = this.#sizeOf(reply.headers);
    if (size !== null && this.#size !== null && size !== this.#size)
      throw this.#changed(`${this.#size} bytes, now ${size}`);
  }
}

/** Of one source. */
export class Network {
  #init;
  #open = new Set(); // what to call to end what is under way
  #closing = new AbortController();
  #policy;
  #report;
  #renew;
  #renewals = new Map(); // address -> the promise of what replaces it, {url, headers}
  #outages = new Set();
  #opened = false;
  #pace;
  /** Connections count, too. */
  requests = 0;
  bytesRead = 0;

  /**
   * init: of all requests, as for fetch. signal: closes. policy: what differs from POLICY. report(detail): called when requests
   * fail and are tried again, {url, reason, offline, attempt, retryMs}, and with null when bytes come again. renew({url, status}):
   * returns the promise of the address, text or {url, headers}, that replaces one that has expired; null: there is none.
   */
  constructor(init = {}, { signal, policy = {}, report = () => {}, renew = null } = {}) {
    this.#init = init;
    this.#policy = { ...POLICY, ...policy };
    this.#pace = new Pace(this.#policy.quickMs);
    this.#report = report;
    this.#renew = renew;
    onAbort(signal, () => this.close(reasonOf(signal)));
  }

  #track(end) {
    const { signal } = this.#closing;
    if (signal.aborted) end(reasonOf(signal));
    else this.#open.add(end);
    return () => this.#open.delete(end);
  }

  /** For an operation of one or more requests, which reports its progress. */
  outage(url, signal) {
    const { budgetMs, openBudgetMs } = this.#policy;
    const report = (outage, detail) => {
      const was = this.#outages.size;
      if (detail) this.#outages.add(outage);
      else this.#outages.delete(outage);
      if (detail || (was && !this.#outages.size)) this.#report(detail);
    };
    const budget = this.#opened ? budgetMs : Math.min(budgetMs, openBudgetMs);
    const signals = [this.#closing.signal, signal];
    return new Outage(url, { signals, policy: this.#policy, report, budgetMs: budget });
  }
  get policy() {
    return this.#policy;
  }
  /** The source is open: from here on budgetMs applies. */
  opened() {
    this.#opened = true;
  }

  /**
   * more: as for fetch, in addition. outage: of the operation that this is a part of. Tried again as the policy says; throws
   * FvvError "io" if there is no response even so, and the reason of a signal.
   */
  async request(url, { outage = null, ...more } = {}) {
    const own = outage ?? this.outage(url, more.signal);
    for (;;) {
      try {
        const reply = await this.#askAddress(url, more);
        if (!outage) own.progress();
        return reply;
      } catch (error) {
        await own.wait(error);
      }
    }
  }
  /** At the address that has replaced this one, if any. That may have been replaced twice while a host was silent. */
  async #askAddress(url, more) {
    let known = this.#renewals.get(url);
    let reply = await this.#ask(url, await known, more);
    for (let round = 0; round < 2 && this.#renew && EXPIRED.includes(reply.status); round++) {
      if (this.#renewals.get(url) === known)
        this.#renewals.set(url, unlessAborted(this.#renewed(url, reply.status), this.#closing.signal));
      known = this.#renewals.get(url);
      const renewed = await known;
      if (!renewed) break;
      reply.drop();
      reply = await this.#ask(url, renewed, more);
    }
    return reply;
  }
  async #renewed(url, status) {
    const found = await this.#renew({ url, status });
    if (!found) return null;
    return typeof found === "string" ? { url: found } : found;
  }
  async #ask(named, { url = named, headers: renewed } = {}, { signal, headers, ...more }) {
    const stop = new AbortController();
    const untrack = this.#track((reason) => stop.abort(reason));
    const leave = onAbort(signal, () => stop.abort(reasonOf(signal)));
    const release = () => {
      untrack();
      leave();
    };
    const init = { ...this.#init, ...more, headers: { ...this.#init.headers, ...renewed, ...headers } };
    const reply = await this.#first(stop.signal, (abort) => this.#askOnce(url, init, { abort, release })).catch(
      (error) => {
        release();
        throw error;
      },
    );
    if (!TRANSIENT.includes(reply.status)) return reply;
    reply.drop();
    throw asTransient(failed(url, reply), { retryAfterMs: retryAfterOf(reply) });
  }
  /** A Reply whose first byte has come, or that is not ok. */
  async #askOnce(url, init, { abort, release }) {
    const { connectMs, onlineMs } = this.#policy;
    const late = (passed) => noResponse(url, `none after ${secondsOf(passed)}`);
    const began = performance.now();
    this.requests++;
    const response = within(fetchOnce(url, { ...init, signal: abort.signal }), connectMs, onlineMs, late);
    const reply = new Reply(url, await unlessAborted(response, abort.signal), {
      abort,
      policy: this.#policy,
      pace: this.#pace,
      release,
      received: (bytes) => (this.bytesRead += bytes),
    });
    if (reply.ok) await reply.begin();
    this.#pace.responded(performance.now() - began);
    return reply;
  }
  /**
   * act(abort): an attempt, which abort ends, also after it has succeeded. While the host is silent others are made beside it, until
   * it fails by a time-out. Returns what the earliest success returns, and ends the others; throws what the first attempt throws, or the
   * reason of stop.
   */
  #first(stop, act) {
    const attempts = new Set();
    const over = new AbortController();
    const began = performance.now();
    return new Promise((resolve, reject) => {
      const end = () => {
        over.abort();
        for (const other of attempts) other.abort();
      };
      const attempt = async ({ isFirst = false } = {}) => {
        const abort = new AbortController();
        attempts.add(abort);
        const unlink = onAbort(stop, () => abort.abort(reasonOf(stop)));
        try {
          const found = await act(abort);
          attempts.delete(abort);
          end();
          resolve(found);
        } catch (error) {
          unlink();
          abort.abort();
          attempts.delete(abort);
          if (!isFirst) return;
          end();
          reject(error);
        }
      };
      const watch = async () => {
        await this.#pace.silence(began, over.signal);
        while (!over.signal.aborted) {
          attempt();
          await delay(this.#policy.longestMs, over.signal);
          await this.#pace.silence(began, over.signal);
        }
      };
      attempt({ isFirst: true });
      watch();
    });
  }

  /** A whole body. When it breaks off, it is requested again, and what has come is skipped. */
  async *body(url, reply) {
    const outage = this.outage(url);
    const known = new Received(url, reply);
    for (let current = reply; ;) {
      const pieces = known.continued(current);
      try {
        for await (const piece of pieces) {
          outage.progress();
          yield piece;
        }
        return;
      } catch (error) {
        await outage.wait(error);
        current = await this.request(url, { outage });
      }
    }
  }

  /**
   * Resolves with a WebSocket that is open, the first of those that were tried. prepare(socket): called for each, to listen before
   * anything comes. Throws FvvError "io".
   */
  async connect(WebSocket, url, protocols, prepare) {
    const stop = new AbortController();
    const untrack = this.#track((reason) => stop.abort(reason));
    try {
      const open = (abort) => this.#opening(new WebSocket(url, protocols), url, { abort, prepare });
      const socket = await this.#first(stop.signal, open);
      socket.addEventListener("close", untrack);
      return socket;
    } catch (error) {
      untrack();
      throw error;
    }
  }
  /** Resolves with a WebSocket when it is open. It is closed when abort is aborted. */
  #opening(socket, url, { abort: { signal }, prepare }) {
    socket.binaryType = "arraybuffer";
    this.requests++;
    const began = performance.now();
    return new Promise((resolve, reject) => {
      const refuse = (why) => reject(new FvvError({ code: "io", message: `${url}: ${why}` }));
      const fail = () => refuse("the WebSocket could not be opened, or failed");
      const { connectMs, onlineMs } = this.#policy;
      const end = expire(connectMs, onlineMs, () => {
        refuse("the WebSocket does not open");
        socket.close();
      });
      const leave = onAbort(signal, () => {
        end();
        reject(reasonOf(signal));
        socket.close();
      });
      socket.addEventListener("open", () => {
        end();
        this.#pace.responded(performance.now() - began);
        resolve(socket);
      });
      socket.addEventListener("error", fail);
      socket.addEventListener("close", () => {
        end();
        leave();
        fail();
      });
      prepare(socket);
    });
  }

  /** Ends everything that is under way, and every later request. */
  close(reason = new FvvError({ code: "state", message: "the source was closed" })) {
    this.#closing.abort(reason);
    for (const end of this.#open) end(reasonOf(this.#closing.signal));
    this.#open.clear();
  }
}

function noResponse(url, why, cause) {
  const message = `${url}: no response (${why}). ${adviceOn(url)}`;
  return asTransient(new FvvError({ code: "io", message, cause }), { immediate: true });
}

async function fetchOnce(url, init) {
  try {
    return await fetch(url, init);
  } catch (error) {
    throw init.signal.aborted ? error : noResponse(url, causeOf(error), error);
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
