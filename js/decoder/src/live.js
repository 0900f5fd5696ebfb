// A live stream over WebSocket, as fvvserve sends it (docs/fvvserve.md): each binary message is a chunk, or the file
// header with the configuration block; text messages say why a run ends.

import { FvvError } from "./errors.js";
import { FILE_HEADER_SIZE, beginsRun, loss, wait } from "./runs.js";

/** Bytes that wait here at most, when frames are not taken: what is above is dropped up to the next group. */
const QUEUE_BYTES = 1 << 25;
const GROUP = 0x50555247; // "GRUP"
const SCENE = 0x4e454353; // "SCEN"
const NORMAL_CLOSURE = 1000;

const typeOf = (bytes) => new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);

export class Live {
  /** reconnect: {attempts, firstMs, longestMs}. */
  static async open({ url, protocols, reconnect = {}, WebSocket = globalThis.WebSocket }, warn) {
    if (typeof WebSocket !== "function")
      throw new FvvError({ code: "unsupported", message: "there is no WebSocket here: pass a constructor" });
    const live = new Live();
    const { attempts = 0, firstMs = 250, longestMs = 8000 } = reconnect;
    Object.assign(live, { url, protocols, WebSocket, warn, attempts, firstMs, longestMs });
    Object.assign(live, { inRuns: true, bytesRead: 0, requests: 0, items: [], waiting: null, queued: 0 });
    Object.assign(live, { header: null, block: null, dropping: false, over: false });
    await live.#connect();
    return live;
  }

  #connect() {
    const { WebSocket } = this;
    const socket = new WebSocket(this.url, this.protocols);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.requests++;
    let opened = false;
    return new Promise((resolve, reject) => {
      socket.addEventListener("open", () => {
        opened = true;
        resolve();
      });
      socket.addEventListener("error", () => {
        reject(new FvvError({ code: "io", message: `${this.url}: no WebSocket can be opened, or it broke` }));
      });
      socket.addEventListener("message", ({ data }) => {
        if (socket !== this.socket) return;
        if (typeof data === "string") this.#hear(data);
        else this.#take(new Uint8Array(data));
      });
      socket.addEventListener("close", ({ code, reason }) => {
        if (opened && socket === this.socket) this.#put({ closed: { code, reason } });
      });
    });
  }

  #put(item) {
    this.items.push(item);
    this.queued += item.bytes?.length ?? 0;
    this.#wake();
  }
  #wake() {
    const { waiting } = this;
    this.waiting = null;
    waiting?.();
  }

  #take(bytes) {
    this.bytesRead += bytes.length;
    const begins = beginsRun(bytes);
    const type = begins ? SCENE : bytes.length >= 4 ? typeOf(bytes) : 0;
    if (begins) this.header = bytes.slice(0, FILE_HEADER_SIZE);
    // What a group that is joined later needs in front of it.
    if (type === SCENE) this.block = begins ? bytes.subarray(FILE_HEADER_SIZE) : bytes;
    if (this.queued + bytes.length > QUEUE_BYTES && !this.dropping) this.#drop();
    if (this.dropping && !begins && (type !== GROUP || this.queued > QUEUE_BYTES / 2)) return;
    if (begins || this.dropping) this.#put({ header: this.header });
    if (this.dropping && !begins) this.#put({ bytes: this.block });
    this.dropping = false;
    this.#put({ bytes: begins ? this.block : bytes });
  }

  #drop() {
    const said = this.items.filter(({ bytes, header }) => !bytes && !header);
    const error = loss(`frames are not taken: ${this.queued} bytes of ${this.url} were dropped`, "skipped");
    this.items = [...said, { lost: { error } }];
    this.queued = 0;
    this.dropping = true;
  }

  #hear(text) {
    let message;
    try {
      message = JSON.parse(text);
    } catch {
      return;
    }
    const { type } = message ?? {};
    const said = typeof message?.message === "string" ? message.message : "";
    if (type === "skip") {
      const from = /^-?\d{1,19}$/.test(message.from) ? BigInt(message.from) : undefined;
      this.#put({ lost: { from, error: loss("this client was too slow: a part was left out", "skipped") } });
    } else if (type === "damage") {
      this.#put({ lost: { error: loss(`the input of the server is damaged: ${said}`, "damaged") } });
    } else if (type === "restart") {
      this.#put({ restart: true });
    } else if (type === "end") {
      this.#put({ end: true });
    } else if (type === "error") {
      this.#put({ error: new FvvError({ code: "io", message: `${this.url}: ${said}` }) });
    }
  }

  async #reconnect({ code, reason }, signal) {
    const why = `${this.url}: the connection ended (${code}${reason ? `, ${reason}` : ""})`;
    for (let attempt = 0; attempt < this.attempts; attempt++) {
      this.warn(loss(`${why}; connecting again`, "reconnect"));
      // Not all clients of a server that comes back at the same moment.
      const delay = Math.min(this.firstMs * 2 ** attempt, this.longestMs);
      await wait(delay * (0.5 + Math.random() / 2), signal);
      if (signal?.aborted) return;
      try {
        await this.#connect();
        return;
      } catch {
        // The next attempt waits longer.
      }
    }
    throw new FvvError({ code: "io", message: why });
  }

  async *stream(_, signal) {
    const stop = () => {
      this.socket.close();
      this.over = true;
      this.#wake();
    };
    signal?.addEventListener("abort", stop, { once: true });
    try {
      while (!this.over) {
        if (!this.items.length) {
          await new Promise((resolve) => (this.waiting = resolve));
          continue;
        }
        const item = this.items.shift();
        this.queued -= item.bytes?.length ?? 0;
        if (item.end) return;
        if (item.error) throw item.error;
        if (item.bytes) yield item.bytes;
        else if (!item.closed) yield item;
        else {
          if (item.closed.code === NORMAL_CLOSURE && !this.attempts) return;
          yield { lost: { error: loss(`${this.url}: the connection was lost`) } };
          await this.#reconnect(item.closed, signal);
        }
      }
    } finally {
      signal?.removeEventListener("abort", stop);
      this.socket.close();
    }
  }
}
