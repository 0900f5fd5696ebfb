// HEVC in browsers without it, bit-identical to the native libavcodec, under a strict content policy; and all codecs in a
// worker without WebCodecs.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { join } from "node:path";
import { after, test } from "node:test";

import { awaitPost, browsers, visit } from "../../decoder/test/browsers.mjs";
import { nativePictures } from "../../decoder/test/native.mjs";
import { serve } from "../../decoder/test/server.mjs";
import { root } from "../../testing/served.mjs";
import { makeVideoClips } from "./clips.mjs";

const names = ["hevc", "hevc10", "h264", "vp9"];
const { clips, done } = makeVideoClips(...names);
after(done);
const here = join(root, "js/video-fallback");

async function runPage(browser) {
  const { result, post } = awaitPost(60);
  const folders = { fallback: join(here, "dist"), page: join(here, "test") };
  const server = await serve(clips, post, folders);
  const leave = visit(browser, `${server.url}/page/page.html?clips=${names.join()}`);
  try {
    return await result;
  } finally {
    await leave();
    server.close();
  }
}

for (const [name, browser] of Object.entries(browsers)) {
  const missing = spawnSync(browser.program, ["--version"]).error;
  test(`${name}: pictures of the fallback`, { skip: missing && `no ${browser.program} installed` }, async (context) => {
    const { results, violations, native, error } = await runPage(browser);
    assert.equal(error, undefined);
    assert.deepEqual(violations, []);
    assert.equal(results.length, 3 * names.length);
    let checked = 0;
    for (const { name: clip, how, inWorker, pictures, warnings } of results) {
      const what = `${clip} in the ${how}`;
      assert.deepEqual(warnings, [], what);
      assert.equal(inWorker, how !== "window", what);
      assert.deepEqual(
        pictures.map(({ late }) => late),
        [0, 0, 0, 0, 0],
        what,
      );
      const own = clip.startsWith("hevc") ? native.hvc1 : true;
      if (own && how !== "bare worker") continue;
      assert.deepEqual(
        pictures.map(({ track, hash }) => ({ track, hash })),
        nativePictures(clips[clip]),
        what,
      );
      for (const { format, isFrame } of pictures) {
        assert.equal(format, clip === "hevc10" ? "I420P10" : "I420", what);
        if (format === "I420") assert.equal(isFrame, how !== "bare worker", what);
      }
      checked++;
    }
    context.diagnostic(
      `${checked} of ${results.length} by the fallback${native.hvc1 ? "; this browser has HEVC" : ""}`,
    );
    assert.ok(checked >= names.length);
  });
}
