// The page in which a browser decodes. browser.mjs calls decode.

import { createDecoder } from "../dist/index.js";
import { report } from "./report.mjs";

const hex = (buffer) => Array.from(new Uint8Array(buffer), (byte) => byte.toString(16).padStart(2, "0")).join("");
const sha256 = async (bytes) => hex(await crypto.subtle.digest("SHA-256", bytes));

window.decode = (base64, live) => {
  const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  return report(createDecoder, sha256, bytes, live);
};
