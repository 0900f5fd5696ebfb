// Films and a live stream over a network that fails at random, by a seed, in simulated time: nothing hangs, no frame is wrong, no
// position is lost, and playback goes on within three seconds of the event "online" or the time of Retry-After, and mostly of any fault. FVV_CHAOS_MINUTES:
// how long, in minutes of the simulation; FVV_CHAOS_SEED.

import assert from "node:assert/strict";
import { test } from "node:test";

import { faultsOf, Figures, HANG_MS, PROMPT_MS } from "../../../testing/chaos/figures.mjs";
import { makeFilms, simulate } from "./simulate.mjs";

const minutes = Number(process.env.FVV_CHAOS_MINUTES ?? 1.5);
const seed = Number(process.env.FVV_CHAOS_SEED ?? 1);
/** Recoveries of which a percentile is one. */
const ENOUGH = 50;

test(`${minutes} minutes of films and of a live stream, seed ${seed}`, async () => {
  const made = makeFilms();
  const results = await simulate({ minutes, seed, made });
  made.done();
  for (const [part, figures] of Object.entries(results)) {
    assert.deepEqual(faultsOf(figures), [], part);
    if (figures.recoveries.length >= ENOUGH)
      assert.ok(figures.returnP95 <= PROMPT_MS / 1000, `${part}: playing again after ${figures.returnP95} s`);
    assert.ok(figures.frames > 60 * minutes, `${part}: ${figures.frames} frames`);
    const kinds = Object.keys(figures.faults).length;
    assert.ok(kinds >= 3 && figures.recoveries.length > 0, `${part}: ${JSON.stringify(figures)}`);
  }
});

test("what is wrong is said", () => {
  const figures = new Figures();
  figures.wrong = 1;
  figures.recovered({ kind: "offline" }, PROMPT_MS + 1);
  figures.recovered({ kind: "stall" }, HANG_MS - 1);
  assert.deepEqual(faultsOf(figures), ["1 wrong frames", `offline: playing again after ${PROMPT_MS + 1} ms`]);
});
