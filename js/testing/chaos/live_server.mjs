// A live server in this thread, as fvvserve behaves, and its clients' WebSockets: its publisher and itself may be killed, restart,
// or be cut off from the clients while their connections stay open.

/** Milliseconds until a connection is open. */
const LATENCY = 20;
const OPEN = 1;
const CLOSED = 3;

const event = (type, fields) => Object.assign(new Event(type), fields);

export class LiveServer {
  #clock;
  #host;
  #head;
  #groups;
  #groupMs;
  #at = -1; // the group that was published last
  #sockets = new Set();
  #isOver = false;

  /** host: has the fault of the moment. */
  constructor(clock, host, { head, groups, groupMs }) {
    this.#clock = clock;
    this.#host = host;
    this.#head = head;
    this.#groups = groups;
    this.#groupMs = groupMs;
    this.#publish();
  }
  get WebSocket() {
    const server = this;
    return class extends EventTarget {
      readyState = 0;
      dead = false; // nothing comes or goes any more
      constructor() {
        super();
        server.#accept(this);
      }
      send(text) {
        if (JSON.parse(text).type === "ping" && !this.dead) server.#deliver(this, '{"type":"pong"}');
      }
      close(code = 1000) {
        // The closing handshake of a dead connection takes longer than anyone waits.
        if (this.readyState === CLOSED || this.dead) return;
        server.#close(this, code);
      }
    };
  }
  async #accept(socket) {
    await this.#clock.wait(LATENCY);
    const kind = this.#host.fault?.kind;
    if (socket.readyState === CLOSED) return;
    if (kind === "half open") return void (socket.dead = true);
    if (["server", "restarting", "offline"].includes(kind)) {
      socket.readyState = CLOSED;
      socket.dispatchEvent(event("error"));
      return socket.dispatchEvent(event("close", { code: 1006, reason: "" }));
    }
    socket.readyState = OPEN;
    this.#sockets.add(socket);
    socket.dispatchEvent(event("open"));
    this.#send(socket, this.#head);
    if (this.#at >= 0) this.#groups[this.#at].forEach((chunk) => this.#send(socket, chunk));
  }
  #send(socket, bytes) {
    this.#deliver(socket, new Uint8Array(bytes).buffer);
  }
  #deliver(socket, data) {
    if (socket.readyState === OPEN && !socket.dead) socket.dispatchEvent(event("message", { data }));
  }
  #close(socket, code) {
    if (socket.readyState === CLOSED) return;
    socket.readyState = CLOSED;
    this.#sockets.delete(socket);
    socket.dispatchEvent(event("close", { code, reason: "" }));
  }
  #toAll(act) {
    for (const socket of [...this.#sockets]) act(socket);
  }

  async #publish() {
    while (!this.#isOver) {
      await this.#clock.wait(this.#groupMs);
      if (this.#host.fault?.kind === "publisher") continue;
      this.#at++;
      if (this.#at === this.#groups.length) this.#restart();
      this.#toAll((socket) => this.#groups[this.#at].forEach((chunk) => this.#send(socket, chunk)));
    }
  }
  /** Another stream begins. */
  #restart() {
    this.#at = 0;
    this.#toAll((socket) => {
      this.#deliver(socket, '{"type":"restart"}');
      this.#send(socket, this.#head);
    });
  }
  /** What a fault does to connections that are open. */
  begin({ kind }) {
    if (kind === "half open" || kind === "offline") this.#toAll((socket) => (socket.dead = true));
    if (kind === "restarting") this.#toAll((socket) => this.#deliver(socket, '{"type":"restarting"}'));
    if (kind === "restarting") this.#toAll((socket) => this.#close(socket, 1012));
    if (kind === "server") this.#toAll((socket) => this.#close(socket, 1006));
  }
  /** A server or a publisher that was killed begins with its first group. */
  finish({ kind }) {
    if (kind === "publisher") this.#restart();
    if (kind === "server" || kind === "restarting") this.#at = -1;
  }
  end() {
    this.#isOver = true;
  }
}

/** A fault that a seed decides, from now on. */
export const anyLiveFault = ({ between, pick }, now) => ({
  kind: pick(["server", "restarting", "half open", "offline", "publisher"]),
  until: now + between(300, 15000),
});
