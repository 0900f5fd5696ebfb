// Speaks the protocol of conformance/PROTOCOL.md for @fvv/decoder in a browser, with its worker. usage: browser.mjs [chromium | firefox]

import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

import { serve as servePages } from "../../../js/decoder/test/server.mjs";
import { missingBrowser, openBrowser } from "../../../js/testing/browser.mjs";
import { serve } from "./protocol.mjs";
import { ofDecoder } from "./questions.mjs";
import { parts } from "./report.mjs";

const name = process.argv[2] ?? "chromium";
const missing = missingBrowser(name);
if (missing) {
  console.error(missing);
  process.exit(1);
}
const { version } = JSON.parse(readFileSync(new URL("../../../js/decoder/package.json", import.meta.url)));
const server = await servePages({}, () => {}, { adapter: fileURLToPath(new URL(".", import.meta.url)) });
const browser = await openBrowser(name);
const page = await browser.newPage(`${server.url}/adapter/page.html`);
await page.waitForFunction(() => window.decode);
const base64Of = (bytes) => Buffer.from(bytes).toString("base64");
await serve(
  { name, version, format: "0.2", parts: [...parts, ...Object.keys(ofDecoder)] },
  (bytes, live) => page.evaluate((base64, isLive) => window.decode(base64, isLive), base64Of(bytes), live),
  (bytes, request) => page.evaluate((base64, asked) => window.ask(base64, asked), base64Of(bytes), request),
);
await browser.close();
server.close();
process.exit();
