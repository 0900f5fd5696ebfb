// A decoder under test in JavaScript, over @fvv/decoder: meshes alone.

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";

// In a project of your own: import { createDecoder } from "@fvv/decoder".
import { createDecoder } from "../../js/decoder/dist/index.js";

const sha256 = (array) => createHash("sha256").update(array).digest("hex");

async function decode(source) {
  const found = { status: "whole", issues: [], frames: [] };
  const damage = () => (found.status = "damaged");
  try {
    const decoder = await createDecoder({ source, video: "encoded", rung: 0 });
    // "no-index" is a warning too, and live streams have none; "truncated" says that bytes are missing.
    decoder.addEventListener("warning", ({ detail: { severity, code } }) => {
      if (severity === "error" || ["gap", "truncated"].includes(code)) damage();
    });
    for await (const frame of decoder) {
      const arrays = {};
      for (const { track, lattice, faces, positions, uvs, normals } of frame.meshes)
        for (const [name, array] of Object.entries({ lattice, faces, positions, uvs, normals }))
          if (array) arrays[`mesh/${track}/${name}`] = sha256(array);
      found.frames.push({ time: String(frame.time), arrays });
    }
    decoder.close();
  } catch {
    found.status = "refused";
  }
  return found;
}

for await (const line of createInterface({ input: process.stdin })) {
  const { op, id, path, data } = JSON.parse(line);
  if (op === "quit") break;
  const answer =
    op === "hello"
      ? { protocol: 1, name: "example.mjs", version: "1", format: "0.2", parts: ["mesh"] }
      : { id, ...(await decode(new Uint8Array(path ? readFileSync(path) : Buffer.from(data, "base64")))) };
  console.log(JSON.stringify(answer));
}
