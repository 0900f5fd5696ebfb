// The page in which a browser decodes. browser.mjs calls decode and ask.

import { createDecoder } from "../dist/index.js";
import { answerTo, ofDecoder } from "./questions.mjs";
import { report } from "./report.mjs";

const hex = (buffer) => Array.from(new Uint8Array(buffer), (byte) => byte.toString(16).padStart(2, "0")).join("");
const sha256 = async (bytes) => hex(await crypto.subtle.digest("SHA-256", bytes));

const bytesOf = (base64) => Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));

window.decode = (base64, live) => report(createDecoder, sha256, bytesOf(base64), live);
window.ask = (base64, request) => answerTo(ofDecoder, createDecoder, bytesOf(base64), request);
