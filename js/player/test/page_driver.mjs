// Operates the page of the player as a user does, and reads what it shows.

import { copyFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { openBrowser } from "../../testing/browser.mjs";
import { serveFolder } from "../../testing/served.mjs";
import { bundle } from "../../three/bundle.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

/**
 * Opens the page of the player in a browser, with a clip. live: as serveFolder takes it. sound: as openBrowser does. close()
 * closes everything.
 */
export async function openPage(name, clip, live, sound = false) {
  const served = await serveFolder(live);
  let browser;
  const close = async () => {
    await browser?.close();
    served.close();
  };
  try {
    await bundle(here("page.js"), [here("page.html"), here("page.css")], served.folder);
    copyFileSync(clip, join(served.folder, "players.fvv"));
    browser = await openBrowser(name, { sound });
    return { served, browser, page: await browser.newPage(`${served.url}page.html`, 720, 560), close };
  } catch (error) {
    await close();
    throw error;
  }
}

/** page(): returns puppeteer's page. screens: folder for screenshots; name: of the browser, for file names. */
export function drivePage(page, screens, name) {
  const ask = (expression, ...values) => page().evaluate(expression, ...values);
  const until = (condition, ...values) => page().waitForFunction(condition, { timeout: 60000, polling: 50 }, ...values);
  const events = () => ask(() => window.events.splice(0).filter((type) => type !== "camera-change"));
  const screen = (what) => page().screenshot({ path: join(screens, `player-${name}-${what}.png`) });
  /** The box of an element in the shadow tree of the player, in pixels of the page. */
  const boxOf = (selector) =>
    ask((selector) => {
      const node = window.player.shadowRoot.querySelector(selector);
      node.scrollIntoView({ block: "nearest" });
      const { x, y, width, height } = node.getBoundingClientRect();
      return { x, y, width, height };
    }, selector);
  const click = async (selector) => {
    const { x, y, width, height } = await boxOf(selector);
    await page().mouse.click(x + width / 2, y + height / 2);
  };
  const control = (part) => `.bar [part~="${part}"]`;
  const press = async (key) => {
    await ask(() => window.player.shadowRoot.querySelector(".surface").focus());
    await page().keyboard.press(key);
  };
  /** The fraction of coloured pixels; background and grid are grey. */
  const colourful = () =>
    ask(() => {
      const { data } = window.player._stage.renderer.readPixels();
      let count = 0;
      for (let i = 0; i < data.length; i += 4)
        count += Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 40;
      return count / (data.length / 4);
    });
  const orbit = () => ask(() => window.player.getCameraAttributes().cameraOrbit.split(" ").map(parseFloat));
  const still = () => until(() => !window.player._stage?.busy);
  const seekTo = async (frame) => {
    await ask((frame) => {
      window.player.pause();
      window.player.currentFrame = frame;
    }, frame);
    await until((frame) => !window.player.seeking && window.player.currentFrame === frame, frame);
  };
  /** The violations that axe-core finds, as text. */
  const accessibility = async () => {
    if (!(await ask(() => "axe" in window))) await page().addScriptTag({ url: "axe.js" });
    const found = await ask(async () => (await window.axe.run(document)).violations);
    return found.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target.join(" ")).join(", ")}`);
  };
  return { ask, until, events, screen, boxOf, click, control, press, colourful, orbit, still, seekTo, accessibility };
}
