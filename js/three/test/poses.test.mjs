// WebGLRenderer, and WebGPURenderer with WebGL 2 and with WebGPU, against pictures of fvvrender from eight poses.

import assert from "node:assert/strict";
import { before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { comparePoses, KINDS, NODES } from "./poses.mjs";

/** dB away from outlines. */
const LEAST_PSNR = 40;

describe("three from eight poses", { skip: missingBrowser("chromium") }, () => {
  let compared;
  before(async () => (compared = await comparePoses()));

  for (const kind of [...KINDS, NODES])
    test(kind, (context) => {
      const { skipped, lines } = compared.found.find((one) => one.kind === kind);
      if (skipped) return context.skip(skipped);
      assert.deepEqual(
        lines.map(({ visibleBy }) => visibleBy),
        ["bits", "depth"],
      );
      for (const { visibleBy, poses, minPsnr, each } of lines) {
        assert.equal(poses, 8);
        for (const { pose, inner } of each) assert.ok(inner.pixels > 1000, `${pose}: ${inner.pixels} pixels`);
        assert.ok(minPsnr >= LEAST_PSNR, `${visibleBy}: ${minPsnr.toFixed(1)} dB`);
      }
    });
  test("nothing is reported by the page", () => assert.deepEqual(compared.troubles, []));
});
