// Writes a wasm module as a JavaScript module: compressed, in Base64. usage: node pack.mjs IN.wasm OUT.wasm.js [NOTICE]
// NOTICE: what the licence of its code asks for, in a comment that bundlers and minifiers keep.
import { readFileSync, writeFileSync } from "node:fs";
import { brotliCompressSync, gzipSync } from "node:zlib";

const [input, output, notice] = process.argv.slice(2);
const wasm = readFileSync(input);
// A fixed operating system in the header: the same bytes on every machine.
const packed = gzipSync(wasm, { level: 9 });
packed[9] = 255;
const legal = notice ? `/*!\n${notice.trim()}\n*/\n` : "";
const text = `${legal}export const base64 =\n  "${packed.toString("base64")}";\n`;
writeFileSync(output, text);
console.log(
  `${output}: ${wasm.length} bytes, brotli ${brotliCompressSync(wasm).length}; module brotli ${brotliCompressSync(text).length}`,
);
