// Live streams over WebSocket, from fvvserve and from scripted servers.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";

import { onReports } from "../../testing/reports.mjs";
import { serveFolder } from "../../testing/served.mjs";
import { createDecoder } from "../dist/index.js";
import { frameHashes, makeClips, nativeFrames } from "./native.mjs";
import { messagesOf, WebSocket, WebSocketServer } from "./server.mjs";

const { clips, done } = makeClips("delta", "raw");
after(done);

/** script(socket, n): serves the nth connection. */
async function scripted(script) {
  let connections = 0;
  const server = new WebSocketServer({ port: 0, host: "127.0.0.1" });
  server.on("connection", (socket) => script(socket, connections++));
  await new Promise((listening) => server.on("listening", listening));
  const close = () => {
    server.clients.forEach((client) => client.terminate());
    server.close();
  };
  return { url: `ws://127.0.0.1:${server.address().port}/live/x`, close };
}

async function play(url, { frames: most = Infinity, ...more } = {}) {
  const decoder = await createDecoder({ source: { url, WebSocket, ...more } });
  const events = [];
  onReports(decoder, ["damage", "gap", "restart", "warning", "end"], (type, detail) => events.push({ type, detail }));
  const frames = [];
  try {
    for await (const frame of decoder) {
      frames.push(frameHashes(frame));
      if (frames.length === most) break;
    }
  } finally {
    decoder.close();
  }
  return { frames, events, types: events.map(({ type }) => type) };
}

const send = (socket, ...parts) => parts.flat().forEach((part) => socket.send(part));
const say = (socket, message) => socket.send(JSON.stringify(message));

test("fvvserve: a file from its first frame, in a loop", async () => {
  const served = await serveFolder({ clip: clips.delta });
  try {
    const { port } = new URL(served.url);
    const expected = nativeFrames(clips.delta);
    const { frames, types } = await play(`ws://127.0.0.1:${port}/live/clip`, { frames: 8 });
    assert.deepEqual(frames, [...expected, ...expected.slice(0, 3)]);
    assert.deepEqual(types, ["restart"]);
  } finally {
    served.close();
  }
});

test("a late client begins with any group", async () => {
  const { head, groups } = messagesOf(clips.delta);
  const server = await scripted((socket) => {
    send(socket, head, groups[1]);
    say(socket, { type: "unknown type" });
    say(socket, { type: "end" });
    socket.close(1000);
  });
  const { frames, types } = await play(server.url);
  server.close();
  assert.deepEqual(frames, nativeFrames(clips.delta).slice(3));
  assert.deepEqual(types, ["end"]);
});

test("a frame comes with the time of the newest one that has arrived, of its own stream", async () => {
  const { head, groups } = messagesOf(clips.delta);
  const server = await scripted((socket) => {
    send(socket, head, groups[0], groups[1]);
    say(socket, { type: "restart" });
    send(socket, head, groups[0]);
    say(socket, { type: "end" });
    socket.close(1000);
  });
  const decoder = await createDecoder({ source: { url: server.url, WebSocket }, queue: 1 });
  const edges = [];
  for await (const { seconds, edgeSeconds } of decoder) edges.push([seconds, edgeSeconds]);
  decoder.close();
  server.close();
  const restart = edges.findLastIndex(([seconds]) => seconds === 0);
  assert.ok(restart > 1);
  const last = edges.at(-1)[0];
  // A frame of the new stream waits for its header to be read.
  for (const [seconds, edge] of edges.slice(0, restart)) assert.ok(edge === null || edge >= seconds, `${edges}`);
  for (const [, edge] of edges.slice(restart)) assert.equal(edge, last);
  const file = await createDecoder({ source: readFileSync(clips.delta) });
  assert.equal((await file.next()).edgeSeconds, null);
  file.close();
});

test("data that the server leaves out is a gap", async () => {
  const { head, groups } = messagesOf(clips.delta);
  const times = nativeFrames(clips.delta);
  for (const type of ["skip", "damage"]) {
    const server = await scripted((socket) => {
      // In the middle of the third frame.
      send(socket, head, groups[0].slice(0, -3));
      say(socket, { type, from: "1", to: "3", chunks: 7, bytes: 999, message: "-: CRC" });
      send(socket, head, groups[1]);
      say(socket, { type: "end" });
      socket.close(1000);
    });
    const { frames, events, types } = await play(server.url);
    server.close();
    assert.deepEqual(types, ["gap", "end"]);
    const [{ detail }] = events;
    assert.equal(detail.cause.code, type === "skip" ? "skipped" : "damaged");
    assert.equal(typeof detail.to, "bigint");
    if (type === "skip") assert.equal(detail.from, 1n);
    for (const frame of frames) assert.ok(times.some((good) => good["time 0"] === frame["time 0"]));
    assert.ok(frames.length >= 3);
    assert.deepEqual(frames.slice(-2), times.slice(3));
  }
});

test("a broken connection is opened again, as often as configured", async () => {
  const { head, groups } = messagesOf(clips.delta);
  const server = await scripted((socket, n) => {
    send(socket, head, groups[n]);
    if (n === 0) return setTimeout(() => socket.terminate(), 50);
    say(socket, { type: "end" });
    socket.close(1000);
  });
  const { frames, types } = await play(server.url, { reconnect: { attempts: 2, firstMs: 10 } });
  assert.deepEqual(frames, nativeFrames(clips.delta));
  assert.deepEqual(types, ["warning", "gap", "end"]);
  server.close();
  const broken = await scripted((socket) => socket.terminate());
  await assert.rejects(play(broken.url), { code: "io" });
  broken.close();
  await assert.rejects(play(broken.url, { reconnect: { attempts: 2, firstMs: 10 } }), { code: "io", fatal: true });
});

/** Waits of a test. */
const QUICK = { silenceMs: 150, onlineMs: 100, firstMs: 20, longestMs: 50 };

async function playWith(network, url, reconnect) {
  const decoder = await createDecoder({ source: { url, WebSocket, reconnect }, network });
  const reasons = [];
  decoder.addEventListener("warning", ({ detail }) => detail.code === "reconnect" && reasons.push(detail.message));
  const frames = [];
  try {
    for await (const frame of decoder) frames.push(frameHashes(frame));
  } finally {
    decoder.close();
  }
  return { frames, reasons };
}

test("a connection that is open and silent is asked, and opened again if nothing comes", async () => {
  const { head, groups } = messagesOf(clips.delta);
  const pings = [];
  const server = await scripted((socket, n) => {
    send(socket, head, groups[n]);
    if (n === 0) return socket.on("message", (text) => pings.push(String(text))); // no byte, no close
    say(socket, { type: "end" });
  });
  const { frames, reasons } = await playWith(QUICK, server.url, true);
  assert.deepEqual(frames, nativeFrames(clips.delta));
  // When it opens, and when it is silent.
  assert.deepEqual(pings, ['{"type":"ping"}', '{"type":"ping"}']);
  assert.equal(reasons.length, 1);
  assert.match(reasons[0], /nothing has come/);
  server.close();
});

test("without reconnect a silent connection is an error", async () => {
  const { head, groups } = messagesOf(clips.delta);
  const server = await scripted((socket) => send(socket, head, groups[0]));
  await assert.rejects(playWith(QUICK, server.url, false), { code: "io", message: /nothing has come/ });
  server.close();
});

test("a silent server that responds keeps its connection", async () => {
  const { head, groups } = messagesOf(clips.delta);
  let connections = 0;
  const server = await scripted((socket) => {
    connections++;
    send(socket, head, groups[0]);
    socket.on("message", () => say(socket, { type: "pong" }));
    setTimeout(() => {
      send(socket, groups[1]);
      say(socket, { type: "end" });
    }, 1000);
  });
  const { frames, reasons } = await playWith(QUICK, server.url, true);
  assert.deepEqual(frames, nativeFrames(clips.delta));
  assert.deepEqual([connections, reasons], [1, []]);
  server.close();
});

test("after the event online a silent connection is asked at once", async () => {
  const { head, groups } = messagesOf(clips.delta);
  const page = new EventTarget();
  globalThis.addEventListener = (...given) => page.addEventListener(...given);
  const server = await scripted((socket, n) => {
    send(socket, head, groups[n]);
    if (n > 0) say(socket, { type: "end" });
  });
  try {
    const began = performance.now();
    setTimeout(() => page.dispatchEvent(new Event("online")), 300);
    const { frames } = await playWith({ ...QUICK, silenceMs: 60000 }, server.url, true);
    assert.deepEqual(frames, nativeFrames(clips.delta));
    assert.ok(performance.now() - began < 3000);
  } finally {
    delete globalThis.addEventListener;
    server.close();
  }
});

test("nothing listens for the event online once a connection has failed or the decoder is closed", async () => {
  const page = new EventTarget();
  let listening = 0;
  globalThis.addEventListener = (type, act, { signal }) => {
    listening++;
    signal.addEventListener("abort", () => listening--);
    page.addEventListener(type, act, { signal });
  };
  // Its connections never open, and are never closed.
  class Silent extends EventTarget {
    readyState = 0;
    close() {}
  }
  try {
    const source = { url: "ws://host.test/live/x", WebSocket: Silent, reconnect: { attempts: 3 } };
    await assert.rejects(createDecoder({ source, network: { ...QUICK, connectMs: 30 } }), { message: /does not open/ });
    assert.equal(listening, 0);
  } finally {
    delete globalThis.addEventListener;
  }
});

test("a server that stays away is an error after the budget", async () => {
  const began = performance.now();
  await assert.rejects(playWith({ ...QUICK, budgetMs: 500 }, "ws://127.0.0.1:9/live/x", true), { code: "io" });
  const passed = performance.now() - began;
  assert.ok(passed >= 500 && passed < 5000, `${passed} ms`);
});

test("fvvserve responds to a ping", async () => {
  const served = await serveFolder({ clip: clips.delta });
  const { port } = new URL(served.url);
  const socket = new WebSocket(`ws://127.0.0.1:${port}/live/clip`);
  const texts = [];
  socket.on("open", () => socket.send('{"type":"ping"}'));
  const pong = new Promise((resolve) =>
    socket.on("message", (data, isBinary) => {
      if (!isBinary) texts.push(String(data));
      if (texts.includes('{"type":"pong"}')) resolve();
    }),
  );
  const late = new Promise((_, reject) => setTimeout(() => reject(new Error(`no pong: ${texts}`)), 5000).unref());
  try {
    await Promise.race([pong, late]);
  } finally {
    socket.terminate();
    served.close();
  }
});

test("an error of the server ends playback", async () => {
  const server = await scripted((socket) => say(socket, { type: "error", message: "-: no stream" }));
  await assert.rejects(play(server.url), { code: "io", message: /no stream/ });
  server.close();
});

test("frames that are not taken are dropped in groups, and memory stays bounded", async () => {
  const { head, groups } = messagesOf(clips.raw);
  const bytes = groups.flat().reduce((n, part) => n + part.length, 0);
  const rounds = Math.ceil(2 ** 26 / bytes);
  const server = await scripted((socket) => {
    for (let i = 0; i < rounds; i++) send(socket, head, groups.flat());
    say(socket, { type: "end" });
  });
  const decoder = await createDecoder({ source: { url: server.url, WebSocket }, queue: 1 });
  const gaps = [];
  onReports(decoder, ["gap"], (_, { cause }) => gaps.push(cause.code));
  const first = await decoder.next();
  first.close();
  await new Promise((resolve) => setTimeout(resolve, 1500));
  let n = 1;
  for await (const frame of decoder) n += frame.close() ?? 1;
  server.close();
  assert.ok(gaps.includes("skipped"), gaps.join());
  assert.ok(n < rounds * 5, `${n} frames of ${rounds * 5}`);
});
