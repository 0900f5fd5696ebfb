// Small clips in every codec and bit depth that the module decodes, and one that it does not.

import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { tool } from "../../decoder/test/native.mjs";

const kinds = {
  h264: ["--codec", "h264"],
  hevc: ["--codec", "hevc"],
  hevc10: ["--codec", "hevc", "--bit-depth", "10"],
  vp9: ["--codec", "vp9"],
  vp910: ["--codec", "vp9", "--bit-depth", "10"],
  av1: ["--codec", "av1"],
};

export function makeVideoClips(...wanted) {
  const folder = mkdtempSync(join(tmpdir(), "fvv-video-"));
  const capture = join(folder, "capture");
  tool("fvvsynth", "-o", capture, "--rig", "small", "--frames", "5", "--size", "96x64");
  const clips = {};
  for (const name of wanted) {
    clips[name] = join(folder, `${name}.fvv`);
    tool("fvvmux", capture, "-o", clips[name], "--quality", "40dB", "--group", "3", ...kinds[name]);
  }
  return { clips, done: () => rmSync(folder, { recursive: true, force: true }) };
}
