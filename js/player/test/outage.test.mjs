// A host that goes away while a film is played, in Chromium: what is buffered is played, the player waits at its position with
// the reason on screen, and goes on when the host is back. A screenshot is kept in FVV_ARTEFACTS (build/screens).

import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { tool } from "../../testing/served.mjs";
import { drivePage, openPage } from "./page_driver.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));
const NAME = "chromium";

/** A host of one file for pages elsewhere. While away, it ends every connection. */
async function serve(file) {
  const bytes = readFileSync(file);
  const host = { away: false };
  const server = createServer((request, response) => {
    if (host.away) return request.socket.destroy();
    response.setHeader("Access-Control-Allow-Origin", "*");
    response.setHeader("Access-Control-Allow-Headers", "Range");
    response.setHeader("Access-Control-Expose-Headers", "Content-Range");
    if (request.method === "OPTIONS") return response.end();
    const [, from, last] = /^bytes=(\d*)-(\d*)$/.exec(request.headers.range ?? "bytes=0-");
    const first = from === "" ? Math.max(0, bytes.length - Number(last)) : Number(from);
    const end = from === "" || last === "" ? bytes.length : Math.min(bytes.length, Number(last) + 1);
    response.writeHead(206, { "Content-Range": `bytes ${first}-${end - 1}/${bytes.length}` });
    response.end(bytes.subarray(first, end));
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  host.url = `http://127.0.0.1:${server.address().port}/clip.fvv`;
  host.close = () => {
    server.closeAllConnections();
    server.close();
  };
  return host;
}

test("a host that goes away while a film is played", { skip: missingBrowser(NAME) }, async () => {
  mkdirSync(screens, { recursive: true });
  const folder = mkdtempSync(join(tmpdir(), "fvv-outage-"));
  tool("fvvsynth", "-o", join(folder, "capture"), ..."--rig small --cameras 3 --frames 24 --size 160x120".split(" "));
  const clip = join(folder, "clip.fvv");
  tool("fvvmux", join(folder, "capture"), "-o", clip, ..."--group 6 --quality 30 --triangles 4000".split(" "));
  const host = await serve(clip);
  let opened;
  try {
    opened = await openPage(NAME, clip, {});
    const { ask, until, screen } = drivePage(() => opened.page, screens, NAME);
    await until(() => "player" in window);
    await ask((url) => {
      window.player.decoderOptions = { limits: { cacheBytes: 0 } };
      window.player.loop = true;
      window.player.src = url;
      return window.player.play();
    }, host.url);
    await until(() => window.player.stats.framesShown > 5);
    host.away = true;
    const notice = () => {
      const node = window.player.shadowRoot.querySelector(".outage");
      return node.hidden ? "" : node.textContent;
    };
    await until(() => !window.player.shadowRoot.querySelector(".outage").hidden);
    assert.match(await ask(notice), /interrupted/);
    await screen("outage");
    const waiting = await ask(() => {
      const { outage, error, paused, currentTime } = window.player;
      return { reason: outage.reason, error, paused, currentTime };
    });
    assert.match(waiting.reason, /no response/);
    assert.deepEqual([waiting.error, waiting.paused], [null, false]);
    host.away = false;
    const began = performance.now();
    const shown = await ask(() => window.player.stats.framesShown);
    await until((shown) => window.player.stats.framesShown > shown + 3, shown);
    assert.ok(performance.now() - began < 6000, "it comes back late");
    assert.equal(await ask(notice), "");
    assert.equal(await ask(() => window.player.outage), null);
  } finally {
    await opened?.close();
    host.close();
    rmSync(folder, { recursive: true, force: true });
  }
});
