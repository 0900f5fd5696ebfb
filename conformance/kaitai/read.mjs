// Reads streams by fvv.ksy, a third reading of the container, and prints for each a line of JSON: its file header and its chunks
// with offset, fields and a count of bytes, or the error. usage: node read.mjs FILE... (no FILE: paths from standard input)
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(new URL("../../js/package.json", import.meta.url));
const KaitaiStream = require("kaitai-struct").KaitaiStream ?? require("kaitai-struct");

/** The runtime's own is off by 2^32 for many negative numbers; here they are rounded to the nearest double. */
KaitaiStream.prototype.readS8le = function () {
  this.ensureBytesLeft(8);
  this.pos += 8;
  return Number(this._dataView.getBigInt64(this.pos - 8, true));
};

/** The class of the description, compiled. */
async function compile() {
  const source = readFileSync(new URL("fvv.ksy", import.meta.url), "utf8");
  const files = await require("kaitai-struct-compiler").compile(
    "javascript",
    require("js-yaml").load(source),
    null,
    false,
  );
  const module = { exports: {} };
  new Function("module", "exports", "require", files["Fvv.js"])(module, module.exports, require);
  return module.exports.Fvv ?? module.exports;
}

/** Numbers, texts and lists of a structure by name; bytes become their count. */
function plain(value) {
  if (value instanceof Uint8Array) return { bytes: value.length };
  if (Array.isArray(value)) return value.map(plain);
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  if (typeof value !== "object" || value === null) return value;
  if ("value" in value) return value.bytes.reduceRight((sum, byte) => 128 * sum + (byte & 127), 0); // ULEB128
  const names = Object.keys(value).filter((name) => !name.startsWith("_"));
  return Object.fromEntries(names.map((name) => [name, plain(value[name])]));
}

function read(Fvv, path) {
  const data = readFileSync(path);
  const stream = new Fvv(new KaitaiStream(data.buffer.slice(data.byteOffset, data.byteOffset + data.length)));
  let offset = 24;
  const chunks = stream.chunks.map((chunk) => {
    const { padding, payload, ...header } = plain(chunk);
    const out = { offset, ...header, payload };
    offset += 32 + chunk.payloadSize + padding.length;
    return out;
  });
  return { header: plain(stream.header), chunks };
}

const paths = process.argv.length > 2 ? process.argv.slice(2) : readFileSync(0, "utf8").split("\n").filter(Boolean);
const Fvv = await compile();
for (const path of paths) {
  let found;
  try {
    found = read(Fvv, path);
  } catch (error) {
    found = { error: String(error.message ?? error) };
  }
  console.log(JSON.stringify({ path, ...found }));
}
