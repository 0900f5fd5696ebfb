// Hosts that were quick and go silent, in simulated time: they are asked again soon, once they are silent and not merely slow, and what
// comes first counts.

import assert from "node:assert/strict";
import { after, test } from "node:test";

import { Clock } from "../../testing/chaos/clock.mjs";
import { Network } from "../dist/sources/network.js";

const clock = new Clock();
const { fetch } = globalThis;
after(() => {
  clock.end();
  globalThis.fetch = fetch;
});

/** plan(n): of the nth request, [milliseconds until its headers, and until each piece after that]; Infinity: never. */
function hostOf(plan) {
  const asked = [];
  const aborted = [];
  globalThis.fetch = async (url, { signal }) => {
    const n = asked.push(clock.now) - 1;
    const stop = new Promise((_, reject) =>
      signal.addEventListener("abort", () => {
        aborted.push(n);
        reject(signal.reason);
      }),
    );
    stop.catch(() => {});
    const wait = (milliseconds) => Promise.race([milliseconds === Infinity ? stop : clock.wait(milliseconds), stop]);
    const [headers, ...pieces] = plan(n);
    await wait(headers);
    const stream = new ReadableStream(
      {
        async pull(controller) {
          if (!pieces.length) return controller.close();
          await wait(pieces.shift());
          controller.enqueue(Uint8Array.of(n));
        },
      },
      { highWaterMark: 0 },
    );
    return new Response(stream, { status: 206 });
  };
  return { asked, aborted };
}

const QUICK = [20, 1, 1];
/** A Network that has had a few good responses. */
async function network(plan, policy = {}) {
  const host = hostOf((n) => (n < 3 ? QUICK : plan(n - 3)));
  const found = new Network({}, { policy });
  for (let i = 0; i < 3; i++) await (await found.request("http://x/")).bytes();
  const before = clock.now;
  const fetchAll = async () => [...(await (await found.request("http://x/")).bytes())].map((n) => n - 3);
  const times = () => host.asked.slice(3).map((at) => at - before);
  return {
    network: found,
    fetchAll,
    times,
    aborted: () => host.aborted.map((n) => n - 3),
    passed: () => clock.now - before,
  };
}

test("a request without a response is asked again beside, and the others are dropped", async () => {
  const { fetchAll, times, aborted, passed, network: own } = await network((n) => (n < 2 ? [Infinity] : QUICK));
  assert.deepEqual(await fetchAll(), [2, 2]);
  assert.deepEqual(times(), [0, 1500, 4000]);
  assert.deepEqual(aborted(), [0, 1]);
  assert.ok(passed() < 4100, `${passed()} ms`);
  assert.equal(own.requests, 6);
});

test("so is one whose headers come without a byte", async () => {
  const { fetchAll, times, aborted } = await network((n) => (n === 0 ? [20, Infinity] : QUICK));
  assert.deepEqual(await fetchAll(), [1, 1]);
  assert.deepEqual(times(), [0, 1500]);
  assert.deepEqual(aborted(), [0]);
});

test("the first request still counts: a host that has become slow is waited for", async () => {
  const { fetchAll, aborted, times } = await network(() => [5000, 1, 1]);
  assert.deepEqual(await fetchAll(), [0, 0]);
  assert.deepEqual(times(), [0, 1500, 4000]);
  assert.deepEqual(aborted(), [1, 2]);
  // It is known to be slow now.
  assert.deepEqual(await fetchAll(), [3, 3]);
  assert.equal(times().length, 4);
});

test("a body that stalls ends, so that its rest can be requested", async () => {
  const { network: own, times, passed } = await network((n) => (n === 0 ? [20, 1, Infinity] : QUICK));
  const reply = await own.request("http://x/");
  await assert.rejects(reply.bytes(), /no byte has come for 1.5 s/);
  assert.ok(passed() < 1600, `${passed()} ms`);
  assert.deepEqual(times(), [0]);
});

test("while other bytes come the host is not silent", async () => {
  const slow = [20, ...Array(40).fill(300)];
  const { network: own, times } = await network((n) => (n === 0 ? slow : [9000, 1]));
  const first = own.request("http://x/").then((reply) => reply.bytes());
  await (await own.request("http://x/")).bytes();
  assert.equal((await first).length, 40);
  assert.equal(times().length, 2);
});

test("of a host of which nothing is known only the time-outs hold", async () => {
  const host = hostOf((n) => (n === 0 ? [Infinity] : QUICK));
  const own = new Network({}, {});
  const before = clock.now;
  await (await own.request("http://x/")).bytes();
  assert.deepEqual(
    host.asked.map((at) => at - before),
    [0, 10000],
  );
});

test("a request that is aborted, and a network that is closed, end all attempts", async () => {
  for (const close of [false, true]) {
    const { network: own, times, aborted } = await network(() => [Infinity]);
    const abort = new AbortController();
    const asked = own.request("http://x/", { signal: abort.signal });
    asked.catch(() => {});
    await clock.wait(5000);
    assert.equal(times().length, 3);
    if (close) own.close();
    else abort.abort(new Error("not wanted"));
    await assert.rejects(asked, close ? /the source was closed/ : /not wanted/);
    assert.deepEqual(aborted(), [0, 1, 2]);
    await clock.wait(20000);
    assert.equal(times().length, 3);
  }
});

test("an address that expires twice while a request has no response is renewed again", async () => {
  let key = 0;
  let silent = false;
  globalThis.fetch = async (url, { signal }) => {
    await clock.wait(20);
    const isSilent = silent;
    silent = false;
    if (isSilent) await new Promise((_, reject) => signal.addEventListener("abort", () => reject(signal.reason)));
    const isValid = new URL(url).search === `?${key}`;
    return new Response(isValid ? "good" : "expired", { status: isValid ? 206 : 403 });
  };
  const own = new Network({}, { renew: async () => `http://x/?${key}` });
  const text = async () => new TextDecoder().decode(await (await own.request("http://x/?0")).bytes());
  assert.equal(await text(), "good");
  silent = true;
  const first = text();
  await clock.wait(100);
  key = 1;
  assert.equal(await text(), "good");
  key = 2;
  assert.equal(await first, "good");
});

/** A WebSocket that opens after some milliseconds. */
function socketsOf(plan) {
  const made = [];
  class Fake extends EventTarget {
    closed = false;
    constructor() {
      super();
      const n = made.push(this) - 1;
      this.n = n;
      if (plan[n] < Infinity) clock.wait(plan[n]).then(() => this.closed || this.dispatchEvent(new Event("open")));
    }
    close() {
      this.closed = true;
    }
  }
  return { made, Fake };
}

test("live: a connection that does not open is tried again beside, and one of them stays", async () => {
  const { made, Fake } = socketsOf([20, Infinity, 2500, 1000]);
  const own = new Network({}, {});
  const prepared = [];
  const connect = () => own.connect(Fake, "ws://x/", [], (socket) => prepared.push(socket.n));
  assert.equal((await connect()).n, 0);
  const before = clock.now;
  // The second and the third open at the same time.
  assert.equal((await connect()).n, 2);
  assert.equal(clock.now - before, 4000);
  await clock.wait(5000);
  assert.deepEqual(
    made.map(({ closed }) => closed),
    [false, true, false, true].slice(0, made.length),
  );
  assert.deepEqual(prepared.slice(0, 3), [0, 1, 2]);
  own.close();
  assert.ok(made.every(({ closed }) => closed));
});

test("when the first attempt has had its time, all are given up, and the next one is made at once", async () => {
  const { fetchAll, times } = await network((n) => (n < 5 ? [Infinity] : QUICK));
  assert.deepEqual(await fetchAll(), [5, 5]);
  assert.deepEqual(times(), [0, 1500, 4000, 6500, 9000, 10000]);
});
