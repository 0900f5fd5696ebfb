// The numbered board, its page in a browser, and what that page tells; memory is asked of the browser.

import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { openBrowser } from "../../../testing/browser.mjs";
import { serveFolder, tool } from "../../../testing/served.mjs";
import { bundle } from "../../../three/bundle.mjs";
import { writeBoard } from "./board.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

/** Bytes that JavaScript holds in a thread, when all has gone that nobody needs. */
async function heapOf(client) {
  for (let i = 0; i < 2; i++) await client.send("HeapProfiler.collectGarbage");
  const { usedSize, backingStorageSize = 0 } = await client.send("Runtime.getHeapUsage");
  return usedSize + backingStorageSize;
}

export class Session {
  static async open() {
    const served = await serveFolder();
    try {
      await bundle(here("page.js"), [here("page.html")], join(served.folder, "page"));
      await bundle(here("counting_worker.js"), [], join(served.folder, "page/worker"));
      return new Session(served, await openBrowser());
    } catch (error) {
      served.close();
      throw error;
    }
  }
  constructor(served, browser) {
    Object.assign(this, { served, browser, page: null });
  }

  /** A stream of the board; more: as writeBoard takes it. */
  makeStream(name, { frames, group, ...more }) {
    const folder = join(this.served.folder, name);
    writeBoard(folder, { frames, group, ...more });
    const output = ["-o", join(this.served.folder, `${name}.fvv`), "--force"];
    tool("fvvmux", folder, ...output, "--group", `${group}`, "--keep-geometry", "--quality", "36dB");
  }

  async play(name) {
    await this.page?.close();
    this.page = await this.browser.newPage(`${this.served.url}page/page.html`, 640, 480);
    await this.page.waitForSelector("[data-ready]");
    this.client = await this.page.createCDPSession();
    return this.page.evaluate((source) => window.begin(source), `/${name}.fvv`);
  }
  endure(options) {
    return this.page.evaluate((wanted) => window.endure(wanted), options);
  }
  /** Bytes, of the page and of its worker. */
  async heap() {
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

/** A run in parts; the heap may settle in the first. */
export async function endure(session, { frames, actions, seed = 1 }) {
  const warm = await session.endure({ frames: Math.min(500, Math.ceil(frames / 5)), actions: 5, seed: seed + 1 });
  const before = await session.heap();
  const found = await session.endure({ frames, actions, seed });
  const after = await session.heap();
  return {
    ...found,
    frames: found.checked - warm.checked,
    mostOpen: Math.max(warm.mostOpen, found.mostOpen),
    heapGrowthMiB: (after.bytes - before.bytes) / 2 ** 20,
    wasmGrowthMiB: (found.memoryBytes - warm.memoryBytes) / 2 ** 20,
    threads: after.threads,
  };
}
