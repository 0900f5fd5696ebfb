// The built documentation (build/docs), served by fvvserve under its content policy: main pages in Chromium, wide and narrow,
// light and dark, by axe-core; every link and anchor of every page. FVV_PICTURES=FOLDER keeps screenshots.

import assert from "node:assert/strict";
import { cpSync, existsSync, mkdirSync, readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { violationsOf } from "../../testing/axe.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { root, serveFolder } from "../../testing/served.mjs";

const built = join(root, "build/docs");
const pictures = process.env.FVV_PICTURES;
const SIZES = { 1280: [1280, 800], 390: [390, 844] };
const PAGES = [
  "",
  "guide/your-own-capture",
  "guide/concepts",
  "spec/fvv",
  "c/stream",
  "python/api",
  "js/api/decoder/",
  "cli/fvvmux",
].map((path) => (/(^|\/)$/.test(path) ? path : `${path}.html`));

test("every link of every page leads to a page and an anchor", () => {
  const pages = readdirSync(built, { recursive: true }).filter((name) => name.endsWith(".html"));
  assert.ok(pages.length > 100, `${pages.length} pages`);
  const texts = new Map(pages.map((name) => [name, readFileSync(join(built, name), "utf8")]));
  const anchors = new Map();
  const hasAnchor = (page, anchor) => {
    if (!anchors.has(page))
      anchors.set(page, new Set([...texts.get(page).matchAll(/\sid="([^"]+)"/g)].map(([, name]) => name)));
    return anchors.get(page).has(anchor);
  };
  const dead = new Map(); // from the address to the first page that has it
  for (const [page, text] of texts)
    for (const [, address] of text.matchAll(/\s(?:href|src)="([^"]*)"/g)) {
      if (/^(?:[a-z]+:|\/\/)/.test(address)) continue;
      const url = new URL(address.replace(/&amp;/g, "&"), `http://host/docs/${page}`);
      if (!url.pathname.startsWith("/docs/")) continue; // of the demo site
      let target = decodeURIComponent(url.pathname.slice("/docs/".length));
      if (target === "" || target.endsWith("/")) target += "index.html";
      if (!existsSync(join(built, target)) && existsSync(join(built, `${target}.html`))) target += ".html";
      const anchor = decodeURIComponent(url.hash.slice(1));
      if (!existsSync(join(built, target))) dead.set(address, page);
      else if (anchor && texts.has(target) && !hasAnchor(target, anchor)) dead.set(address, `${page}, for the anchor`);
    }
  assert.deepEqual(Object.fromEntries(dead), {});
});

describe("pages", { skip: missingBrowser("chromium") }, () => {
  let served, browser;
  before(async () => {
    served = await serveFolder();
    cpSync(built, join(served.folder, "docs"), { recursive: true });
    browser = await openBrowser();
  });
  after(async () => {
    await browser?.close();
    served?.close();
  });

  for (const [number, path] of PAGES.entries())
    test(`/docs/${path}`, async () => {
      const faults = [];
      for (const scheme of ["light", "dark"])
        for (const [width, size] of Object.entries(SIZES)) {
          // Half of the pages wide and light, and narrow and dark, the others the other way, unless all are to be seen.
          if (!pictures && (width === "390") === ((scheme === "dark") === (number % 2 === 1))) continue;
          const page = await browser.newPage("about:blank", ...size);
          await page.emulateMediaFeatures([
            { name: "prefers-color-scheme", value: scheme },
            { name: "prefers-reduced-motion", value: "reduce" },
          ]);
          await page.goto(`${served.url}docs/${path}`);
          await page.waitForSelector("#app [class*=VPNav]");
          assert.equal(
            await page.evaluate(() => document.documentElement.classList.contains("dark")),
            scheme === "dark",
          );
          if (pictures) {
            mkdirSync(pictures, { recursive: true });
            await page.screenshot({ path: join(pictures, `docs-${path.replaceAll("/", "_")}-${width}-${scheme}.png`) });
          }
          const [wide, room] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
          if (wide > room) faults.push(`${width} ${scheme}: ${wide} pixels in ${room}`);
          for (const violation of await violationsOf(page)) faults.push(`${width} ${scheme}: ${violation}`);
          await page.close();
        }
      assert.deepEqual([...faults, ...browser.troubles.splice(0)], []);
    });

  test("the search finds a clause and opens its page", async () => {
    const page = await browser.newPage("about:blank", ...SIZES[1280]);
    await page.goto(`${served.url}docs/`, { waitUntil: "networkidle0" });
    await page.click("#local-search button");
    await page.waitForSelector("#localsearch-input");
    await page.type("#localsearch-input", "continuity counter");
    await page.waitForSelector(".results a");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => location.pathname.includes("/spec/fvv"));
    assert.deepEqual(browser.troubles.splice(0), []);
    await page.close();
  });
});
