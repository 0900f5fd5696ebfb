// Runs in a browser: plays a stream with a ladder at its pace, and posts the rung of each frame (ladder.test.mjs).

import { createDecoder } from "../dist/index.js";

const post = (found) => fetch("/result", { method: "POST", body: JSON.stringify(found) });
try {
  const decoder = await createDecoder({ source: "/range/ladder", video: "encoded" });
  const began = performance.now();
  const frames = [];
  for await (const frame of decoder) {
    const { rung, samples, meshes, seconds } = frame;
    frames.push({ rung, tracks: [...samples, ...meshes].map(({ track }) => track) });
    frame.close();
    await new Promise((resolve) => setTimeout(resolve, Math.max(0, began + 1000 * seconds - performance.now())));
  }
  const rungs = decoder.rungs.map(({ tracks }) => tracks);
  decoder.close();
  await post({ frames, rungs });
} catch (error) {
  await post({ error: `${error.message}\n${error.stack}` });
}
