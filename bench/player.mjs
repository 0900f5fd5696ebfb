// Measures playback of a clip with WebGL in software: node player.mjs CLIP.fvv [chromium|firefox]. Prints JSON: frames per
// second with depth maps and with bits, the time of a picture whose cameras are weighted by the viewer's direction over that by
// the normal alone, draw calls and uploads per frame, and the time to the first picture over 8 Mbit/s and 40 ms. Code has been
// loaded before, but is revalidated, as fvvserve requires.

import { copyFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { openBrowser } from "../js/testing/browser.mjs";
import { serveFolder } from "../js/testing/served.mjs";
import { bundle } from "../js/three/bundle.mjs";
import { shapedProxy } from "./network/shaped_proxy.mjs";

const LINK = { bitsPerSecond: 8e6, roundTripMs: 40 };
const ROUNDS = 5;
const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const median = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

async function openPage(browser, url) {
  const page = await browser.newPage(`${url}player_page.html`, 1000, 700);
  await page.waitForSelector("[data-ready]");
  return page;
}

async function firstPictures(browser, served) {
  const proxy = await shapedProxy(Number(new URL(served.url).port), LINK);
  try {
    const page = await openPage(browser, `http://127.0.0.1:${proxy.port}/`);
    const times = [];
    // The first round loads the code; URLs differ so that clips are not cached.
    for (let round = 0; round <= ROUNDS; round++)
      times.push(await page.evaluate((source) => window.measureFirst(source), `/clip.fvv?${round}`));
    return median(times.slice(1));
  } finally {
    proxy.close();
  }
}

const served = await serveFolder();
const browser = await openBrowser(process.argv[3]);
try {
  await bundle(here("player_page.js"), [here("player_page.html")], served.folder);
  copyFileSync(process.argv[2], join(served.folder, "clip.fvv"));
  const page = await openPage(browser, served.url);
  const rate = async (visibleBy) => {
    const { blendMs, ...found } = await page.evaluate((by) => window.measureRate("/clip.fvv", by), visibleBy);
    return { ...found, viewerOverPaper: Math.min(...blendMs.viewer) / Math.min(...blendMs.paper) };
  };
  const found = { depth: await rate("depth"), bits: await rate("bits") };
  await page.close();
  const firstMs = await firstPictures(browser, served);
  if (browser.troubles.length) throw new Error(browser.troubles.join("\n"));
  console.log(JSON.stringify({ ...found, firstMs }));
} finally {
  await browser.close();
  served.close();
}
