// Measures playback with what FVV_ANGLE names: node rates.mjs CLIP.fvv... Prints JSON: the name of what draws, and for each clip
// pictures per second at 1920x1080 and 3840x2160, by depth maps and by bits, also with a processor throttled as a phone's.

import { copyFileSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";

import { openBrowser } from "../../js/testing/browser.mjs";
import { serveFolder } from "../../js/testing/served.mjs";
import { bundle } from "../../js/three/bundle.mjs";

const SIZES = { "1080p": { width: 1920, height: 1080 }, "4k": { width: 3840, height: 2160 } };
/** Chromium's tools for developers call this a mid-tier phone. */
const THROTTLED = 4;
const here = (name) => fileURLToPath(new URL(name, import.meta.url));

/** The name that the driver gives. */
const drawnBy = () => {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return null;
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return name;
};

const served = await serveFolder();
const browser = await openBrowser("chromium");
try {
  await bundle(here("../player_page.js"), [here("../player_page.html")], served.folder);
  const page = await browser.newPage(`${served.url}player_page.html`, 1000, 700);
  await page.waitForSelector("[data-ready]");
  const renderer = await page.evaluate(drawnBy);
  const clips = {};
  for (const clip of process.argv.slice(2)) {
    const name = basename(clip, ".fvv");
    copyFileSync(clip, join(served.folder, `${name}.fvv`));
    const rate = async (visibleBy, size) => {
      const measured = (by, source, pixels) => window.measureRate(source, by, pixels);
      const { playing, still, frames } = await page.evaluate(measured, visibleBy, `/${name}.fvv`, size);
      return { playing, still, frames };
    };
    const found = {};
    for (const [label, size] of Object.entries(SIZES))
      found[label] = { depth: await rate("depth", size), bits: await rate("bits", size) };
    await page.emulateCPUThrottling(THROTTLED);
    found.throttled = { bits: await rate("bits", SIZES["1080p"]) };
    await page.emulateCPUThrottling(1);
    clips[name] = found;
  }
  if (browser.troubles.length) throw new Error(browser.troubles.join("\n"));
  console.log(JSON.stringify({ renderer, throttledBy: THROTTLED, clips }));
} finally {
  await browser.close();
  served.close();
}
