// The decoder's worker, which reports every VideoFrame that it opens and closes to the page.

import { countOpenFrames, moment } from "./open_frames.js";

const channel = new BroadcastChannel("video frames");
channel.addEventListener("message", ({ data }) => data === "settle" && channel.postMessage("settled"));
countOpenFrames((change) => channel.postMessage([moment(), change]));

await import("../../../decoder/dist/worker.js");
