// A host and the network before it, in this thread: replies to fetch as both do in their bad hours, by a seed.

/** Milliseconds of a good reply, and bytes of a piece of a body. */
const LATENCY = 20;
const PIECE = 16384;

const broken = (code) => Object.assign(new TypeError("fetch failed"), { cause: { code } });

/** What may be wrong for a while: {kind, until, retryAfter?}. null: nothing is. */
export class Host {
  #clock;
  #random;
  #read;
  #page = globalThis.dispatchEvent ? globalThis : new EventTarget();
  #key = 0;
  #replies = 0;
  #replaced = 0;
  #real = { fetch: globalThis.fetch, navigator: Object.getOwnPropertyDescriptor(globalThis, "navigator") };
  fault = null;
  /** The fault before, and when it ended. */
  last = null;
  ended = null;
  requests = 0;

  /** read(path, version): bytes of the file of a path; version: how often all files were replaced so far. */
  constructor(clock, random, read) {
    this.#clock = clock;
    this.#random = random;
    this.#read = read;
    globalThis.fetch = (url, init) => this.#fetch(new URL(String(url)), init);
    if (this.#page !== globalThis) globalThis.addEventListener = (...given) => this.#page.addEventListener(...given);
    Object.defineProperty(globalThis, "navigator", { value: { onLine: true }, configurable: true, writable: true });
  }
  /** Begins a fault; ends by itself. */
  begin(fault) {
    this.fault = fault;
    if (fault.kind === "expired") this.#key++;
    if (fault.kind === "replaced") this.#replaced++;
    if (fault.kind === "offline") globalThis.navigator.onLine = false;
  }
  finish() {
    const wasOffline = this.fault?.kind === "offline";
    this.fault = null;
    if (!wasOffline) return;
    globalThis.navigator.onLine = true;
    this.#page.dispatchEvent(new Event("online"));
  }
  end() {
    globalThis.fetch = this.#real.fetch;
    if (this.#page !== globalThis) delete globalThis.addEventListener;
    delete globalThis.navigator;
    if (this.#real.navigator) Object.defineProperty(globalThis, "navigator", this.#real.navigator);
  }
  /** The address that is valid now. */
  renew(url) {
    const renewed = new URL(url);
    renewed.searchParams.set("key", String(this.#key));
    return renewed.href;
  }

  async #fetch(url, { headers, signal }) {
    this.requests++;
    const n = this.#replies++;
    const stop = new Promise((_, reject) => {
      if (signal.aborted) reject(signal.reason);
      signal.addEventListener("abort", () => reject(signal.reason), { once: true });
    });
    stop.catch(() => {});
    await Promise.race([this.#clock.wait(LATENCY * this.#random.between(0.5, 2)), stop]);
    const kind = this.fault?.kind;
    if (kind === "offline" || kind === "refused") throw broken("ECONNREFUSED");
    if (kind === "no reply") await stop;
    if (kind === "status") return this.#status();
    if (url.searchParams.get("key") !== String(this.#key) && this.#key) return new Response("expired", { status: 403 });
    if (kind === "redirects" && url.hostname === "host.test") return this.#redirected(url, { headers, signal });
    return this.#reply(url, headers, { signal, stop, n });
  }
  /** Browsers follow 302 and 307 by themselves: what a script sees is the reply of another host, later, or none. */
  #redirected(url, init) {
    const other = new URL(url);
    other.hostname = this.#random.pick(["a.cdn.test", "b.cdn.test"]);
    other.port = this.#random.pick(["", "8443"]);
    return this.#fetch(other, init);
  }
  #status() {
    const { status, until, retryAfter } = this.fault;
    const seconds = Math.max(1, Math.ceil((until - this.#clock.now) / 1000));
    if (retryAfter) this.fault.allowed = this.#clock.now + 1000 * seconds;
    return new Response("busy", { status, headers: retryAfter ? { "Retry-After": String(seconds) } : {} });
  }

  #reply(url, headers, { signal, stop, n }) {
    const kind = this.fault?.kind;
    const [, first] = url.pathname.split("/");
    const bytes = this.#read(url.pathname.slice(1), this.#replaced);
    const text = first === "range" && kind !== "whole" ? new Headers(headers).get("range") : null;
    const known = { ETag: kind === "etags" ? `"${n}"` : `"${this.#replaced}"`, "Content-Length": String(bytes.length) };
    if (!text) return new Response(this.#body(bytes, { signal, stop }), { status: 200, headers: known });
    if (kind === "suffix" && text.startsWith("bytes=-"))
      return new Response("no", { status: this.#random.pick([400, 405, 501]) });
    const [, from, last] = /^bytes=(\d*)-(\d*)$/.exec(text);
    const begin = from === "" ? Math.max(0, bytes.length - Number(last)) : Number(from);
    const total = { "Content-Range": `bytes */${bytes.length}` };
    if (begin >= bytes.length) return new Response("beyond the end", { status: 416, headers: total });
    let end = from === "" ? bytes.length : Math.min(bytes.length, Number(last) + 1);
    if (kind === "short") end = Math.min(end, begin + 1 + Math.floor(this.#random.between(0, end - begin)));
    const range = `bytes ${begin}-${end - 1}/${bytes.length}`;
    const part = { ETag: known.ETag, "Content-Range": range, "Content-Length": String(end - begin) };
    return new Response(this.#body(bytes.subarray(begin, end), { signal, stop }), { status: 206, headers: part });
  }

  /** Bytes in pieces. A reset or a stall in the middle happens to bodies that are under way, too. */
  #body(bytes, { signal, stop }) {
    let at = 0;
    const pull = async (controller) => {
      await Promise.race([this.#clock.wait(1 + PIECE / 4000), stop]);
      const kind = this.fault?.kind;
      if (kind === "reset" || kind === "offline") return controller.error(broken("ECONNRESET"));
      // What stalls once never goes on: the connection is dead.
      if (kind === "stall") await stop;
      const piece = bytes.subarray(at, at + PIECE);
      at += piece.length;
      if (piece.length) controller.enqueue(new Uint8Array(piece));
      if (at >= bytes.length) controller.close();
    };
    signal.throwIfAborted();
    return new ReadableStream({ pull }, { highWaterMark: 0 });
  }
}

/** A fault that a seed decides, from now on. */
export function anyFault({ between, pick, random }, now) {
  const until = now + between(300, 15000);
  const kind = pick([
    ..."refused offline offline status status status reset stall".split(" "),
    ..."short etags suffix expired whole redirects replaced".split(" "),
    "no reply",
  ]);
  if (kind !== "status") return { kind, until };
  return { kind, until, status: pick([500, 502, 503, 503, 429]), retryAfter: random() < 0.7 };
}

/** Milliseconds without a fault. */
const PEACE = [1000, 12000];

/** Faults one after the other, with peace between them, until the signal is aborted. victim: what they happen to besides the host. */
export async function misfortune({ clock, host, random, figures }, choose, victim, signal) {
  while (!signal.aborted) {
    await clock.wait(random.between(...PEACE));
    const fault = choose(random, clock.now);
    figures.note(fault);
    host.begin(fault);
    victim?.begin(fault);
    await clock.wait(fault.until - clock.now);
    host.finish();
    host.last = fault;
    host.ended = clock.now;
    victim?.finish(fault);
  }
}
