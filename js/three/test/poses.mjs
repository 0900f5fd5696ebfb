// Each renderer of three, compared with fvvrender from eight poses. usage: node poses.mjs, prints the figures as JSON.

import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { compareFile } from "../../player/conformance/compare.mjs";
import { Session } from "../../player/conformance/session.mjs";
import { tool } from "../../testing/served.mjs";

export const KINDS = ["webgl", "force-webgl", "webgpu"];
/** WebGLRenderer with the nodes of WebGPURenderer. */
export const NODES = "webgl-nodes";
const POSES = 8;
const SIZE = [480, 270];
const here = (name) => fileURLToPath(new URL(name, import.meta.url));

/**
 * Of each kind of renderer, {kind, lines}, with the lines of compareFile for a stream with visibility weights, and with depth maps
 * in their place; or {kind, skipped}, the reason. pictures: a folder for pictures, references and differences.
 */
export async function comparePoses(kinds = [...KINDS, NODES], pictures = undefined) {
  const folder = mkdtempSync(join(tmpdir(), "fvv-poses-"));
  const session = await Session.open("chromium", {
    scripts: here("page.js"),
    files: [here("page.html")],
    webgpu: true,
  });
  try {
    const file = join(folder, "studio.fvv");
    tool("fvvsynth", "-o", join(folder, "studio"), "--frames", "1", "--size", "320x180");
    const weights = ["--visibility", "weight", "--texture-inset", "30mm", "--no-environment"];
    tool("fvvmux", join(folder, "studio"), "-o", file, "--view-loss", "none", ...weights);
    const found = [];
    const references = new Map();
    const reference = (pose, size, visibleBy, options) => {
      const key = `${pose.name} ${visibleBy}`;
      if (!references.has(key)) references.set(key, session.reference(pose, size, visibleBy, options));
      return references.get(key);
    };
    for (const kind of kinds) {
      const own = {
        show: (path, frame, options) => session.show(path, frame, { ...options, kind }),
        draw: (...parameters) => session.draw(...parameters),
        reference,
      };
      const { backend } = await own.show(file, 0);
      if ((backend === "webgpu") !== (kind === "webgpu")) {
        found.push({ kind, skipped: "this browser offers no WebGPU" });
        continue;
      }
      const lines = await compareFile(own, file, {
        poses: POSES,
        size: SIZE,
        pictures: pictures && join(pictures, kind),
      });
      found.push({ kind, lines });
    }
    return { found, troubles: session.browser.troubles };
  } finally {
    await session.close();
    rmSync(folder, { recursive: true });
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url))
  console.log(JSON.stringify(await comparePoses([...KINDS, NODES], process.argv[2]), null, 1));
