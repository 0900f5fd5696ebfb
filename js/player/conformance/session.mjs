// A browser with the page of the conformance mode, and pictures of it and of fvvrender.

import { copyFileSync, linkSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { PNG } from "pngjs";

import { openBrowser } from "../../testing/browser.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";
import { bundle } from "../../three/bundle.mjs";
import { readExr } from "./exr.mjs";
import { optionsOf, poseOf } from "./poses.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

export function readPng(path) {
  return PNG.sync.read(readFileSync(path));
}

export function writePng(path, { width, height, data }) {
  writeFileSync(path, PNG.sync.write(Object.assign(new PNG({ width, height }), { data: Buffer.from(data) })));
}

/** A hard link where that goes: streams are large. */
function bring(from, to) {
  try {
    linkSync(from, to);
  } catch {
    copyFileSync(from, to);
  }
}

export class Session {
  static async open(browserName = "chromium") {
    const served = await serveFolder();
    try {
      await bundle(here("page.js"), [here("page.html")], join(served.folder, "page"));
      const browser = await openBrowser(browserName);
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

  /** Answers the facts of the page. */
  async show(file, frame) {
    const name = `stream${this.streams++}.fvv`;
    bring(file, join(this.served.folder, name));
    this.file = file;
    this.frame = frame;
    return this.page.evaluate((url, number) => window.openStream(url, number), `/${name}`, frame);
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

  /** What fvvrender draws of the same: {picture, depth, visibility: Map from camera to array, or null}. */
  reference(pose, size, visibleBy, { visibility = false } = {}) {
    const at = (name) => join(this.served.folder, "reference", name);
    const more = visibility ? ["--visibility", at("visibility.exr")] : [];
    const what = ["--frame", `${this.frame}`, ...optionsOf(pose, size), "--samples", "1", "--no-environment"];
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
