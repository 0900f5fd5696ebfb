// Prints how many rules of accessibility the pages of the demo site and of the documentation violate, at two widths, light and
// dark; which they are goes to standard error. usage: node axe.mjs DOCS_FOLDER CLIP.fvv

import { cpSync } from "node:fs";
import { join } from "node:path";

import { buildSite } from "../../js/site/build.mjs";
import { violationsOf } from "../../js/testing/axe.mjs";
import { openBrowser } from "../../js/testing/browser.mjs";
import { serveFolder, tool } from "../../js/testing/served.mjs";

const PAGES = [
  "",
  "embed.html",
  "five-lines.html",
  "three/",
  "docs/",
  "docs/guide/your-own-capture.html",
  "docs/guide/concepts.html",
  "docs/spec/fvv.html",
  "docs/spec/registry.html",
  "docs/c/stream.html",
  "docs/cli/fvvmux.html",
];
const SIZES = [
  [1280, 800],
  [390, 844],
];

const [docs, clip] = process.argv.slice(2);
const served = await serveFolder();
const browser = await openBrowser();
let count = 0;
try {
  await buildSite(served.folder, (path) => JSON.parse(tool("fvvinfo", "--json", path)).files[0], [clip]);
  cpSync(docs, join(served.folder, "docs"), { recursive: true });
  for (const path of PAGES)
    for (const size of SIZES)
      for (const scheme of ["light", "dark"]) {
        const page = await browser.newPage("about:blank", ...size);
        await page.emulateMediaFeatures([
          { name: "prefers-color-scheme", value: scheme },
          { name: "prefers-reduced-motion", value: "reduce" },
        ]);
        await page.goto(`${served.url}${path}`);
        for (const violation of await violationsOf(page)) {
          count++;
          console.error(`/${path}, ${size[0]} wide, ${scheme}: ${violation}`);
        }
        await page.close();
      }
} finally {
  await browser.close();
  served.close();
}
console.log(count);
