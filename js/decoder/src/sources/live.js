// A live stream over WebSocket, as fvvserve sends it (docs/tools/fvvserve.md): each binary message is a chunk, or the file
// header with the configuration block; text messages report why a section ends, and which rungs there are.

import { FILE_HEADER_SIZE, GROUP, SCENE, beginsWithFileHeader, chunkType, frameTime } from "../chunks.js";
import { onAbort } from "../abort.js";
import { FvvError } from "../errors.js";
import { LiveChooser } from "../ladder.js";
import { asTransient, LONGEST_TIMER, Network } from "./network.js";
import { SectionSource } from "./types.js";

/** Bytes in the queue at most, when frames are not taken: beyond that, bytes are dropped up to the next group. */
const QUEUE_BYTES = 1 << 25;
const NORMAL_CLOSURE = 1000;
const ABNORMAL_CLOSURE = 1006;
/** Of WebSocket.readyState. */
const OPEN = 1;
/** Gaps between chunks that are remembered; twice the longest of them is silence. */
const GAPS = 256;
const SILENCES = 2;
const PING = JSON.stringify({ type: "ping" });
/** A number that no stream has: the last rung. */
const LAST_RUNG = 65535;

const now = () => performance.now() / 1000;

/** The rungs of a message; null: something is wrong with it. */
function rungsOf({ rungs, time_base: base }) {
  const [numerator, denominator] = Array.isArray(base) ? base : [];
  const isRung = (one, i) => one?.rung === i && one.bit_rate >= 0 && Array.isArray(one.tracks);
  if (!(numerator > 0 && denominator > 0) || !Array.isArray(rungs) || !rungs.every(isRung)) return null;
  const named = ({ rung, bit_rate: bitRate, size = 0, scale = null, tracks }) => ({
    rung,
    bitRate,
    size,
    scale,
    tracks,
  });
  return { rungs: rungs.map(named), tick: numerator / denominator };
}

export class LiveSource extends SectionSource {
  #url;
  #protocols;
  #WebSocket;
  #warn;
  #network;
  #outage;
  #attempts;
  #socket = null; // that is open
  #connecting = false;
  #pinged = 0; // when the last ping was sent
  #pong = null; // milliseconds to its response; null: the server has responded to none
  #gaps = []; // milliseconds between chunks
  #lastData = null; // when the connection opened or the last chunk came; null: the server has responded to a ping since
  #heard = 0; // when the connection opened or anything came, in milliseconds
  #unwatch = () => {};
  #items = [];
  #waiting = null;
  #queued = 0; // bytes in items
  #edge = null; // ticks
  #sections = 0; // headers in items
  #header = null;
  #block = null;
  #dropping = false;
  #over = false;
  #failures = 0; // since the last chunk
  #restarts = false; // the server has sent "restarting"
  #chooser = new LiveChooser();
  #choices = null; // {wish(), best()}
  #tick; // seconds
  #asked; // rung; null: that of the URL
  #playing = null; // rung of the group that comes
  #reason = "start";
  bytesRead = 0;
  rungs = null; // null: the server has named none

  /** reconnect: true, or {attempts, firstMs, longestMs}; false: never. rung: "auto", or the one to begin with. */
  static async open(
    { url, protocols, reconnect = false, WebSocket = globalThis.WebSocket },
    { warn, rung, policy, ...access },
  ) {
    if (typeof WebSocket !== "function")
      throw new FvvError({ code: "unsupported", message: "this environment has no WebSocket: pass a constructor" });
    const { attempts = reconnect ? Infinity : 0, ...waits } = reconnect === true ? {} : reconnect || {};
    const network = new Network({}, { ...access, policy: { ...policy, ...waits } });
    const live = new LiveSource({ url, protocols, WebSocket, rung, attempts }, { warn, network });
    onAbort(access.signal, () => live.close());
    // A page may be open before its server is.
    await live.#connect().catch((error) => live.#reconnect(error));
    return live;
  }

  constructor({ url, protocols, WebSocket, rung, attempts }, { warn, network }) {
    super();
    this.#url = url;
    this.#network = network;
    network.opened();
    this.#outage = network.outage(url);
    this.#asked = new URL(url).searchParams.has("rung") ? null : rung === "auto" ? LAST_RUNG : rung;
    if (rung !== "auto") this.#reason = "chosen";
    this.#protocols = protocols;
    this.#WebSocket = WebSocket;
    this.#attempts = attempts;
    this.#warn = warn;
  }

  get #address() {
    if (this.#asked === null) return this.#url;
    const url = new URL(this.#url);
    url.searchParams.set("rung", String(this.#asked));
    return url.href;
  }
  #connect() {
    this.#chooser.restart();
    this.#socket = null;
    this.#connecting = true;
    return this.#network.connect(this.#WebSocket, this.#address, this.#protocols, (socket) => this.#prepare(socket));
  }
  #prepare(socket) {
    socket.addEventListener("open", () => {
      // The first of several.
      if (!this.#connecting || this.#over) return;
      this.#connecting = false;
      this.#socket = socket;
      this.#heard = this.#lastData = performance.now();
      this.#watch(socket);
    });
    socket.addEventListener("message", ({ data }) => {
      if (socket !== this.#socket) return;
      this.#heard = performance.now();
      if (typeof data === "string") this.#takeMessage(data);
      else this.#take(new Uint8Array(data));
    });
    socket.addEventListener("close", ({ code, reason }) => {
      if (socket !== this.#socket) return;
      this.#unwatch();
      this.#put({ closed: { code, reason } });
    });
  }
  /**
   * A connection whose other end is gone may stay open without a byte. One that is silent for longer than it was lately gets a ping, and
   * has as long to respond as the server needed before; each is silenceMs at most, and that if the server has responded to none yet.
   * After the event "online" the connection gets a ping at once, and has onlineMs.
   */
  #watch(socket) {
    const { onlineMs } = this.#network.policy;
    const stop = new AbortController();
    let timer;
    const wait = (milliseconds, act) => {
      const began = performance.now();
      const look = () =>
        this.#heard > began ? wait(this.#silenceMs - (performance.now() - this.#heard), () => ask()) : act();
      clearTimeout(timer);
      timer = setTimeout(look, Math.min(milliseconds, LONGEST_TIMER));
    };
    const ask = (patience = this.#pongMs) => {
      this.#pinged = performance.now();
      if (socket.readyState === OPEN) socket.send(PING);
      wait(patience, () => this.#leave(socket));
    };
    globalThis.addEventListener?.("online", () => ask(onlineMs), { signal: stop.signal });
    this.#unwatch();
    this.#unwatch = () => {
      clearTimeout(timer);
      stop.abort();
    };
    // Whether it responds to pings is known before one is needed.
    if (this.#attempts) ask();
    else wait(this.#silenceMs, () => ask());
  }
  /** Milliseconds without a message until a ping, and from there to a message. */
  get #silenceMs() {
    return this.#soon(SILENCES * this.#longest);
  }
  /** A pong comes after the message that is being sent. */
  get #pongMs() {
    return this.#soon(Math.max(SILENCES * this.#pong, this.#longest));
  }
  get #longest() {
    return Math.max(0, ...this.#gaps);
  }
  #soon(milliseconds) {
    const { silenceMs, quickMs } = this.#network.policy;
    return this.#pong === null || !this.#attempts ? silenceMs : Math.min(silenceMs, Math.max(quickMs, milliseconds));
  }
  /** Its event "close" may take minutes. */
  #leave(socket) {
    this.#unwatch();
    this.#socket = null;
    socket.close();
    // It may be that the network is as slow.
    this.#gaps.push(performance.now() - this.#heard);
    const reason = `nothing has come for ${Math.round((performance.now() - this.#heard) / 1000)} s`;
    this.#put({ closed: { code: ABNORMAL_CLOSURE, reason } });
  }
  get requests() {
    return this.#network.requests;
  }

  #put(item) {
    this.#items.push(item);
    if (item.header) this.#sections++;
    this.#queued += item.bytes?.length ?? 0;
    this.#wake();
  }
  #wake() {
    const waiting = this.#waiting;
    this.#waiting = null;
    waiting?.();
  }

  #take(bytes) {
    this.bytesRead += bytes.length;
    if (this.#lastData !== null) this.#gaps.push(this.#heard - this.#lastData);
    if (this.#gaps.length > GAPS) this.#gaps.shift();
    this.#lastData = this.#heard;
    this.#failures = 0;
    this.#outage.progress();
    const begins = beginsWithFileHeader(bytes);
    const type = begins ? SCENE : chunkType(bytes);
    this.#measure(bytes);
    if (begins) {
      this.#header = bytes.slice(0, FILE_HEADER_SIZE);
      this.#edge = null;
    }
    // A reader that joins at a later group needs the latest configuration block.
    if (type === SCENE) this.#block = begins ? bytes.subarray(FILE_HEADER_SIZE) : bytes;
    if (this.#queued + bytes.length > QUEUE_BYTES && !this.#dropping) this.#drop();
    if (this.#dropping && !begins && (type !== GROUP || this.#queued > QUEUE_BYTES / 2)) return;
    if (begins || this.#dropping) this.#put({ header: this.#header });
    if (this.#dropping && !begins) this.#put({ bytes: this.#block });
    this.#dropping = false;
    this.#put({ bytes: begins ? this.#block : bytes });
  }

  #measure(bytes) {
    const time = frameTime(bytes);
    if (time === null) return;
    if (this.#edge === null || time > this.#edge) this.#edge = time;
    if (!this.rungs) return;
    this.#chooser.arrived(bytes.length, Number(time) * this.#tick, now());
    this.#consider();
  }
  /** Asks for another rung, if one is wanted. */
  #consider() {
    if (!this.#choices || !this.rungs) return;
    const wish = this.#choices.wish();
    const last = this.rungs.length - 1;
    const asked = this.#asked === null ? this.#playing : Math.min(this.#asked, last);
    let rung;
    if (wish !== null) rung = Math.min(wish, last);
    // The URL names a rung, or a change is under way.
    else if (this.#asked === null || this.#playing !== asked) return;
    else {
      const rates = this.rungs.map(({ bitRate }) => bitRate);
      rung = this.#chooser.choose({ rates, rung: asked, best: this.#choices.best(), now: now() });
    }
    if (rung === asked) return;
    this.#asked = rung;
    this.#reason = wish === null ? "delay" : "chosen";
    if (this.#socket?.readyState === OPEN) this.#socket.send(JSON.stringify({ type: "rung", rung }));
  }
  /** While frames before a header are in the queue, the edge may be that of another stream. */
  get edge() {
    return this.#sections ? null : this.#edge;
  }
  follow(choices) {
    this.#choices = choices();
  }
  renew() {
    this.#consider();
  }
  /** The rung with these tracks, which is played from here on. */
  rungOf(tracks) {
    const rung = this.rungs.findIndex((one) => one.tracks.join() === tracks.join());
    this.#playing = rung < 0 ? null : rung;
    return { rung: this.#playing, reason: this.#reason };
  }
  get throughput() {
    return this.#chooser.throughput;
  }

  #drop() {
    const reports = this.#items.filter(({ bytes, header }) => !bytes && !header);
    const error = FvvError.warning(
      "skipped",
      `frames are not taken: ${this.#queued} bytes of ${this.#url} were dropped`,
    );
    this.#items = [...reports, { lost: { error } }];
    this.#queued = this.#sections = 0;
    this.#dropping = true;
  }

  #takeMessage(text) {
    let message;
    try {
      message = JSON.parse(text);
    } catch {
      return;
    }
    const { type } = message ?? {};
    if (type === "pong") {
      this.#pong = performance.now() - this.#pinged;
      // The publisher pauses, and not the network.
      this.#lastData = null;
    }
    const reason = typeof message?.message === "string" ? message.message : "";
    if (type === "skip") {
      const from = /^-?\d{1,19}$/.test(message.from) ? BigInt(message.from) : undefined;
      this.#put({
        lost: { from, error: FvvError.warning("skipped", "this client was too slow: a part was left out") },
      });
    } else if (type === "damage") {
      this.#put({ lost: { error: FvvError.warning("damaged", `the input of the server is damaged: ${reason}`) } });
    } else if (type === "rungs") {
      const found = rungsOf(message);
      this.rungs = found?.rungs.length > 1 ? found.rungs : null;
      this.#tick = found?.tick;
      this.#put({ rungs: this.rungs });
    } else if (type === "restart") {
      this.#chooser.restart();
      this.#put({ restart: true });
    } else if (type === "restarting") {
      this.#restarts = true;
    } else if (type === "end") {
      this.#put({ end: true });
    } else if (type === "error") {
      this.#put({ error: new FvvError({ code: "io", message: `${this.#url}: ${reason}` }) });
    }
  }

  #whyClosed({ code, reason }) {
    const restarts = this.#restarts;
    this.#restarts = false;
    if (restarts) return `${this.#url}: the server restarts`;
    return `${this.#url}: the connection ended (${code}${reason ? `, ${reason}` : ""})`;
  }
  /** Attempts, and the time that the policy gives, count from the last chunk on: a server that accepts and closes at once is one that
   * does not work. */
  async #reconnect(error) {
    while (this.#failures++ < this.#attempts) {
      this.#warn(FvvError.warning("reconnect", `${error.message}; connecting again`));
      try {
        await this.#outage.wait(asTransient(error));
      } catch (ended) {
        if (this.#over) return;
        throw ended;
      }
      try {
        return await this.#connect();
      } catch {
        // The next attempt waits longer.
        if (this.#over) return;
      }
    }
    if (!this.#over) throw error;
  }

  async *stream(_, signal) {
    const unregister = onAbort(signal, () => this.close());
    try {
      while (!this.#over) {
        if (!this.#items.length) {
          await new Promise((resolve) => (this.#waiting = resolve));
          continue;
        }
        const item = this.#items.shift();
        this.#queued -= item.bytes?.length ?? 0;
        if (item.header) this.#sections--;
        if (item.end) return;
        if (item.error) throw item.error;
        if (item.bytes) yield item.bytes;
        else if (!item.closed) yield item;
        else {
          if (item.closed.code === NORMAL_CLOSURE && !this.#attempts) return;
          yield { lost: { error: FvvError.warning("io", `${this.#url}: the connection was lost`) } };
          await this.#reconnect(new FvvError({ code: "io", message: this.#whyClosed(item.closed) }));
        }
      }
    } finally {
      unregister();
      this.close();
    }
  }
  close() {
    this.#over = true;
    this.#unwatch();
    this.#network.close();
    this.#wake();
  }
}
