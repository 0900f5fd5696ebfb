// The numbered board, its page in a browser, and what that page measures. Only Chromium reports memory.

import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { openBrowser } from "../../../testing/browser.mjs";
import { serveFolder, tool } from "../../../testing/served.mjs";
import { bundle } from "../../../three/bundle.mjs";
import { writeBoard } from "./board.mjs";

const ATTEMPTS = 3;
const here = (name) => fileURLToPath(new URL(name, import.meta.url));

/** The size of a thread's JavaScript heap in bytes after garbage collection. */
async function heapOf(client) {
  for (let i = 0; i < 2; i++) await client.send("HeapProfiler.collectGarbage");
  const { usedSize, backingStorageSize = 0 } = await client.send("Runtime.getHeapUsage");
  return usedSize + backingStorageSize;
}

export class Session {
  static async open(browserName = "chromium") {
    const served = await serveFolder();
    try {
      await bundle(here("page.js"), [here("page.html")], join(served.folder, "page"));
      await bundle(here("counting_worker.js"), [], join(served.folder, "page/worker"));
      return new Session(served, await openBrowser(browserName));
    } catch (error) {
      served.close();
      throw error;
    }
  }
  constructor(served, browser) {
    Object.assign(this, { served, browser, page: null });
  }

  /** Makes a stream of the board; more: options of writeBoard. */
  makeStream(name, { frames, group, ...more }) {
    const folder = join(this.served.folder, name);
    writeBoard(folder, { frames, group, ...more });
    const output = ["-o", join(this.served.folder, `${name}.fvv`), "--force"];
    tool("fvvmux", folder, ...output, "--group", `${group}`, "--keep-geometry", "--quality", "36dB");
  }

  /** On a busy machine the worker may take longer to start than the decoder waits: then in another page. */
  async play(name) {
    for (let attempt = 1; ; attempt++) {
      await this.page?.close();
      this.page = await this.browser.newPage(`${this.served.url}page/page.html`, 640, 480);
      await this.page.waitForSelector("[data-ready]");
      this.client = this.browser.name === "chromium" ? await this.page.createCDPSession() : null;
      const warnings = await this.page.evaluate((source) => window.begin(source), `/${name}.fvv`);
      if (!warnings.length) return;
      if (attempt === ATTEMPTS) throw new Error(warnings.join("\n"));
    }
  }
  endure(options) {
    return this.page.evaluate((wanted) => window.endure(wanted), options);
  }
  /** Bytes of the page and its worker; null: not reported by the browser. */
  async heap() {
    if (!this.client) return null;
    const threads = [this.client, ...this.page.workers().map(({ client }) => client)];
    let bytes = 0;
    for (const client of threads) bytes += await heapOf(client);
    return { bytes, threads: threads.length };
  }

  async close() {
    await this.browser.close();
    this.served.close();
  }
}

/** Frames per call to the page, because calls have a timeout. */
const PART = 500;

/** Plays and measures; the heap is measured after the first frames. */
export async function endure(session, { frames, actions, seed = 1 }) {
  const warm = await session.endure({ frames: Math.min(PART, Math.ceil(frames / 5)), actions: 5, seed });
  const before = await session.heap();
  const parts = Math.ceil(frames / PART);
  const all = [];
  for (let i = 1; i <= parts; i++) {
    const portion = { frames: Math.ceil(frames / parts), actions: Math.ceil(actions / parts) };
    all.push(await session.endure({ ...portion, seed: seed + i }));
  }
  const after = await session.heap();
  const found = all.at(-1);
  const sum = (name) => all.reduce((sofar, part) => sofar + part[name], 0);
  return {
    ...found,
    frames: found.checked - warm.checked,
    seeks: sum("seeks"),
    rates: sum("rates"),
    mostOpen: Math.max(...[warm, ...all].map((part) => part.mostOpen)),
    heapGrowthMiB: after && (after.bytes - before.bytes) / 2 ** 20,
    wasmGrowthMiB: (found.memoryBytes - warm.memoryBytes) / 2 ** 20,
    threads: after && after.threads,
  };
}
