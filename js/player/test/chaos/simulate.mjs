// Half an hour, or another time, of films and of a live stream in <fvv-player> in Chromium, over a network in its bad hours:
// node simulate.mjs [--minutes M] [--seed N] prints the figures as JSON, and exits with 1 if there was a hang, a wrong or lost
// frame, an error, or a recovery that took too long.

import { copyFileSync, mkdirSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

import { messagesOf } from "../../../decoder/test/server.mjs";
import { openBrowser } from "../../../testing/browser.mjs";
import { serveFolder, tool } from "../../../testing/served.mjs";
import { bundle } from "../../../three/bundle.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

const FRAMES = 8;
/** Frames a second: of a film each picture is read back and hashed. */
const RATE = 2;
const GROUP = 2;
const CAPTURE = `--rig small --cameras 2 --frames ${FRAMES} --fps ${RATE} --size 96x64`.split(" ");
const MUX = `--group ${GROUP} --triangles 2000 --no-environment`.split(" ");
const LADDER = "--ladder 1,0.5,0.25 --crop none".split(" ");

const FILM = { frameCount: FRAMES, frameMs: 1000 / RATE, rungs: 1 };
/** What the host has; replaced: there is a file of other quality that takes its place; shows: it has the frames of another one. */
const FILMS = [
  { ...FILM, path: "range/film", replaced: true, seeks: true },
  { ...FILM, path: "range/ladder", seeks: true, rungs: 3 },
  { ...FILM, path: "whole/film", shows: "range/film" },
  { ...FILM, path: "segments/manifest.json", shows: "range/ladder", seeks: true },
];

/** Makes the files of the host. Returns their paths, and the live stream. */
function makeFiles(folder) {
  const capture = join(folder, "capture");
  tool("fvvsynth", "-o", capture, ...CAPTURE);
  const made = (name, ...options) => {
    const file = join(folder, `${name}.fvv`);
    tool("fvvmux", capture, "-o", file, ...MUX, ...options);
    return file;
  };
  const good = ["--quality", "36dB"];
  const poor = ["--quality", "28dB"];
  const film = made("film", ...good);
  const ladder = made("ladder", ...good, ...LADDER);
  const named = {
    "range/film": film,
    "whole/film": film,
    "range-replaced/film": made("film-replaced", ...poor),
    "range/ladder": ladder,
  };
  const segments = join(folder, "segments");
  tool("fvvmux", ladder, "--segments", segments);
  for (const entry of readdirSync(segments, { recursive: true, withFileTypes: true }))
    if (entry.isFile() && !entry.name.startsWith(".")) {
      const path = join(entry.parentPath ?? entry.path, entry.name);
      named[`segments/${path.slice(segments.length + 1)}`] = path;
    }
  return { named, film };
}

const base64 = (bytes) => Buffer.from(bytes).toString("base64");

/** Returns {film, live}: {figures, faults}. log(line): what the browser complains about. */
export async function simulate({ minutes, seed, log = () => {} }) {
  const served = await serveFolder();
  const folder = mkdtempSync(join(tmpdir(), "fvv-player-chaos-"));
  let browser;
  try {
    await bundle(here("page.js"), [here("page.html")], served.folder);
    const { named, film } = makeFiles(folder);
    for (const [path, file] of Object.entries(named)) {
      const copy = join(served.folder, "files", path);
      mkdirSync(dirname(copy), { recursive: true });
      copyFileSync(file, copy);
    }
    const { head, groups } = messagesOf(film);
    const stream = { head: base64(head), groups: groups.map((chunks) => chunks.map(base64)) };
    browser = await openBrowser("chromium");
    const results = {};
    for (const part of ["film", "live"]) {
      const page = await browser.newPage(`${served.url}page.html`, 400, 300);
      await page.waitForSelector("[data-ready]");
      await page.evaluate((paths) => window.load(paths), Object.keys(named));
      const given = { minutes, seed, films: FILMS, film: FILMS[0], stream, groupMs: (1000 * GROUP) / RATE };
      // Calls have a time limit of their own.
      await page.evaluate(
        (part, given) => {
          window.result = null;
          const run = part === "film" ? window.films : window.live;
          run(given).then(
            (result) => (window.result = result),
            (error) => (window.result = { error: error.stack }),
          );
        },
        part,
        given,
      );
      let result = null;
      while (!(result = await page.evaluate(() => window.result)))
        await new Promise((resolve) => setTimeout(resolve, 500));
      if (result.error) throw new Error(result.error);
      results[part] = result;
      await page.close();
    }
    browser.troubles.forEach(log);
    return results;
  } finally {
    await browser?.close();
    served.close();
    rmSync(folder, { recursive: true, force: true });
  }
}

if (process.argv[1] === import.meta.filename) {
  const { values } = parseArgs({ options: { minutes: { type: "string" }, seed: { type: "string" } } });
  const { minutes = 30, seed = 1 } = values;
  const results = await simulate({ minutes: Number(minutes), seed: Number(seed), log: console.error });
  console.log(JSON.stringify(results, null, 2));
  process.exitCode = Object.values(results).some(({ faults }) => faults.length) ? 1 : 0;
}
