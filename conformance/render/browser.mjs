// Renders by the protocol of conformance/PROTOCOL.md, in a headless browser.
// usage: node browser.mjs player|three [chromium|firefox]

import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

import { missingBrowser, openBrowser } from "../../js/testing/browser.mjs";
import { serveFolder } from "../../js/testing/served.mjs";
import { bundle } from "../../js/three/bundle.mjs";

const [which, kind = "chromium"] = process.argv.slice(2);
if (!["player", "three"].includes(which) || !["chromium", "firefox"].includes(kind)) {
  console.error("usage: node browser.mjs player|three [chromium|firefox]");
  process.exit(2);
}
const missing = missingBrowser(kind);
if (missing) {
  console.error(`browser.mjs: ${missing}`);
  process.exit(1);
}

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const served = await serveFolder();
await bundle(here("page.js"), [here("page.html")], served.folder);
const browser = await openBrowser(kind);
const page = await browser.newPage(`${served.url}page.html`);
await page.waitForSelector("[data-ready]");

const { version } = JSON.parse(readFileSync(here(`../../js/${which}/package.json`), "utf8"));
let streams = 0;

async function render({ id, path, data, frame, view }) {
  const name = `stream${streams++}.fvv`;
  const target = join(served.folder, name);
  if (path) copyFileSync(path, target);
  else writeFileSync(target, Buffer.from(data, "base64"));
  try {
    return { id, ...(await page.evaluate((...of) => window.render(...of), which, `/${name}`, frame, view)) };
  } catch (error) {
    return { id, error: error.message };
  }
}

const answers = {
  hello: () => ({ protocol: 1, name: `${which} in ${kind}`, version, format: "0.2", parts: ["render"] }),
  render,
};

for await (const line of createInterface({ input: process.stdin })) {
  const request = JSON.parse(line);
  if (request.op === "quit") break;
  const answer = await (answers[request.op] ?? (() => ({ id: request.id, error: `unknown op ${request.op}` })))(
    request,
  );
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
await browser.close();
served.close();
