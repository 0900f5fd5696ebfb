// A browser with the conformance page, poses to look from, and pictures of the page and of fvvrender.

import { copyFileSync, linkSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { PNG } from "pngjs";

import { openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { bundle } from "../../three/bundle.mjs";
import { readExr } from "./exr.mjs";

const ups = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], "-x": [-1, 0, 0], "-y": [0, -1, 0], "-z": [0, 0, -1] };
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function orbit(count, { bounds, upAxis }, [, height]) {
  const up = ups[upAxis] ?? ups.y;
  const centre = bounds.min.map((value, k) => (value + bounds.max[k]) / 2);
  const radius = Math.hypot(...bounds.min.map((value, k) => bounds.max[k] - value)) / 2;
  const across = cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1]);
  const along = cross(across, up);
  return Array.from({ length: count }, (_, i) => {
    // At golden angles, from slightly below the middle to well above it.
    const angle = 2.39996 * i;
    const rise = -0.1 + (0.7 * i) / Math.max(1, count - 1);
    const level = Math.sqrt(1 - rise * rise);
    const distance = 2.4 * radius;
    const eye = centre.map(
      (x, k) => x + distance * (level * (Math.cos(angle) * across[k] + Math.sin(angle) * along[k]) + rise * up[k]),
    );
    return { name: `orbit ${i}`, eye, target: centre, up, focal: 1.05 * height };
  });
}

/** A pose without lens distortion, with the principal point in the middle of the picture. */
function fromCamera({ id, centre, rotation: r, fx, width }, [columns]) {
  const target = centre.map((x, k) => x + r[6 + k]);
  return { name: `camera ${id}`, eye: centre, target, up: [-r[3], -r[4], -r[5]], focal: (fx * columns) / width };
}

/** facts: of the page; at most two fifths of the poses are those of cameras. */
export function posesOf(count, facts, size) {
  const calibrated = facts.cameras.filter((camera) => camera.calibrated);
  const own = Math.min(calibrated.length, Math.floor(0.4 * count));
  const chosen = Array.from({ length: own }, (_, i) => calibrated[Math.floor((i * calibrated.length) / own)]);
  return [...orbit(count - own, facts, size), ...chosen.map((camera) => fromCamera(camera, size))];
}

/** Arguments of viewFromPose. */
function poseOf({ eye, target, up, focal }, [width, height]) {
  return { eye, target, up, fov: (360 / Math.PI) * Math.atan(height / (2 * focal)), width, height };
}

/** Options of fvvrender. */
function optionsOf({ eye, target, up, focal }, [width, height]) {
  return ["--pose", [...eye, ...target, ...up].join(), "--focal", `${focal}`, "--size", `${width}x${height}`];
}

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

function readPng(path) {
  return PNG.sync.read(readFileSync(path));
}

export function writePng(path, { width, height, data }) {
  writeFileSync(path, PNG.sync.write(Object.assign(new PNG({ width, height }), { data: Buffer.from(data) })));
}

/** A hard link if possible, because streams are large. */
function bring(from, to) {
  try {
    linkSync(from, to);
  } catch {
    copyFileSync(from, to);
  }
}

export class Session {
  /** scripts, files: of another page than the player's, page.html; more: for openBrowser. */
  static async open(
    browserName = "chromium",
    { scripts = here("page.js"), files = [here("page.html")], ...more } = {},
  ) {
    const served = await serveFolder();
    try {
      await bundle(scripts, files, join(served.folder, "page"));
      const browser = await openBrowser(browserName, more);
      const page = await browser.newPage(`${served.url}page/page.html`);
      await page.waitForSelector("[data-ready]");
      return new Session(served, browser, page);
    } catch (error) {
      served.close();
      throw error;
    }
  }

  constructor(served, browser, page) {
    Object.assign(this, { served, browser, page, streams: 0, file: null });
    mkdirSync(join(served.folder, "reference"));
  }

  /** Returns the facts that the page reports. options: of the decoder. */
  async show(file, frame, options = {}) {
    const name = `stream${this.streams++}.fvv`;
    bring(file, join(this.served.folder, name));
    this.file = file;
    this.frame = frame;
    return this.page.evaluate((url, number, more) => window.openStream(url, number, more), `/${name}`, frame, options);
  }

  /** {width, height, data} */
  async draw(pose, size, options) {
    const { data, ...rest } = await this.page.evaluate(
      (where, what) => window.draw(where, what),
      poseOf(pose, size),
      options,
    );
    return { ...rest, data: Buffer.from(data, "base64") };
  }

  /** The reference of fvvrender, with samples x samples rays for each pixel: {picture, depth, visibility: Map from camera to array}. */
  reference(pose, size, visibleBy, { visibility = false, pictures = true, samples = 1 } = {}) {
    const at = (name) => join(this.served.folder, "reference", name);
    const more = visibility ? ["--visibility", at("visibility.exr")] : [];
    if (!pictures) more.push("--no-pictures");
    const what = ["--frame", `${this.frame}`, ...optionsOf(pose, size), "--samples", `${samples}`, "--no-environment"];
    const output = ["-o", at("picture.png"), "--depth", at("depth.exr"), ...more, "--force"];
    tool("fvvrender", this.file, ...what, "--visible-by", visibleBy, ...output);
    const channels = visibility ? readExr(at("visibility.exr")).channels : new Map();
    return {
      picture: readPng(at("picture.png")),
      depth: readExr(at("depth.exr")).channels.get("Z"),
      visibility: new Map([...channels].map(([name, values]) => [Number(name.replace("camera.", "")), values])),
    };
  }

  async close() {
    await this.browser.close();
    this.served.close();
  }
}
