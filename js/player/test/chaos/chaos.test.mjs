// <fvv-player> over a network that fails at random, by a seed, in simulated time: nothing hangs, no picture is wrong, no position is
// lost, and playback goes on within three seconds of the event "online" or the time of Retry-After. FVV_CHAOS_MINUTES: how long, in
// minutes of the simulation; FVV_CHAOS_SEED.

import assert from "node:assert/strict";
import { test } from "node:test";

import { missingBrowser } from "../../../testing/browser.mjs";
import { simulate } from "./simulate.mjs";

const minutes = Number(process.env.FVV_CHAOS_MINUTES ?? 0.25);
const seed = Number(process.env.FVV_CHAOS_SEED ?? 1);

test(
  `${minutes} minutes of films and of a live stream in the player, seed ${seed}`,
  { skip: missingBrowser("chromium") },
  async () => {
    const results = await simulate({ minutes, seed });
    for (const [part, { figures, faults }] of Object.entries(results)) {
      assert.deepEqual(faults, [], `${part}: ${JSON.stringify(figures)}`);
      assert.ok(figures.frames > 30 * minutes, `${part}: ${figures.frames} frames`);
      assert.ok(Object.keys(figures.faults).length > 0, part);
    }
  },
);
