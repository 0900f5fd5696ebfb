// A proxy for a local port that simulates a link with a rate and a delay: bytes to the client are sent at the rate and arrive
// half a round trip later; bytes to the server are only delayed. TCP ends at the proxy on both sides, so that slow start and
// loss have no effect: only the wait for responses and bytes is measured.

import { connect, createServer } from "node:net";

/** Pieces this large share the link; a browser's connections take turns. */
const PIECE = 1460;
/** Pieces of a connection in transit, before its sender has to wait. */
const MAX_PIECES = 64;

class Link {
  constructor({ bitsPerSecond, delayMs }) {
    this.rate = bitsPerSecond;
    this.delayMs = delayMs;
    this.free = 0;
  }
  set rate(bitsPerSecond) {
    this.msPerByte = bitsPerSecond ? 8000 / bitsPerSecond : 0;
  }
  /** The time at which bytes that are sent now have arrived. */
  arrival(size) {
    this.free = Math.max(this.free, performance.now()) + size * this.msPerByte;
    return this.free + this.delayMs;
  }
}

/** Copies from one socket to another over a link, in order; arrived(bytes) is called for each piece. */
function carry(from, to, link, arrived) {
  const waiting = []; // {at, piece}; without a piece: the end
  let timer = null;
  const pass = () => {
    timer = null;
    while (waiting.length && waiting[0].at <= performance.now()) {
      const { piece } = waiting.shift();
      if (!piece) to.end();
      else if (!to.destroyed) {
        arrived(piece.length);
        to.write(piece);
      }
    }
    if (waiting.length < MAX_PIECES) from.resume();
    if (waiting.length) timer = setTimeout(pass, Math.max(1, waiting[0].at - performance.now()));
  };
  const put = (piece) => {
    waiting.push({ at: link.arrival(piece?.length ?? 0), piece });
    timer ??= setTimeout(pass, Math.max(1, waiting[0].at - performance.now()));
  };
  from.on("data", (data) => {
    for (let at = 0; at < data.length; at += PIECE) put(data.subarray(at, at + PIECE));
    if (waiting.length >= MAX_PIECES) from.pause();
  });
  from.on("end", () => put(null));
  from.on("error", () => to.destroy());
}

/** Returns {port, bytes(), setRate(bitsPerSecond), close}; bytes(): the number of bytes that have arrived at the client. */
export async function shapedProxy(target, { bitsPerSecond, roundTripMs }) {
  let bytes = 0;
  const down = new Link({ bitsPerSecond, delayMs: roundTripMs / 2 });
  const up = new Link({ bitsPerSecond: 0, delayMs: roundTripMs / 2 });
  const sockets = new Set();
  const server = createServer((client) => {
    const host = connect(target, "127.0.0.1");
    for (const socket of [client, host]) {
      socket.setNoDelay();
      sockets.add(socket);
      socket.on("close", () => sockets.delete(socket));
    }
    carry(client, host, up, () => {});
    carry(host, client, down, (n) => (bytes += n));
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const close = () => {
    server.close();
    for (const socket of sockets) socket.destroy();
  };
  const setRate = (rate) => (down.rate = rate);
  return { port: server.address().port, bytes: () => bytes, setRate, close };
}
