// Speaks the protocol of conformance/PROTOCOL.md for @fvv/decoder in a browser, with its worker. usage: browser.mjs [chromium | firefox]

import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

import { serve as servePages } from "../../../js/decoder/test/server.mjs";
import { missingBrowser, openBrowser } from "../../../js/testing/browser.mjs";
import { serve } from "./protocol.mjs";
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
await serve({ name, version, format: "0.2", parts }, (bytes, live) =>
  page.evaluate((base64, isLive) => window.decode(base64, isLive), Buffer.from(bytes).toString("base64"), live),
);
await browser.close();
server.close();
process.exit();
