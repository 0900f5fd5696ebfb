// A live stream of fvvserve in Chromium and Firefox: it continues while the player is paused and the view moves, and the
// player catches up afterwards.

import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { drivePage, openPage } from "./page_driver.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));
const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

let folder;
before(() => {
  mkdirSync(screens, { recursive: true });
  folder = mkdtempSync(join(tmpdir(), "fvv-live-"));
  const options = "--rig small --cameras 3 --frames 120 --fps 6 --size 160x120".split(" ");
  tool("fvvsynth", "-o", join(folder, "capture"), ...options);
  const sizes = "--group 6 --quality 30 --triangles 4000".split(" ");
  tool("fvvmux", join(folder, "capture"), "-o", join(folder, "players.fvv"), ...sizes);
});
after(() => rmSync(folder, { recursive: true, force: true }));

for (const name of ["chromium", "firefox"])
  describe(name, { skip: missingBrowser(name) }, () => {
    let opened, page;
    before(async () => {
      const clip = join(folder, "players.fvv");
      opened = await openPage(name, clip, { players: clip });
      page = opened.page;
    });
    after(() => opened?.close());
    const { ask, until, screen, control, click, press, colourful, orbit } = drivePage(() => page, screens, name);
    const badge = () => ask((part) => window.player.shadowRoot.querySelector(part).textContent, control("live"));

    test("plays, pauses, and catches up", async () => {
      await until(() => "player" in window);
      // The address of a live stream depends on the port.
      await ask(() => {
        window.player.src = new URL("live/players", location.href.replace("http", "ws")).href;
        return window.player.play();
      });
      await until(() => window.player.live && window.player.stats.contentFrames > 6);
      assert.equal(await badge(), "Live");
      const share = await colourful();
      assert.ok(share > 0.02 && share < 0.6, `${share} of the picture is coloured`);

      await press("k");
      await until(() => window.player.paused && !window.player._stage?.busy);
      const [frame, [azimuth]] = [await ask(() => window.player.currentFrame), await orbit()];
      await press("ArrowLeft");
      await wait(1500);
      assert.notEqual((await orbit())[0], azimuth, "the view does not move");
      assert.equal(await ask(() => window.player.currentFrame), frame, "the frame changes during the pause");
      assert.ok((await ask(() => window.player.liveLatency)) > 1.2);
      await until(
        (part) => /^Live \u2212[1-9] s$/.test(window.player.shadowRoot.querySelector(part).textContent),
        control("live"),
      );
      await screen("live-late");

      await ask(() => {
        window.shownFrames = [];
        window.player.addEventListener("framechange", () => window.shownFrames.push(window.player.currentFrame));
      });
      await press("k");
      await until(() => !window.player.paused && window.player.liveLatency < 0.6 && window.shownFrames.length > 8);
      // From the paused frame on, without gaps: skipping would pass over the nine frames that have arrived meanwhile.
      const steps = (await ask(() => window.shownFrames))
        .slice(0, 8)
        .map((shown, i, all) => shown - (all[i - 1] ?? frame));
      assert.ok(
        steps.every((step) => step > 0 && step < 6),
        `it skips instead of catching up: ${steps}`,
      );
      // The bar is updated a moment later.
      await until((part) => window.player.shadowRoot.querySelector(part).textContent === "Live", control("live"));
    });

    test("goes live immediately on request", async () => {
      await press("k");
      await wait(1500);
      assert.ok((await ask(() => window.player.liveLatency)) > 1.2);
      await click(control("live"));
      await until(() => !window.player.paused && window.player.liveLatency < 0.6);
      const frame = await ask(() => window.player.stats.contentFrames);
      await until((frame) => window.player.stats.contentFrames > frame, frame);
    });
  });
