// The same hashes in a browser, in window and worker, under a strict content policy. The page posts its results: no driver
// is needed.

import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { after, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { awaitPost, browsers, visit } from "./browsers.mjs";
import { conformanceFiles, makeClips, nativeFrames, tool } from "./native.mjs";
import { serve } from "./server.mjs";

const { clips: made, done } = makeClips();
after(done);
/** neighbours has several tracks of video. tracks is for the number of requested bytes, which needs no browser. */
const { neighbours, tracks: _, ...clips } = made;
/** Folder and name: some names exist in several folders. */
const named = (file) => `${basename(dirname(file))}-${basename(file, ".fvv")}`;
const files = { ...clips, ...Object.fromEntries(conformanceFiles().map((file) => [named(file), file])) };
/** What the decoder computes is the same in both; Firefox, which takes twice as long, gets every kind of clip from every kind of source. */
const filesOf = (browser) => (browser === "firefox" ? clips : files);

/** These are also played from WebSockets and segments. */
const MORE = ["delta", "moving"];
const segments = {};
for (const name of MORE) {
  const folder = `${clips[name]}-segments`;
  tool("fvvmux", clips[name], "--segments", folder);
  for (const file of readdirSync(folder)) segments[`${name}/${file}`] = join(folder, file);
}

async function runPage(browser, played) {
  const { result, post } = awaitPost(120);
  const server = await serve({ ...played, ...segments, neighbours }, post);
  const leave = visit(
    browser,
    `${server.url}/test/page.html?clips=${Object.keys(played).join()}&more=${MORE.join()}&reselect=neighbours`,
  );
  try {
    return await result;
  } finally {
    await leave();
    server.close();
  }
}

/** What a page is expected to find; samples and times are compared by other tests. */
const expected = (name) =>
  nativeFrames(files[name]).map((frame) =>
    Object.fromEntries(Object.entries(frame).filter(([key]) => !/^(time|key|sample) /.test(key))),
  );

for (const [name, browser] of Object.entries(browsers)) {
  test(`${name}: the same frames in window and worker`, { skip: missingBrowser(name) }, async () => {
    const played = filesOf(name);
    const { results, reselected, violations, error } = await runPage(browser, played);
    assert.equal(error, undefined);
    assert.deepEqual(violations, []);
    assert.equal(results.length, 2 * (5 * Object.keys(played).length + 2 * MORE.length));
    for (const { worker, track, all, different, same } of reselected) {
      assert.equal(all.length, 3);
      assert.equal(different, 5 * all.length, "identical pictures cannot be distinguished");
      assert.deepEqual(same, [all, all, [track], [track], all], worker ? "worker" : "window");
    }
    for (const result of results) {
      const what = `${result.name} from ${result.kind}, ${result.worker ? "worker" : "window"}`;
      assert.equal(result.inWorker, result.worker, what);
      assert.deepEqual(result.frames, expected(result.name), what);
      // Pictures of conformance files are headers without pixels, or OpenEXR, which browsers cannot decode.
      if (!(result.name in clips)) continue;
      assert.deepEqual(
        result.warnings.filter((text) => !/front to back|rebuilt|\(oexr\): no decoder is available/.test(text)),
        [],
        what,
      );
      const pictures = nativeFrames(files[result.name]).reduce(
        (n, frame) => n + Object.keys(frame).filter((key) => /^(key|sample) /.test(key)).length,
        0,
      );
      assert.equal(result.pictures.length, pictures, what);
      for (const { late } of result.pictures) assert.ok(Math.abs(late) < 2, `${what}: a picture of another time`);
    }
  });
}
