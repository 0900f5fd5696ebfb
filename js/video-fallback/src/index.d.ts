/** The module for createDecoder({ videoFallback: () => import("@fvv/video-fallback") }), compiled once for all decoders. */
export function compile(): Promise<WebAssembly.Module>;
