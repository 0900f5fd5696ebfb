// Runs in a browser: measures the time from createDecoder to the first frame with its decoded picture
// (bench/network/first_frame.mjs).

import { createDecoder } from "../dist/index.js";

const post = (found) => fetch("/result", { method: "POST", body: JSON.stringify(found) });
try {
  // Loads the package and the worker's script into the browser's cache first.
  const modules = ["core", "projection", "draco"].map((name) => `../dist/${name}.wasm.js`);
  await Promise.all(modules.map((module) => import(module)));
  const warm = await createDecoder();
  warm.close();
  const begin = performance.now();
  const decoder = await createDecoder({ source: "/range/clip" });
  const frame = await decoder.next();
  const ms = performance.now() - begin;
  if (!frame.mesh || !frame.picture()) throw new Error("the first frame lacks its mesh or its picture");
  frame.close();
  decoder.close();
  await post({ ms });
} catch (error) {
  await post({ error: `${error.message}\n${error.stack}` });
}
