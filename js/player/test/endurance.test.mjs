// Long playback with seeks and changes of rate: mesh and pictures are of the same frame, pictures are closed, and memory does
// not grow. Frame numbers are read from drawn pictures. bench.py plays 10,000 frames in this way, this test fewer.

import assert from "node:assert/strict";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { Session, endure } from "./endurance/session.mjs";

const FRAMES = 400;
const SEEKS = 20;
const [FEW_FRAMES, FEW_SEEKS] = [100, 8];
const MOST_OPEN = 4;
const MOST_GROWTH_MIB = 5e6 / 2 ** 20;

function assertSteady({ browser }, found, frames, seeks) {
  assert.deepEqual(browser.troubles, []);
  assert.deepEqual(found.wrong, []);
  assert.equal(found.wrongCount, 0);
  assert.ok(found.frames >= frames, `${found.frames} frames were drawn`);
  assert.ok(found.arrivals >= seeks, `${found.arrivals} seeks finished`);
  assert.equal(found.rates, seeks, "changes of rate");
  // At least 2, else the counter does not work.
  assert.ok(found.mostOpen >= 2 && found.mostOpen <= MOST_OPEN, `${found.mostOpen} pictures were open at a time`);
  assert.equal(found.wasmGrowthMiB, 0);
}

describe("endurance", { skip: missingBrowser("chromium") }, () => {
  let session;
  before(async () => (session = await Session.open()));
  after(() => session?.close());

  test(`${FRAMES} frames with ${SEEKS} seeks and changes of rate`, async () => {
    session.makeStream("board", { frames: 120, group: 12 });
    await session.play("board");
    const found = await endure(session, { frames: FRAMES, actions: SEEKS });
    assertSteady(session, found, FRAMES, SEEKS);
    assert.equal(found.threads, 2, "the page and its worker");
    assert.ok(found.heapGrowthMiB < MOST_GROWTH_MIB, `the heap grew by ${found.heapGrowthMiB.toFixed(2)} MiB`);
  });

  test("pictures that are late by a frame are detected", async () => {
    session.makeStream("late", { frames: 24, group: 12, pictureNumber: (n) => Math.max(0, n - 1) });
    await session.play("late");
    const found = await session.endure({ frames: 40, actions: 0, seed: 1 });
    // All except those of frame 0.
    assert.ok(found.wrongCount > 0.9 * found.checked, `${found.wrongCount} of ${found.checked}`);
    assert.match(found.wrong[0], /frame (\d+): mesh \1, pictures (?!\1$)\d+/);
  });
});

describe("endurance in Firefox, which does not report its memory", { skip: missingBrowser("firefox") }, () => {
  test(`${FEW_FRAMES} frames with ${FEW_SEEKS} seeks and changes of rate`, async () => {
    const session = await Session.open("firefox");
    try {
      session.makeStream("board", { frames: 60, group: 12 });
      await session.play("board");
      const found = await endure(session, { frames: FEW_FRAMES, actions: FEW_SEEKS });
      assertSteady(session, found, FEW_FRAMES, FEW_SEEKS);
    } finally {
      await session.close();
    }
  });
});
