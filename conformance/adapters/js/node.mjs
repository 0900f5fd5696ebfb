// Speaks the protocol of conformance/PROTOCOL.md for @fvv/decoder in Node: libfvv as WebAssembly.

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";

import { createDecoder } from "../../../js/decoder/dist/index.js";
import { serve } from "./protocol.mjs";
import { answerTo, questions } from "./questions.mjs";
import { parts, report } from "./report.mjs";

const { version } = JSON.parse(readFileSync(new URL("../../../js/decoder/package.json", import.meta.url)));
const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");
const hello = { name: "wasm in Node", version, format: "0.2", parts: [...parts, ...questions] };
const options = { worker: false };
await serve(
  hello,
  (bytes, live) => report(createDecoder, sha256, bytes, live, options),
  (bytes, request) => answerTo(createDecoder, bytes, request, options),
);
process.exit();
