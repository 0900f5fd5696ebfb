// Every promise of a decoder settles: over a simulated network whose replies come in any order, while the caller seeks, changes
// the rung, aborts and closes at any moment. FVV_ORDERS: how many orders are tried.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, test } from "node:test";

import { createDecoder } from "../dist/index.js";
import { GroupPrefetcher } from "../dist/sources/group_prefetcher.js";
import { makeClips, tool } from "./native.mjs";

const ORDERS = Number(process.env.FVV_ORDERS ?? 30);
/** Far longer than anything here takes that settles at all. */
const BOUND_MS = 8000;
const LONGEST_PIECE = 20000;
const FRAMES = 5; // of each clip

const { clips, done } = makeClips("ladder", "delta", "tracks");
const folder = join(clips.ladder, "..", "settle");
tool("fvvmux", clips.ladder, "--segments", folder);
const realFetch = globalThis.fetch;
after(() => {
  globalThis.fetch = realFetch;
  done();
});

/** Numbers from 0 to 1 that a seed decides. */
function randomOf(seed) {
  let state = seed * 2654435761 + 1;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** A network on which one of all that is waited for happens at a time, in an order that a seed decides. */
class Network {
  #random;
  #waiting = [];
  #running = true;
  stalled = false;

  constructor(random) {
    this.#random = random;
    globalThis.fetch = (url, init) => this.#fetch(String(url), init);
    this.#run();
  }
  async #run() {
    while (this.#running) {
      await new Promise((resolve) => setImmediate(resolve));
      if (this.stalled || !this.#waiting.length) continue;
      const [go] = this.#waiting.splice(Math.floor(this.#random() * this.#waiting.length), 1);
      go();
    }
  }
  end() {
    this.#running = false;
  }
  #turn(signal) {
    return new Promise((resolve, reject) => {
      const stop = () => reject(signal.reason);
      signal.addEventListener("abort", stop);
      this.#waiting.push(() => {
        signal.removeEventListener("abort", stop);
        resolve();
      });
      if (signal.aborted) stop();
    });
  }
  async #fetch(url, { headers, signal }) {
    await this.#turn(signal);
    const [, first, ...rest] = new URL(url).pathname.split("/");
    const bytes = readFileSync(first === "segments" ? join(folder, ...rest) : clips[rest[0]]);
    const [from, end] = first === "range" ? rangeOf(headers.Range, bytes.length) : [0, bytes.length];
    const random = this.#random;
    let at = from;
    const body = new ReadableStream(
      {
        pull: async (controller) => {
          await this.#turn(signal);
          const piece = bytes.subarray(at, Math.min(end, at + 1 + Math.floor(random() * LONGEST_PIECE)));
          at += piece.length;
          if (piece.length) controller.enqueue(new Uint8Array(piece));
          else controller.close();
        },
      },
      { highWaterMark: 0 },
    );
    if (first !== "range") return new Response(body, { status: 200 });
    const range = { "Content-Range": `bytes ${from}-${end - 1}/${bytes.length}` };
    return new Response(body, { status: 206, headers: range });
  }
}

function rangeOf(text, size) {
  const [, from, last] = /^bytes=(\d*)-(\d*)$/.exec(text);
  if (from === "") return [Math.max(0, size - Number(last)), size];
  return [Number(from), Math.min(size, Number(last) + 1)];
}

/** Throws if the promise has not settled in time. */
async function settled(promise, what) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`${what} never settles`)), BOUND_MS);
  });
  try {
    return await Promise.race([Promise.allSettled([promise]), late]).then(([result]) => result);
  } finally {
    clearTimeout(timer);
  }
}

/** A session of a few calls, with or without waiting for the former ones. */
async function session(options, seed) {
  const random = randomOf(seed);
  const pick = (n) => Math.floor(random() * n);
  const network = new Network(random);
  const abort = new AbortController();
  const log = [];
  let timer;
  try {
    const opening = createDecoder({ ...options, signal: abort.signal, queue: 1 + pick(4), video: "encoded" });
    if (pick(8) === 0) {
      timer = setTimeout(() => abort.abort(), pick(4));
      network.stalled = pick(2) === 0;
    }
    const { value: decoder, reason } = await settled(opening, `seed ${seed}: opening`);
    clearTimeout(timer); // it has opened sooner
    network.stalled = false;
    if (!decoder) {
      assert.ok(abort.signal.aborted, `seed ${seed}: ${reason?.stack}`);
      return "aborted";
    }
    let open = [];
    const wait = async () => {
      for (const { name, promise } of open.splice(0)) {
        const { reason: why } = await settled(promise, `seed ${seed}: ${log.join(" ")}: ${name}`);
        if (why && !abort.signal.aborted) assert.fail(`seed ${seed}: ${log.join(" ")}: ${name}: ${why.stack}`);
      }
    };
    const call = (name, promise) => {
      log.push(name);
      open.push({ name, promise });
    };
    const calls = 2 + pick(7);
    for (let i = 0; i < calls; i++) {
      const what = pick(6);
      if (what <= 2) call("next", decoder.next());
      else if (what === 3) {
        await wait();
        const frame = pick(FRAMES);
        call(`seek ${frame}`, decoder.seek({ frame }));
        if (pick(2)) continue;
        const found = decoder.next();
        call("next", found);
        await wait();
        assert.equal((await found)?.number, frame, `seed ${seed}: ${log.join(" ")}`);
      } else if (what === 4) call("seek 0", decoder.seek({ frame: 0 }));
      else call("rung", decoder.setRung(pick(2) ? "auto" : pick(3)));
      // A while, in which anything may have arrived.
      for (let n = pick(3) ? pick(60) : 0; n > 0; n--) await new Promise((resolve) => setImmediate(resolve));
      if (pick(3) === 0) await wait();
    }
    // Nothing comes any more, and everything settles all the same.
    network.stalled = true;
    call("next", decoder.next());
    call("buffered", decoder.buffered());
    if (pick(2)) abort.abort();
    else decoder.close();
    const late = open.splice(0);
    for (const { name, promise } of late) await settled(promise, `seed ${seed}: ${log.join(" ")}: closed: ${name}`);
    assert.equal((await settled(decoder.next(), "next after close")).value, null);
    return "closed";
  } finally {
    network.end();
  }
}

const at = (path) => `http://host.test/${path}`;
for (const [name, options] of [
  ["a ladder over Range", { source: at("range/ladder") }],
  ["a file over Range", { source: at("range/delta") }],
  ["some tracks over Range", { source: at("range/tracks"), look: { eye: [2, 1.5, 3], target: [0, 1, 0] } }],
  ["a single response", { source: at("whole/delta") }],
  ["segments with a ladder", { source: at("segments/manifest.json") }],
])
  test(`${name}: whatever comes when, every promise settles`, async () => {
    const ends = { aborted: 0, closed: 0 };
    for (let seed = 1; seed <= ORDERS; seed++) ends[await session(options, seed)]++;
    assert.ok(ends.closed > ORDERS / 2 && ends.aborted > 0, JSON.stringify(ends));
  });

test("a group that is planned while another run begins is not that run's", async () => {
  const planned = [];
  const plans = () => new Promise((resolve) => planned.push(() => resolve([{ rung: 0, size: 1 }])));
  const fetcher = { bytesRead: 0, plans, fetch: async function* () {} };
  const ladder = { chooser: { target: 1, measured() {} }, wish: () => 0, seconds: Number };
  const prefetcher = new GroupPrefetcher(fetcher, [{ start: 0n, end: 1n }], ladder, () => null);
  prefetcher.start(0);
  prefetcher.start(0);
  const [former, latter] = planned;
  latter();
  former();
  await new Promise((resolve) => setImmediate(resolve));
  const pending = await prefetcher.take(0);
  for await (const _ of prefetcher.arrivals(pending));
  assert.equal(pending.error, null);
});
