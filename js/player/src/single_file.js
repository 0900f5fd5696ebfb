// The player, its decoder and the decoder's worker as one script, dist/fvv-player.min.js: a page imports it as a module, from
// any host, and it is its own worker.

import { FvvPlayer } from "./index.js";

export * from "./index.js";

const options = { type: "module", name: "fvv decoder" };

/** A worker's script has to be of the page's origin; a module that it imports need not be. */
function startWorker() {
  const { url } = import.meta;
  if (new URL(url).origin === location.origin) return new Worker(url, options);
  const address = URL.createObjectURL(new Blob([`import ${JSON.stringify(url)};`], { type: "text/javascript" }));
  const worker = new Worker(address, options);
  // Its first message is that it is ready.
  worker.addEventListener("message", () => URL.revokeObjectURL(address), { once: true });
  return worker;
}

if (typeof WorkerGlobalScope === "function" && globalThis instanceof WorkerGlobalScope)
  await import("@fvv/decoder/worker");
else FvvPlayer._startWorker = startWorker;
