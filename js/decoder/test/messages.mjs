// What a server of live streams sends, message by message.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

// Debian's package node-ws; Node has no client of its own before version 22, and no server at all.
export const { WebSocket, WebSocketServer } = createRequire(import.meta.url)("/usr/share/nodejs/ws");

/** Header and block, and the chunks of each group, as fvvserve cuts them. */
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
