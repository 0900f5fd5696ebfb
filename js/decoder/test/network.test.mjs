// Hosts and networks that fail for a while, refuse, cut off, stall or come back: every frame comes, exact and in order, and what
// cannot be mended is an error after a stated budget.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, test } from "node:test";
import { isDeepStrictEqual } from "node:util";
import { gzipSync } from "node:zlib";

import { createDecoder } from "../dist/index.js";
import { frameHashes, makeClips, nativeFrames, tool } from "./native.mjs";
import { messagesOf, WebSocket, WebSocketServer } from "./server.mjs";

const { clips, done } = makeClips("raw", "ladder");
const folder = join(clips.ladder, "..", "network-segments");
tool("fvvmux", clips.raw, "--segments", folder);
after(done);
const body = readFileSync(clips.raw);
const expected = nativeFrames(clips.raw);

/** Waits of a test, not of a network. */
const QUICK = { progressMs: 300, firstByteMs: 300, connectMs: 300, firstMs: 20, longestMs: 100 };

function rangeOf({ headers }) {
  const match = /^bytes=(\d*)-(\d*)$/.exec(headers.range ?? "");
  if (!match) return null;
  const [, from, last] = match;
  if (from === "") return { from: Math.max(0, body.length - Number(last)), to: body.length };
  return { from: Number(from), to: last === "" ? body.length : Math.min(body.length, Number(last) + 1) };
}

/** fault({request, response, n, range, send}): true: it has replied to the nth request. */
async function serve(fault = () => false) {
  let n = 0;
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, "http://x");
    const isFile = pathname === "/clip.fvv";
    const range = isFile ? rangeOf(request) : null;
    const bytes = isFile ? body : readFileSync(join(folder, pathname));
    const part = range ? bytes.subarray(range.from, range.to) : bytes;
    const headers = { ETag: '"a"', "Content-Length": part.length };
    if (range) headers["Content-Range"] = `bytes ${range.from}-${range.to - 1}/${body.length}`;
    const send = (status = range ? 206 : 200, more = {}, content = part) => {
      response.writeHead(status, { ...headers, "Content-Length": content.length, ...more });
      response.end(content);
      return true;
    };
    const cut = (end) => {
      response.writeHead(range ? 206 : 200, headers);
      response.write(part.subarray(0, part.length >> 1));
      if (end) setTimeout(() => response.destroy(), 20);
      return true;
    };
    if (!fault({ request, response, n: n++, range, send, cut, part, pathname })) send();
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const close = () => {
    server.closeAllConnections();
    server.close();
  };
  return { url: `http://127.0.0.1:${server.address().port}`, requests: () => n, close };
}

async function play(fault, { path = "clip.fvv", network = QUICK, ...more } = {}) {
  const server = await serve(fault);
  const outages = [];
  const warnings = [];
  const frames = [];
  const onOutage = (detail) => outages.push(detail);
  try {
    const options = { network, onOutage, limits: { cacheBytes: 0 }, ...more };
    const decoder = await createDecoder({ source: `${server.url}/${path}`, ...options });
    for (const type of ["warning", "gap", "damage"])
      decoder.addEventListener(type, ({ detail }) => warnings.push(detail.code));
    for await (const frame of decoder) frames.push(frameHashes(frame));
    decoder.close();
  } finally {
    server.close();
  }
  return { frames, outages, warnings };
}

/** Ends a connection without a reply. */
const refuse = ({ request }) => (request.socket.destroy(), true);
const at = (k, act) => (asked) => asked.n === k && act(asked);
const once = (wanted, act) => {
  let isDone = false;
  return (asked) => !isDone && wanted(asked) && ((isDone = true), act(asked));
};
function awayFor(milliseconds, from) {
  let since = null;
  return (asked) => {
    if (asked.n < from) return false;
    since ??= performance.now();
    return performance.now() - since < milliseconds && refuse(asked);
  };
}

/** A host without ranges whose first body breaks off; headers and bytes of the next one. */
const broken =
  (headers = {}, bytes = body, first = {}) =>
  ({ n, response, send }) => {
    if (n > 1 && headers) return send(200, headers, bytes);
    // Without a length.
    if (n > 1) return response.writeHead(200).end(bytes);
    response.writeHead(200, { "Content-Length": body.length, ETag: '"a"', ...first });
    response.write(body.subarray(0, body.length >> 1));
    setTimeout(() => response.destroy(), 30);
    return true;
  };

const MENDED = {
  ...Object.fromEntries(
    [0, 1, 2].flatMap((k) => [
      [`503 at request ${k}`, at(k, ({ send }) => send(503, {}, Buffer.from("busy")))],
      [`500 at request ${k}`, at(k, ({ send }) => send(500, {}, Buffer.from("x")))],
      [`a reset before the reply to request ${k}`, at(k, refuse)],
      [`a reset in the body of request ${k}`, at(k, ({ cut }) => cut(true))],
      [`a body that stalls at request ${k}`, at(k, ({ cut }) => cut(false))],
      [`no reply to request ${k}`, at(k, () => true)],
    ]),
  ),
  "refused for a second": awayFor(1000, 2),
  "short partial responses": ({ range, send }) => {
    if (!range) return false;
    const to = Math.min(range.to, range.from + 999);
    const header = { "Content-Range": `bytes ${range.from}-${to - 1}/${body.length}` };
    return send(206, header, body.subarray(range.from, to));
  },
  "the whole file from request 2 on": ({ n, send }) => n >= 2 && send(200, { "Content-Range": "" }, body),
  "partial responses without Content-Range": ({ range, send }) => range && send(206, { "Content-Range": "" }),
  "partial responses without Content-Range from request 2 on": ({ n, range, send }) =>
    n >= 2 && range && send(206, { "Content-Range": "" }),
  "a Content-Range that does not say the size": ({ range, send }) =>
    range && send(206, { "Content-Range": `bytes ${range.from}-${range.to - 1}/*` }),
  "a whole body that breaks off": broken(),
  redirects: ({ request, response, n }) => {
    if (request.url.includes("?")) return false;
    response.writeHead(302, { Location: `/clip.fvv?n=${n}` }).end();
    return true;
  },
};
for (const [name, headersOf] of Object.entries({
  "weak and strong ETags of nodes": (n) => ({ ETag: n % 2 ? 'W/"a"' : '"a"' }),
  "an ETag of each node, and one date": (n) => ({
    ETag: `"${n % 3}"`,
    "Last-Modified": "Wed, 21 Oct 2015 07:28:00 GMT",
  }),
  "an ETag of each node, and no date": (n) => ({ ETag: `"${n % 3}"` }),
  "an ETag of each response, and no date": (n) => ({ ETag: `"${n}"` }),
})) {
  MENDED[name] = ({ n, send }) => send(undefined, headersOf(n));
  MENDED[`a whole body that breaks off: ${name}`] = broken(headersOf(1), body, headersOf(0));
}
MENDED["a short response to the request for the last bytes"] = ({ request, range, send }) => {
  if (!/=-/.test(request.headers.range ?? "") && range?.from < body.length - 2000) return false;
  const to = Math.min(range.to, range.from + 700);
  return send(206, { "Content-Range": `bytes ${range.from}-${to - 1}/${body.length}` }, body.subarray(range.from, to));
};
for (const status of [400, 405, 416, 501])
  MENDED[`${status} to a request for the last bytes`] = ({ request, send }) =>
    /=-/.test(request.headers.range ?? "") && send(status, { "Content-Range": "" }, Buffer.from("no"));

for (const [name, fault] of Object.entries(MENDED))
  test(`a file: ${name}: every frame, in order`, async () => {
    const { frames, warnings } = await play(fault);
    assert.deepEqual(frames, expected);
    assert.deepEqual(
      warnings.filter((code) => code !== "no-range"),
      [],
    );
  });

const group = ({ pathname }) => pathname.includes("group-000001");
for (const [name, fault] of Object.entries({
  "503 for the manifest": at(0, ({ send }) => send(503, {}, Buffer.from("busy"))),
  "503 for a group": once(group, ({ send }) => send(503, {}, Buffer.from("busy"))),
  "a reset before a group": once(group, refuse),
  "a reset in a group": once(group, ({ cut }) => cut(true)),
  "a group that stalls": once(group, ({ cut }) => cut(false)),
  "a group that is cut off cleanly": once(group, ({ send, part }) => send(200, {}, part.subarray(0, 100))),
  "away for a second": awayFor(1000, 2),
}))
  test(`segments: ${name}: every frame, in order`, async () => {
    const { frames, warnings } = await play(fault, { path: "manifest.json" });
    assert.deepEqual(frames, expected);
    assert.deepEqual(warnings, []);
  });

test("segments that stay unavailable are an error, and not missing", async () => {
  const fault = (asked) => group(asked) && asked.send(503, {}, Buffer.from("busy"));
  const network = { ...QUICK, budgetMs: 400 };
  await assert.rejects(play(fault, { path: "manifest.json", network }), { code: "io", fatal: true, message: /503/ });
});

test("Retry-After is kept, reported with its reason, and over when bytes come", async () => {
  const times = [];
  const fault = ({ n, send }) => {
    if (n === 2) times.push(performance.now());
    if (n === 2) return send(429, { "Retry-After": "1" }, Buffer.from("later"));
    if (n === 3) times.push(performance.now());
    return false;
  };
  const { frames, outages } = await play(fault);
  assert.deepEqual(frames, expected);
  assert.ok(times[1] - times[0] >= 1000, `${times[1] - times[0]} ms`);
  assert.match(outages[0].reason, /HTTP status 429/);
  assert.ok(outages[0].retryMs >= 1000 && outages[0].offline === false);
  assert.equal(outages.at(-1), null);
});

test("a network that stays away is an error after the budget, not before", async () => {
  const began = performance.now();
  const network = { ...QUICK, budgetMs: 600 };
  await assert.rejects(
    play((asked) => asked.n >= 2 && refuse(asked), { network }),
    {
      code: "io",
      fatal: true,
      message: /no response/,
    },
  );
  assert.ok(performance.now() - began > 600);
});

test("an address that expires is replaced by the page", async () => {
  const asked = [];
  const fault = ({ request, n, send }) => {
    if (n < 2 || request.url.includes("key=new")) return false;
    return send(403, { "Content-Range": "" }, Buffer.from("expired"));
  };
  const renewAddress = async (expired) => {
    asked.push(expired);
    return `${expired.url}?key=new`;
  };
  const { frames } = await play(fault, { renewAddress });
  assert.deepEqual(frames, expected);
  assert.equal(asked.length, 1);
  assert.equal(asked[0].status, 403);
  await assert.rejects(play(fault), { code: "io", message: /403/ });
  await assert.rejects(play(fault, { renewAddress: async () => null }), { code: "io", message: /403/ });
});

test("ranges that are compressed are refused", async () => {
  const fault = ({ n, range, send }) =>
    n >= 2 && send(206, { "Content-Encoding": "gzip" }, gzipSync(body.subarray(range.from, range.to)));
  await assert.rejects(play(fault), { code: "io", message: /Content-Encoding gzip/ });
});

test("a file that is replaced by a shorter one is opened again", async () => {
  let isGone = false;
  const { frames, warnings } = await play(({ n, send }) => {
    if (n !== 2 || isGone) return false;
    isGone = true;
    return send(416, { "Content-Range": `bytes */${body.length}` }, Buffer.from(""));
  });
  assert.deepEqual(frames.slice(-expected.length), expected);
  assert.deepEqual(warnings, ["changed"]);
});

test("a file that is replaced by one of the same size is opened again, as its footer differs", async () => {
  const other = Buffer.from(body);
  other[other.length - 5] ^= 1; // in the CRC of the index
  const { frames, warnings } = await play(({ n, range, send }) => {
    if (n < 2) return false;
    return send(undefined, { ETag: '"b"' }, range ? other.subarray(range.from, range.to) : other);
  });
  assert.equal(warnings[0], "changed");
  assert.deepEqual(frames.slice(-expected.length), expected);
});

for (const [name, headers, bytes] of [
  ["of the same size", { ETag: '"b"' }, Buffer.from(body).fill(1, 100, 200)],
  ["that is shorter", { ETag: '"b"' }, body.subarray(0, body.length >> 2)],
  ["that is shorter than what has come, and without a length", null, body.subarray(0, body.length >> 2)],
])
  test(`a file without ranges that is replaced by one ${name} while it is read is not joined to the former`, async () => {
    const { frames, warnings } = await play(broken(headers, bytes)).catch((error) => ({
      frames: [],
      warnings: [error.code],
    }));
    assert.ok(warnings.includes("changed"), warnings.join());
    for (const frame of frames) assert.ok(expected.some((known) => isDeepStrictEqual(known, frame)));
  });

test("a decoder that is closed while it waits settles", async () => {
  const server = await serve((asked) => asked.n >= 2 && refuse(asked));
  let decoder = null;
  const stalled = new Promise((resolve) => {
    createDecoder({ source: `${server.url}/clip.fvv`, onOutage: resolve }).then((opened) => (decoder = opened));
  });
  while (!decoder) await new Promise((resolve) => setTimeout(resolve, 5));
  const next = (async () => {
    while (await decoder.next());
  })();
  await stalled;
  decoder.close();
  await next;
  server.close();
});

test("values of the policy are checked", async () => {
  const source = "http://127.0.0.1:9/clip.fvv";
  await assert.rejects(createDecoder({ source, network: { budget: 1 } }), {
    code: "argument",
    message: /found budget/,
  });
  // Mistyped names, also of a variable: without these errors such decoders would wait endlessly.
  for (const [options, message] of [
    [{ sorce: source }, /options: expected source, .*found sorce/],
    [{ source: undefined }, /source: expected a URL, .*found undefined; leave it out/],
    [{ source: { uri: source } }, /source: expected a URL/],
    [{ source: { url: source, header: {} } }, /source: expected url, headers, .*found header/],
  ])
    await assert.rejects(createDecoder(options), { code: "argument", message });
  await assert.rejects(createDecoder({ source, network: { budgetMs: -1 } }), { code: "argument", message: /budgetMs/ });
});

test("live: a client that is there before its server, and one whose server restarts", async () => {
  const { head, groups } = messagesOf(clips.raw);
  const first = new WebSocketServer({ port: 0, host: "127.0.0.1" });
  await new Promise((listening) => first.on("listening", listening));
  const { port } = first.address();
  await new Promise((closed) => first.close(closed));
  const opening = createDecoder({
    source: {
      url: `ws://127.0.0.1:${port}/live/x`,
      WebSocket,
      reconnect: { attempts: 20, firstMs: 20, longestMs: 100 },
    },
  });
  await new Promise((resolve) => setTimeout(resolve, 150));
  let connections = 0;
  const server = new WebSocketServer({ port, host: "127.0.0.1" });
  server.on("connection", (socket) => {
    const isFirst = connections++ === 0;
    for (const part of [head, ...(isFirst ? groups[0] : groups.slice(1).flat())]) socket.send(part);
    socket.send(JSON.stringify({ type: isFirst ? "restarting" : "end" }));
    socket.close(isFirst ? 1012 : 1000);
  });
  const decoder = await opening;
  const warnings = [];
  decoder.addEventListener("warning", ({ detail }) => warnings.push(detail.message));
  const frames = [];
  for await (const frame of decoder) frames.push(frameHashes(frame));
  decoder.close();
  server.close();
  assert.deepEqual(frames, expected);
  assert.equal(connections, 2);
  assert.ok(warnings.some((message) => message.includes("the server restarts")));
});
