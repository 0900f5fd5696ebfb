// Builds the demo site into a folder that fvvserve serves: pages, scripts, clips and their facts.
// usage: node build.mjs FOLDER FVVINFO CLIP.fvv ... (pages embed the first clip)

import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, linkSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import { bundlePlayer } from "../player/bundle.mjs";
import { bundle, bundleExample } from "../three/bundle.mjs";
import { factsOf } from "./clip_facts.mjs";
import { icon } from "./icon.mjs";
import { FIVE_LINES, frame } from "./pages.mjs";

const source = (name) => fileURLToPath(new URL(`src/${name}`, import.meta.url));

/** A hard link if possible, because clips are large. */
function bring(from, to) {
  rmSync(to, { force: true });
  try {
    linkSync(from, to);
  } catch {
    copyFileSync(from, to);
  }
}

function writePages(out) {
  const pages = [
    { page: "", file: "index.html", script: "index.js", title: "fvv: free-viewpoint video" },
    { page: "embed.html", file: "embed.html", script: "embed.js", title: "Embed the player: fvv" },
  ];
  for (const { file, ...about } of pages)
    writeFileSync(join(out, file), frame({ ...about, content: readFileSync(source(file), "utf8") }));
  writeFileSync(join(out, "five-lines.html"), FIVE_LINES);
  copyFileSync(source("site.css"), join(out, "site.css"));
  writeFileSync(join(out, "favicon.ico"), icon());
}

/** The prepared marks of a clip, which the first page offers: their address; null: there are none. */
function bringMarks(clip, out) {
  const name = basename(clip, ".fvv");
  const marks = source(`marks/${name}.json`);
  if (!existsSync(marks)) return null;
  copyFileSync(marks, join(out, "clips", `${name}.marks.json`));
  return `clips/${name}.marks.json`;
}

/** inspect(path): returns the output of fvvinfo --json for a file. */
export async function buildSite(out, inspect, clips) {
  mkdirSync(join(out, "clips"), { recursive: true });
  await bundle(
    ["index.js", "embed.js", "player.js"].map((name) => source(name)),
    [],
    out,
  );
  await bundlePlayer(join(out, "fvv-player.min.js"));
  await bundleExample(join(out, "three"));
  writePages(out);
  for (const clip of clips) bring(clip, join(out, "clips", basename(clip)));
  // The page of three.js expects its clip in its own folder.
  bring(clips[0], join(out, "three/players.fvv"));
  writeFileSync(
    join(out, "clips.json"),
    JSON.stringify(
      clips.map((clip) => ({ ...factsOf(clip, inspect(clip)), marks: bringMarks(clip, out) })),
      null,
      1,
    ),
  );
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [out, fvvinfo, ...clips] = process.argv.slice(2);
  if (!clips.length) {
    console.error("usage: node build.mjs FOLDER FVVINFO CLIP.fvv ...");
    process.exit(2);
  }
  await buildSite(
    resolve(out),
    (path) => JSON.parse(execFileSync(fvvinfo, ["--json", path], { encoding: "utf8" })).files[0],
    clips.map((clip) => resolve(clip)),
  );
}
