// A page in TypeScript: the element, and the decoder by itself in a worker that the page starts.

import { createDecoder } from "@fvv/decoder";
import workerUrl from "@fvv/decoder/worker?worker&url";
import "@fvv/player";
import { Renderer } from "@fvv/player/renderer";
import { texturingOf } from "@fvv/shading";
import { FvvObject3D } from "@fvv/three";

const player = document.querySelector("fvv-player")!;
player.addEventListener("camera-change", ({ detail }) => {
  document.body.dataset.moved = detail.source;
  // @ts-expect-error there is no third source
  console.assert(detail.source !== "other");
});
player.addEventListener("framechange", function () {
  document.body.dataset.frame = String(this.currentFrame);
});
player.addEventListener("warning", ({ detail }) => console.warn(detail.message));
player.addEventListener("error", () => console.error(player.error?.message));

const decoder = await createDecoder({
  source: new URL("clip.fvv", location.href),
  worker: new Worker(workerUrl, { type: "module" }),
});
const frame = await decoder.next();
document.body.dataset.decoded = String(frame?.mesh?.positions.length);
document.body.dataset.worker = String(decoder.inWorker);
frame?.close();
decoder.close();
console.assert([Renderer, texturingOf, FvvObject3D].every((value) => typeof value === "function"));
