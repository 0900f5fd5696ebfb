// The line protocol of conformance/PROTOCOL.md for a decoder in Node.

import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";

/**
 * hello: what the decoder says of itself. decode(bytes, live): a report. ask(bytes, request): the answer to a question on one
 * frame.
 */
export async function serve(hello, decode, ask) {
  const contentOf = ({ data, path }) => {
    const buffer = data === undefined ? readFileSync(path) : Buffer.from(data, "base64");
    return new Uint8Array(buffer.buffer, buffer.byteOffset, buffer.length);
  };
  const answer = async (request) => {
    if (request.op === "hello") return { protocol: 1, ...hello };
    if (request.op === "decode") return decode(contentOf(request), Boolean(request.live));
    if (hello.parts.includes(request.op)) return ask(contentOf(request), request);
    throw new Error(`${request.op}: no such operation`);
  };
  for await (const line of createInterface({ input: process.stdin })) {
    const request = JSON.parse(line);
    if (request.op === "quit") break;
    const found = await answer(request).catch(({ message }) => ({ error: message }));
    if (request.id !== undefined) found.id = request.id;
    process.stdout.write(`${JSON.stringify(found)}\n`);
  }
}
