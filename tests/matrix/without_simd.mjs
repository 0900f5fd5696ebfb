// For node --import: WebAssembly as in an engine without SIMD, where the decoder takes other modules.

const { validate } = WebAssembly;
// The decoder asks with a few bytes whether SIMD is there.
WebAssembly.validate = (bytes) => bytes.byteLength > 1000 && validate(bytes);
