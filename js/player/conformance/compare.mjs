// Compares what the player's renderer draws with what fvvrender draws.
// usage: node compare.mjs FILE.fvv ... [--frame N] [--poses N] [--size WxH] [--rays] [--browser NAME] [--pictures DIR] [--json]

import { mkdirSync } from "node:fs";
import { basename, join } from "node:path";
import { parseArgs } from "node:util";

import { posesOf, Session, writePng } from "./session.mjs";

/** The steepest surface that is not an edge: the change of depth from pixel to pixel, in pixel widths. */
const STEEPEST = 8;
/** Pixels from an outline: in the pixel of an outline and its neighbours, two rasterisers differ by chance. */
const AWAY = 2;
const LARGE = 8;

/**
 * The pixels that show the mesh, and those of them that are at least two pixels from its outline and from jumps of its
 * depth. depth: of the reference, infinite outside the mesh.
 */
function areasOf(depth, width, height, focal) {
  const surface = new Uint8Array(depth.length);
  const edge = new Uint8Array(depth.length);
  for (let i = 0; i < depth.length; i++) surface[i] = Number.isFinite(depth[i]) ? 1 : 0;
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const i = y * width + x;
      if (!surface[i]) continue;
      const jumps = (k) => !surface[k] || Math.abs(depth[k] - depth[i]) > (STEEPEST * depth[i]) / focal;
      if (
        (x > 0 && jumps(i - 1)) ||
        (x < width - 1 && jumps(i + 1)) ||
        (y > 0 && jumps(i - width)) ||
        (y < height - 1 && jumps(i + width))
      )
        edge[i] = 1;
    }
  const inner = surface.slice();
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      if (!edge[y * width + x]) continue;
      for (let v = Math.max(0, y - AWAY + 1); v < Math.min(height, y + AWAY); v++)
        for (let u = Math.max(0, x - AWAY + 1); u < Math.min(width, x + AWAY); u++) inner[v * width + u] = 0;
    }
  return { surface, inner };
}

/** PSNR of display values in dB, the fraction of pixels with a component that differs by more than 8 of 255, and their
 * number. */
export function distance(drawn, wanted, area) {
  let [sum, pixels, large] = [0, 0, 0];
  for (let i = 0; i < area.length; i++) {
    if (!area[i]) continue;
    pixels++;
    let max = 0;
    for (let k = 0; k < 3; k++) {
      const off = drawn[4 * i + k] - wanted[4 * i + k];
      sum += off * off;
      max = Math.max(max, Math.abs(off));
    }
    if (max > LARGE) large++;
  }
  const psnr = pixels ? 10 * Math.log10((255 * 255 * 3 * pixels) / Math.max(sum, 1e-9)) : null;
  return { psnr, large: pixels ? large / pixels : null, pixels };
}

/** The number of pixels with equal visibility. drawn: in the mode "visibility", where unseen surface has no green. */
function agreement(drawn, wanted, area) {
  let [alike, pixels] = [0, 0];
  for (let i = 0; i < area.length; i++) {
    if (!area[i]) continue;
    pixels++;
    alike += drawn[4 * i + 1] > 0 === wanted[i] > 0.5;
  }
  return { alike, pixels };
}

const usage = `usage: node compare.mjs FILE.fvv ... [options]
--frame N       of each file (0)
--poses N       around the mesh, and up to two fifths of them at camera positions (20)
--size WxH      of the pictures (960x540)
--bare          without the streams' pictures, as a player that cannot decode them
--rays          also the agreement of visibility with ray casting
--browser NAME  chromium or firefox
--pictures DIR  write drawn pictures, references and differences
--json          figures as JSON`;

const drawn = { shadows: false, environment: false };
const worst = (values) => Math.min(...values);
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

/** For one pose and one source of visibility. */
async function comparePose(session, pose, size, visibleBy, bare) {
  const reference = session.reference(pose, size, visibleBy, { pictures: !bare });
  const picture = await session.draw(pose, size, { ...drawn, visibleBy });
  const areas = areasOf(reference.depth, ...size, pose.focal);
  const inner = distance(picture.data, reference.picture.data, areas.inner);
  const all = distance(picture.data, reference.picture.data, areas.surface);
  return { pose: pose.name, inner, all, picture, reference: reference.picture };
}

/** Compares the visibility of each camera with ray casting. */
async function compareVisibility(session, facts, pose, size, visibleBy) {
  const { depth, visibility } = session.reference(pose, size, "rays", { visibility: true });
  const { inner } = areasOf(depth, ...size, pose.focal);
  let [alike, pixels] = [0, 0];
  for (const [camera, wanted] of visibility) {
    const options = { ...drawn, visibleBy, mode: "visibility", cameras: [camera] };
    const found = agreement((await session.draw(pose, size, options)).data, wanted, inner);
    alike += found.alike;
    pixels += found.pixels;
  }
  return { alike, pixels };
}

function keepPictures(folder, name, { picture, reference }) {
  mkdirSync(folder, { recursive: true });
  const data = picture.data.map((value, i) =>
    i % 4 === 3 ? 255 : Math.min(255, 8 * Math.abs(value - reference.data[i])),
  );
  writePng(join(folder, `${name}-player.png`), picture);
  writePng(join(folder, `${name}-fvvrender.png`), reference);
  writePng(join(folder, `${name}-difference8.png`), { ...picture, data });
}

/** The figures of a file: one line for each source of visibility. */
export async function compareFile(
  session,
  file,
  { frame = 0, poses: count = 20, size = [960, 540], rays = false, bare = false, pictures } = {},
) {
  const facts = await session.show(file, frame, bare ? { video: "encoded" } : {});
  const poses = posesOf(count, facts, size);
  const lines = [];
  for (const visibleBy of facts.withBits.length && !bare ? ["bits", "depth"] : ["depth"]) {
    const results = [];
    let [alike, pixels] = [0, 0];
    for (const pose of poses) {
      const result = await comparePose(session, pose, size, visibleBy, bare);
      if (pictures)
        keepPictures(pictures, `${basename(file, ".fvv")}-${visibleBy}-${pose.name.replace(" ", "")}`, result);
      if (result.inner.pixels) results.push(result);
      if (!rays) continue;
      const found = await compareVisibility(session, facts, pose, size, visibleBy);
      alike += found.alike;
      pixels += found.pixels;
    }
    if (!results.length) throw new Error(`${file}: no pose shows the mesh of frame ${frame}`);
    lines.push({
      file: basename(file),
      frame,
      visibleBy,
      views: facts.views,
      poses: results.length,
      minPsnr: worst(results.map(({ inner }) => inner.psnr)),
      meanPsnr: mean(results.map(({ inner }) => inner.psnr)),
      minForegroundPsnr: worst(results.map(({ all }) => all.psnr)),
      largePercent: 100 * mean(results.map(({ inner }) => inner.large)),
      foregroundLargePercent: 100 * mean(results.map(({ all }) => all.large)),
      agreementPercent: pixels ? (100 * alike) / pixels : null,
      each: results.map(({ pose, inner, all }) => ({ pose, inner, all })),
    });
  }
  return lines;
}

function table(lines) {
  const columns = [
    ["file", (line) => line.file],
    ["by", (line) => line.visibleBy],
    ["poses", (line) => line.poses],
    ["dB min", (line) => line.minPsnr.toFixed(1)],
    ["mean", (line) => line.meanPsnr.toFixed(1)],
    ["> 8", (line) => `${line.largePercent.toFixed(2)} %`],
    ["all dB", (line) => line.minForegroundPsnr.toFixed(1)],
    ["all > 8", (line) => `${line.foregroundLargePercent.toFixed(2)} %`],
    ["as rays", (line) => (line.agreementPercent === null ? "-" : `${line.agreementPercent.toFixed(2)} %`)],
  ];
  const rows = [columns.map(([title]) => title), ...lines.map((line) => columns.map(([, of]) => String(of(line))))];
  const widths = columns.map((_, k) => Math.max(...rows.map((row) => row[k].length)));
  return rows
    .map((row) =>
      row
        .map((cell, k) => cell.padEnd(widths[k]))
        .join("  ")
        .trimEnd(),
    )
    .join("\n");
}

async function main() {
  const { values, positionals } = parseArgs({
    allowPositionals: true,
    options: {
      frame: { type: "string", default: "0" },
      poses: { type: "string", default: "20" },
      size: { type: "string", default: "960x540" },
      rays: { type: "boolean", default: false },
      bare: { type: "boolean", default: false },
      browser: { type: "string", default: "chromium" },
      pictures: { type: "string" },
      json: { type: "boolean", default: false },
      help: { type: "boolean", short: "h", default: false },
    },
  });
  if (values.help) return console.log(usage);
  const size = values.size.split("x").map(Number);
  if (!positionals.length || size.length !== 2 || !size.every((side) => side > 0)) {
    console.error(usage);
    process.exit(2);
  }
  const session = await Session.open(values.browser);
  try {
    const lines = [];
    for (const file of positionals)
      lines.push(
        ...(await compareFile(session, file, {
          frame: Number(values.frame),
          poses: Number(values.poses),
          size,
          rays: values.rays,
          bare: values.bare,
          pictures: values.pictures,
        })),
      );
    console.log(values.json ? JSON.stringify(lines, null, 1) : table(lines));
    for (const trouble of session.browser.troubles) console.error(`the page: ${trouble}`);
    process.exitCode = session.browser.troubles.length ? 1 : 0;
  } finally {
    await session.close();
  }
}

if (process.argv[1] === here()) await main();

function here() {
  return new URL(import.meta.url).pathname;
}
