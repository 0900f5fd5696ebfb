delete globalThis.VideoDecoder;
delete globalThis.VideoFrame;
