// Speaks the protocol of conformance/PROTOCOL.md for @fvv/decoder in Node, libfvv as WebAssembly, and for the weights of cameras
// of @fvv/analysis.

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";

import { weightsAt } from "../../../js/analysis/src/index.js";
import { createDecoder } from "../../../js/decoder/dist/index.js";
import { serve } from "./protocol.mjs";
import { answerTo, ofDecoder } from "./questions.mjs";
import { parts, report } from "./report.mjs";

const { version } = JSON.parse(readFileSync(new URL("../../../js/decoder/package.json", import.meta.url)));
const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

function weigh(frame, { mesh: track, places }) {
  const weights = places.map(({ eye, ...place }) => {
    const found = weightsAt(frame, { track, ...place }, eye);
    return Object.fromEntries(found.map(({ camera, weight }) => [camera, weight]));
  });
  return { weights };
}

const answers = { ...ofDecoder, weigh };
const hello = { name: "wasm in Node", version, format: "0.2", parts: [...parts, ...Object.keys(answers)] };
const options = { worker: false };
await serve(
  hello,
  (bytes, live) => report(createDecoder, sha256, bytes, live, options),
  (bytes, request) => answerTo(answers, createDecoder, bytes, request, options),
);
process.exit();
