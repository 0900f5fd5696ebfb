// Measures playback of a clip with WebGL in software: node player.mjs CLIP.fvv [chromium|firefox]. Prints JSON: frames per
// second with depth maps and with bits, the time of a picture whose cameras are weighted by the viewer's direction over that by
// the normal alone, draw calls and uploads per frame, and the time to the first picture over 8 Mbit/s and 40 ms. Code has been
// loaded before, but is revalidated, as fvvserve requires. node player.mjs --ladder CLIP.fvv: of a clip with a ladder, over the
// same link, the time to the first picture that is seen, and how like the finest rung's it is.

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

/** measure: name of a function of the page, called for each round. Returns what it found, without the first round. */
async function overLink(browser, served, measure) {
  const proxy = await shapedProxy(Number(new URL(served.url).port), LINK);
  try {
    const page = await openPage(browser, `http://127.0.0.1:${proxy.port}/`);
    const found = [];
    // The first round loads the code; URLs differ so that clips are not cached.
    for (let round = 0; round <= ROUNDS; round++)
      found.push(await page.evaluate((name, source) => window[name](source), measure, `/clip.fvv?${round}`));
    return found.slice(1);
  } finally {
    proxy.close();
  }
}

async function measurePlayback(browser, served) {
  const page = await openPage(browser, served.url);
  const rate = async (visibleBy) => {
    const { blendMs, ...found } = await page.evaluate((by) => window.measureRate("/clip.fvv", by), visibleBy);
    return { ...found, viewerOverPaper: Math.min(...blendMs.viewer) / Math.min(...blendMs.paper) };
  };
  const found = { depth: await rate("depth"), bits: await rate("bits") };
  found.auto = await page.evaluate(() => window.measureAuto("/clip.fvv"));
  await page.close();
  return { ...found, firstMs: median(await overLink(browser, served, "measureFirst")) };
}
async function measureLadder(browser, served) {
  const rounds = await overLink(browser, served, "measureGood");
  const of = (name) => median(rounds.map((round) => round[name]));
  return { coarseMs: of("coarseMs"), ms: of("ms"), ssim: of("ssim"), rung: of("rung"), rounds };
}

const hasLadder = process.argv[2] === "--ladder";
const [clip, browserName] = process.argv.slice(hasLadder ? 3 : 2);
const served = await serveFolder();
const browser = await openBrowser(browserName);
try {
  await bundle(here("player_page.js"), [here("player_page.html")], served.folder);
  copyFileSync(clip, join(served.folder, "clip.fvv"));
  const found = await (hasLadder ? measureLadder : measurePlayback)(browser, served);
  if (browser.troubles.length) throw new Error(browser.troubles.join("\n"));
  console.log(JSON.stringify(found));
} finally {
  await browser.close();
  served.close();
}
