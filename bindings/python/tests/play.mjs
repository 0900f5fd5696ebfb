// Opens a page in Chromium, waits until its <fvv-player> has shown frames, and prints what it saw as JSON; with a path, takes
// a picture of the page. The player may be in an <iframe>. usage: node play.mjs URL [PICTURE.png]

import { missingBrowser, openBrowser } from "../../../js/testing/browser.mjs";

const [url, picture] = process.argv.slice(2);
const missing = missingBrowser("chromium");
if (missing) {
  console.log(JSON.stringify({ missing }));
  process.exit(0);
}
const browser = await openBrowser("chromium");
try {
  const page = await browser.newPage(url, 800, 450);
  const found = async () => {
    for (const frame of page.frames()) {
      const seen = await frame
        .evaluate(() => {
          const player = document.querySelector("fvv-player");
          return player?.stats && { shown: player.stats.framesShown, error: player.error?.message ?? null };
        })
        .catch(() => null);
      if (seen) return seen;
    }
    return { shown: 0, error: null };
  };
  let seen = await found();
  for (let i = 0; i < 300 && seen.shown < 4 && !seen.error; i++) {
    await new Promise((done) => setTimeout(done, 100));
    seen = await found();
  }
  if (picture) await page.screenshot({ path: picture });
  console.log(JSON.stringify({ ...seen, workers: page.workers().length, troubles: browser.troubles }));
} finally {
  await browser.close();
}
