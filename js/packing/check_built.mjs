// Runs before a package is packed, in its folder: refuses packages that are not built, and, before they are published, those
// whose addresses are still the placeholders of this repository.

import { existsSync, readFileSync } from "node:fs";

const { name, exports, files, homepage } = JSON.parse(readFileSync("package.json", "utf8"));
const HINTS = {
  "@fvv/decoder": "js/decoder/wasm/build.sh build/wasm",
  "@fvv/video-fallback": "js/video-fallback/wasm/build.sh build/wasm",
};

const targets = Object.values(exports).flatMap((entry) => (typeof entry === "string" ? entry : Object.values(entry)));
const missing = [...targets, ...files].find((path) => !existsSync(path));
const refuse = (why) => {
  console.error(`${name} cannot be packed: ${why}`);
  process.exit(1);
};
if (missing) refuse(`${missing} is missing${HINTS[name] ? `; build it with ${HINTS[name]}` : ""}`);
if (process.env.npm_command === "publish" && new URL(homepage).hostname.endsWith(".example"))
  refuse(`homepage, repository and bugs in package.json are placeholders (${homepage}): set the addresses first`);
