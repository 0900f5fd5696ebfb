// The decoder's worker as in a browser without WebCodecs.

delete globalThis.VideoDecoder;
delete globalThis.VideoFrame;

await import("/dist/worker.js");
