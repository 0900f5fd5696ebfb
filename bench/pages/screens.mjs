// Ten pictures of the player as people meet it, to be looked at: node screens.mjs FOLDER CLIP.fvv [REAL.fvv]. CLIP: with +y up, and
// an environment. REAL: of a person who was filmed. Writes FOLDER/NAME.png, and where fvvrender can draw the same view
// FOLDER/NAME-fvvrender.png. Prints JSON: of those the PSNR of the two, of what is away from edges, in dB.

import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

import { openBrowser } from "../../js/testing/browser.mjs";
import { serveFolder, tool } from "../../js/testing/served.mjs";
import { bundle } from "../../js/three/bundle.mjs";
import { shapedProxy } from "../network/shaped_proxy.mjs";

const { PNG } = createRequire(new URL("../../js/package.json", import.meta.url))("pngjs");

const LINK = { bitsPerSecond: 8e6, roundTripMs: 40 };
const SIZE = [960, 540];
const PATIENCE = 120_000;
/** Of luma between neighbours in the picture of fvvrender: more is an edge, whose place differs by fractions of a pixel. */
const EDGE = 12;
const here = (name) => fileURLToPath(new URL(name, import.meta.url));

const [folder, clip, real] = process.argv.slice(2);
if (!clip) {
  console.error("usage: node screens.mjs FOLDER CLIP.fvv [REAL.fvv]");
  process.exit(2);
}

const lumaOf = ({ data, width, height }) =>
  Float32Array.from(
    { length: width * height },
    (_, i) => (2 * data[4 * i] + 5 * data[4 * i + 1] + data[4 * i + 2]) / 8,
  );

/** dB, of two pictures of one size. */
function psnrAwayFromEdges(drawn, wanted) {
  const [a, b] = [lumaOf(drawn), lumaOf(wanted)];
  const { width, height } = wanted;
  let [squares, count] = [0, 0];
  for (let y = 1; y < height - 1; y++)
    for (let x = 1; x < width - 1; x++) {
      const i = y * width + x;
      const around = [b[i - 1], b[i + 1], b[i - width], b[i + width]];
      if (Math.max(...around) - Math.min(...around) > EDGE) continue;
      squares += (a[i] - b[i]) ** 2;
      count++;
    }
  return 10 * Math.log10((255 * 255 * count) / squares);
}

const served = await serveFolder();
const proxy = await shapedProxy(Number(new URL(served.url).port), LINK);
const browser = await openBrowser();
const figures = {};

/** A page with a player. over: the base of its address. */
async function open(over, attributes, [width, height] = SIZE, more = {}) {
  const page = await browser.newPage("about:blank", width, height);
  await page.setViewport({ width, height, ...more });
  await page.goto(`${over}screens_page.html?${new URLSearchParams({ src: "clip.fvv", ...attributes })}`);
  await page.waitForFunction(() => window.player, { timeout: PATIENCE });
  return page;
}
const until = (page, condition) => page.waitForFunction(condition, { timeout: PATIENCE });
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
/** Waits until the best rung is there and nothing changes any more. */
async function settle(page) {
  await until(page, () => window.player.readyState >= 2 && !window.player.seeking);
  await wait(3000); // for the environment, which comes after the first picture
  for (let before = -1, same = 0; same < 4; await wait(250)) {
    const now = await page.evaluate(() => window.player.stats.drawnFrames);
    same = now === before ? same + 1 : 0;
    before = now;
  }
}
async function keep(name, page) {
  writeFileSync(join(folder, `${name}.png`), await page.screenshot());
  await page.close();
}
/** The view of a player without controls, beside fvvrender's of the same pose. */
async function compare(name, page) {
  await settle(page);
  const pose = await page.evaluate(() => window.player.getPose());
  const drawn = PNG.sync.read(Buffer.from(await page.screenshot()));
  writeFileSync(join(folder, `${name}.png`), PNG.sync.write(drawn));
  const wanted = join(folder, `${name}-fvvrender.png`);
  const focal = SIZE[1] / 2 / Math.tan((pose.fov * Math.PI) / 360);
  tool("fvvrender", clip, "-o", wanted, "--frame", "0", `--pose=${[...pose.eye, ...pose.target, ...pose.up].join(",")}`,
    "--focal", String(focal), "--size", SIZE.join("x"), "--samples", "3", "--force"); // prettier-ignore
  figures[name] = Number(psnrAwayFromEdges(drawn, PNG.sync.read(readFileSync(wanted))).toFixed(2));
  await page.close();
}

try {
  mkdirSync(folder, { recursive: true });
  await bundle(here("screens_page.js"), [here("screens_page.html"), here("screens_page.css")], served.folder);
  copyFileSync(clip, join(served.folder, "clip.fvv"));
  if (real) copyFileSync(real, join(served.folder, "real.fvv"));

  const slow = `http://127.0.0.1:${proxy.port}/`;
  await (await open(slow, {})).close(); // the code is kept, and revalidated
  const first = await open(slow, { src: "clip.fvv?first" });
  await wait(1000);
  await keep("01-first-second", first);

  const paused = await open(slow, { src: "clip.fvv?paused", autoplay: "", muted: "" });
  await until(paused, () => window.player.currentTime > 2);
  await paused.evaluate(() => window.player.pause());
  await wait(1000);
  await keep("02-paused-after-2-seconds", paused);

  const plain = { "pixel-ratio": "1" };
  const bare = (attributes) => open(served.url, { ...plain, ...attributes });
  const face = await bare({});
  await face.evaluate(() => (window.player.controls = false));
  const { head, middle } = await face.evaluate(() => window.findHead("clip.fvv"));
  const target = [head[0], head[1] - 0.12, head[2]];
  const towards = [middle[0] - head[0], middle[2] - head[2]];
  const far = Math.hypot(...towards);
  const eye = [target[0] + (0.7 * towards[0]) / far, target[1] + 0.05, target[2] + (0.7 * towards[1]) / far];
  await face.evaluate((pose) => window.player.setPose(pose), { eye, target });
  await compare("03-face-at-arms-length", face);

  for (const [name, attributes] of [
    ["04-from-above", { "camera-orbit": "0deg 12deg auto" }],
    ["05-from-below", { "camera-orbit": "0deg 105deg auto" }],
  ]) {
    const page = await bare(attributes);
    await page.evaluate(() => (window.player.controls = false));
    await compare(name, page);
  }
  const pole = await bare({});
  await pole.evaluate(() => (window.player.controls = false));
  await until(pole, () => window.player.readyState >= 2);
  await pole.evaluate(() => window.player.snapToCamera(window.player.cameras[0].id));
  await pole.evaluate(() => window.player.setPose({ up: [0, 1, 0] }));
  await compare("06-behind-the-first-camera", pole);

  const phone = await open(served.url, { autoplay: "", muted: "" }, [390, 844], {
    deviceScaleFactor: 2,
    isMobile: true,
    hasTouch: true,
  });
  await until(phone, () => window.player.currentTime > 0.5);
  await wait(4000);
  await keep("07-phone-playing-untouched", phone);

  const arabic = await open(served.url, { lang: "ar", dir: "rtl" });
  await settle(arabic);
  await keep("08-right-to-left", arabic);

  if (real) {
    const person = await open(served.url, { src: "real.fvv" });
    await settle(person);
    await keep("09-real-person", person);
  } else console.error("screens: 09-real-person is left out: no stream of a person who was filmed was given");

  const embed = await open(served.url, {}, [640, 480]);
  await settle(embed);
  await keep("10-four-to-three", embed);
  if (browser.troubles.length) throw new Error(browser.troubles.join("\n"));
  console.log(JSON.stringify(figures));
} finally {
  await browser.close();
  proxy.close();
  served.close();
}
