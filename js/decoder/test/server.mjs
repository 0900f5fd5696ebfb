// A web server that behaves as good and bad hosts do, by the first part of the path:
//   /dist /test        this package, under a strict content policy; more folders can be given
//   /range/NAME        supports Range
//   /front/NAME        as Vite's dev server: Range, but the last N bytes are taken for the first N + 1
//   /page/NAME         a page in place of the file
//   /whole/NAME        responds 200 to every request
//   /wrong/NAME        a Content-Range whose total is wrong
//   /gzip/NAME         compresses the response
//   /changing/NAME     another ETag from the third request on
//   /unranged/NAME     200 from the third request on
//   /live/NAME         a WebSocket: the whole stream at once
//   /growing/NAME      another total from the third request on

import { readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { createRequire } from "node:module";

const home = resolve(fileURLToPath(import.meta.url), "../..");
const types = { html: "text/html", js: "text/javascript", mjs: "text/javascript" };
const policy = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'";

function rangeOf(request, size, misreads) {
  const match = /^bytes=(\d*)-(\d*)$/.exec(request.headers.range ?? "");
  if (!match) return null;
  const [, from, to] = match;
  if (from === "" && misreads) return { from: 0, to: Math.min(size, Number(to) + 1) };
  if (from === "") return { from: Math.max(0, size - Number(to)), to: size };
  return { from: Number(from), to: to === "" ? size : Math.min(size, Number(to) + 1) };
}

const contents = new Map(); // path -> {changed, bytes}
/** The bytes of a file, which is read again only when it has changed. */
function contentOf(path) {
  const { mtimeMs: changed } = statSync(path);
  if (contents.get(path)?.changed !== changed) contents.set(path, { changed, bytes: readFileSync(path) });
  return contents.get(path).bytes;
}

/** files: name to path. results(value): called with what a page posts to /result. folders: more folders, name to path.
 * Returns {url, requests, close}. */
export async function serve(files, results = () => {}, folders = {}) {
  const served = { dist: join(home, "dist"), test: join(home, "test"), ...folders };
  const requests = [];
  const counts = new Map();
  const clip = (behaviour, name, request, response) => {
    const bytes = contentOf(files[name]);
    const count = (counts.get(request.url) ?? 0) + 1;
    counts.set(request.url, count);
    const etag = behaviour === "changing" && count > 3 ? '"b"' : '"a"';
    const range =
      behaviour === "whole" || (behaviour === "unranged" && count > 3)
        ? null
        : rangeOf(request, bytes.length, behaviour === "front");
    if (behaviour === "page") {
      response.writeHead(200, { "Content-Type": "text/html; charset=utf-8" });
      return response.end("<!doctype html><title>404</title>");
    }
    if (behaviour === "gzip") {
      response.writeHead(200, { "Content-Encoding": "gzip", ETag: etag });
      return response.end(gzipSync(bytes));
    }
    if (!range) {
      response.writeHead(200, { "Content-Length": bytes.length, ETag: etag });
      return response.end(bytes);
    }
    const total = behaviour === "wrong" || (behaviour === "growing" && count === 4) ? bytes.length + 5 : bytes.length;
    response.writeHead(206, { "Content-Range": `bytes ${range.from}-${range.to - 1}/${total}`, ETag: etag });
    response.end(bytes.subarray(range.from, range.to));
  };
  const server = createServer((request, response) => {
    requests.push(`${request.method} ${request.url} ${request.headers.range ?? ""}`.trim());
    const [, first, ...rest] = new URL(request.url, "http://x").pathname.split("/");
    if (first === "result") {
      const parts = [];
      request.on("data", (part) => parts.push(part));
      request.on("end", () => {
        response.end();
        results(JSON.parse(Buffer.concat(parts)));
      });
      return;
    }
    try {
      if (!(first in served)) return clip(first, rest.join("/"), request, response);
      const path = join(served[first], ...rest);
      const type = types[path.split(".").at(-1)] ?? "application/octet-stream";
      response.writeHead(200, {
        "Content-Type": type,
        "Content-Security-Policy": policy,
        "Cache-Control": "max-age=60",
      });
      response.end(readFileSync(path));
    } catch {
      response.writeHead(404).end();
    }
  });
  new WebSocketServer({ server }).on("connection", (socket, request) => {
    const { head, groups } = messagesOf(files[new URL(request.url, "http://x").pathname.split("/").at(-1)]);
    for (const part of [head, ...groups.flat()]) socket.send(part);
    socket.send('{"type":"end"}');
    socket.close(1000);
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const close = () => {
    server.closeAllConnections();
    server.close();
  };
  return { url: `http://127.0.0.1:${server.address().port}`, requests, close };
}

// Debian's package node-ws; Node has no client of its own before version 22, and no server at all.
export const { WebSocket, WebSocketServer } = createRequire(import.meta.url)("/usr/share/nodejs/ws");

/** Header with configuration block, and the chunks of each group, as fvvserve sends them in messages. */
export function messagesOf(file) {
  const bytes = readFileSync(file);
  const groups = [];
  let at = 24;
  let head;
  while (at < bytes.length) {
    const type = bytes.toString("latin1", at, at + 4);
    const end = at + 32 + 8 * Math.ceil(bytes.readUInt32LE(at + 16) / 8);
    if (type === "INDX" || type === "FOOT") break;
    if (type === "GRUP") {
      head ??= bytes.subarray(0, at);
      groups.push([]);
    }
    groups.at(-1)?.push(bytes.subarray(at, end));
    at = end;
  }
  return { head, groups };
}
