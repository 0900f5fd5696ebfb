// Rungs of a ladder: which bytes are read, that mesh and pictures of a frame belong together, and which rung is chosen.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, test } from "node:test";

import { shapedProxy } from "../../../bench/network/shaped_proxy.mjs";
import { missingBrowser } from "../../testing/browser.mjs";
import { onReports } from "../../testing/reports.mjs";
import { serveFolder } from "../../testing/served.mjs";
import { Chooser, LiveChooser, Throughput, rungsOf } from "../dist/ladder.js";
import { createDecoder } from "../dist/index.js";
import { RungChoice } from "../dist/rung_choice.js";
import { awaitPost, browsers, visit } from "./browsers.mjs";
import { frameHashes, makeClips, nativeFrames, tool } from "./native.mjs";
import { serve, WebSocket } from "./server.mjs";

const { clips, done } = makeClips("ladder");
const server = await serve(clips);
const folder = join(clips.ladder, "..", "segments");
tool(
  "fvvmux",
  join(clips.ladder, "..", "slow"),
  "-o",
  `${clips.ladder}.again`,
  "--ladder",
  "1,0.5,0.25",
  "--group",
  "1",
  "--segments",
  folder,
);
const host = createServer((request, response) => {
  try {
    response.end(readFileSync(join(folder, request.url)));
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((listening) => host.listen(0, "127.0.0.1", listening));
const manifest = `http://127.0.0.1:${host.address().port}/manifest.json`;
after(() => {
  host.closeAllConnections();
  host.close();
  server.close();
  done();
});
const url = `${server.url}/range/ladder`;

/** What libfvv decodes of each rung alone. */
const expected = [0, 1, 2].map((rung) => {
  const parts = join(clips.ladder, "..", "parts");
  if (!rung) tool("fvvmux", clips.ladder, "--segments", parts);
  const { configuration, groups } = JSON.parse(readFileSync(join(parts, "manifest.json"))).rungs[rung];
  const path = `${clips.ladder}.${rung}`;
  writeFileSync(path, Buffer.concat([configuration, ...groups].map(({ file }) => readFileSync(join(parts, file)))));
  return nativeFrames(path);
});
const count = expected[0].length;

/** Of each chunk: {type, track, middle: of its payload}. */
function* chunksOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  for (let at = 24; at + 32 <= bytes.length;) {
    const size = view.getUint32(at + 16, true);
    const type = String.fromCharCode(...bytes.subarray(at, at + 4));
    yield { type, track: view.getUint16(at + 6, true), middle: at + 32 + (size >> 1) };
    at += 32 + 8 * Math.ceil(size / 8);
  }
}

test("read in order, a damaged chunk costs the rung that has it, and no other", async () => {
  const whole = new Uint8Array(readFileSync(clips.ladder));
  const read = async (source, rung) => {
    const decoder = await createDecoder({ source, rung });
    const [frames, reports] = [[], []];
    onReports(decoder, ["damage", "gap"], (type) => reports.push(type));
    for await (const frame of decoder) frames.push(frameHashes(frame));
    const tracks = decoder.rungs.map((each) => each.tracks);
    decoder.close();
    return { frames, reports, tracks };
  };
  const { tracks } = await read(new Blob([whole]).stream(), 0);
  const tried = { spared: 0, lost: 0 };
  for (const [i, { type, track, middle }] of [...chunksOf(whole)].entries()) {
    if (i % 3 || !["MESH", "VPKT", "VISI"].includes(type)) continue;
    const bytes = whole.slice();
    bytes[middle] ^= 1;
    // Of a stream that is read once, and of bytes whose index leads to the group.
    for (const source of [new Blob([bytes]).stream(), bytes]) {
      const { frames, reports } = await read(source, 0);
      const good = new Map(expected[0].map((frame) => [frame["time 0"], frame]));
      for (const frame of frames) assert.deepEqual(frame, good.get(frame["time 0"]));
      const isUsed = tracks[0].includes(track);
      tried[isUsed ? "lost" : "spared"]++;
      if (isUsed) assert.ok(frames.length < count && reports.includes("gap"), `${type} of track ${track}`);
      else assert.deepEqual([frames.length, reports.includes("gap")], [count, false], `${type} of track ${track}`);
    }
  }
  assert.ok(tried.spared > 8 && tried.lost > 4, JSON.stringify(tried));
});

/** Frames, with what was reported of rungs and gaps. */
async function play(options, onFrame = () => {}) {
  const decoder = await createDecoder({ limits: { cacheBytes: 0 }, ...options });
  const [frames, changes, gaps] = [[], [], []];
  decoder.addEventListener("rung", ({ detail }) => changes.push(detail));
  onReports(decoder, ["gap"], (_, detail) => gaps.push(detail));
  for await (const frame of decoder) {
    frames.push(frame);
    await onFrame(frame, decoder);
  }
  const stats = await decoder.stats();
  decoder.close();
  return { frames, changes, gaps, stats, rungs: decoder.rungs };
}

/** Mesh, colours, visibility, tiles and sample are those that libfvv decodes of the frame's rung, and no other ones. */
function checkFrames(frames, rungs) {
  frames.forEach((frame, i) => {
    const { tracks } = rungs[frame.rung];
    for (const list of [frame.samples, frame.meshes, frame.visibility]) {
      assert.equal(list.length, 1);
      assert.ok(tracks.includes(list[0].track));
    }
    const [{ track, vertexCount, colours }] = frame.meshes;
    const [seen] = frame.visibility;
    assert.equal(seen.meshTrack, track);
    assert.equal(seen.vertexCount, vertexCount);
    assert.equal(colours.length, 4 * vertexCount);
    const found = frameHashes(frame);
    for (const [what, hash] of Object.entries(expected[frame.rung][i]))
      assert.equal(found[what], hash, `frame ${i}, rung ${frame.rung}: ${what}`);
  });
}

test("from memory the best rung is played, or the one that the option names", async () => {
  const source = readFileSync(clips.ladder);
  const best = await play({ source });
  checkFrames(best.frames, best.rungs);
  assert.deepEqual(
    best.frames.map(({ samples }) => samples.length),
    expected[0].map(() => 1),
  );
  assert.deepEqual(
    best.changes.map(({ rung, reason }) => [rung, reason]),
    [[0, "chosen"]],
  );
  assert.deepEqual(
    best.rungs.map(({ scale }) => Math.round(100 * scale)),
    [100, 50, 25],
  );
  for (const wanted of [1, 2, 9]) {
    const { frames, rungs } = await play({ source, rung: wanted });
    assert.equal(frames.length, count);
    assert.ok(frames.every(({ rung }) => rung === Math.min(wanted, 2)));
    checkFrames(frames, rungs);
  }
});

test("former names of options and values remain for one version, with a warning", async (t) => {
  const warn = t.mock.method(console, "warn", () => {});
  const source = readFileSync(clips.ladder);
  const decoder = await createDecoder({ source, quality: 1, video: "samples", audio: "packets" });
  assert.equal(decoder.rung, 1);
  assert.equal((await decoder.next()).rung, 1);
  decoder.close();
  const texts = warn.mock.calls.map(({ arguments: [text] }) => text);
  assert.deepEqual(texts, [
    "@fvv/decoder: the option quality is now rung",
    "@fvv/decoder: the option audio is now sound",
    '@fvv/decoder: the option video: "samples" is now "encoded"',
    '@fvv/decoder: the option sound: "packets" is now "encoded"',
  ]);
});

test("over Range only the chunks of a rung are read", async () => {
  const bytes = [];
  for (const wanted of [0, 1, 2]) {
    const { frames, stats, rungs, changes } = await play({ source: url, rung: wanted });
    assert.equal(frames.length, count);
    assert.ok(frames.every(({ rung }) => rung === wanted));
    assert.equal(changes.length, 1);
    checkFrames(frames, rungs);
    bytes.push(stats.bytesRead);
  }
  // Small gaps are read along.
  assert.ok(bytes[0] >= bytes[1] && bytes[1] > bytes[2], String(bytes));
});

test("the first picture of a ladder takes no more round trips than that of one quality", async () => {
  const roundTripMs = 300;
  const one = join(clips.ladder, "..", "one.fvv");
  tool("fvvmux", join(clips.ladder, "..", "slow"), "-o", one, "--max-error", "0.03", "--group", "1", "--crop", "none");
  clips.one = one;
  const trips = async (clip) => {
    const proxy = await shapedProxy(Number(new URL(server.url).port), { bitsPerSecond: 1e9, roundTripMs });
    const began = performance.now();
    const decoder = await createDecoder({ source: `http://127.0.0.1:${proxy.port}/range/${clip}` });
    const frame = await decoder.next();
    const ms = performance.now() - began;
    assert.equal(frame.samples.length, 1);
    decoder.close();
    proxy.close();
    return ms / roundTripMs;
  };
  await trips("one"); // code is compiled
  const [single, ladder] = [await trips("one"), await trips("ladder")];
  assert.ok(ladder < single + 0.6, `${ladder.toFixed(2)} and ${single.toFixed(2)} round trips`);
});

test("auto begins with the lowest rung and goes up; a change takes a whole group and costs no frame", async () => {
  const { frames, changes, rungs, gaps } = await play({ source: url });
  assert.equal(frames.length, count);
  assert.deepEqual(gaps, []);
  checkFrames(frames, rungs);
  assert.deepEqual([changes[0].rung, changes[0].reason], [2, "start"]);
  assert.equal(frames.at(-1).rung, 0);
  assert.ok(changes.at(-1).throughput > 0);
});

for (const [name, browser] of Object.entries(browsers)) {
  const skip = missingBrowser(name);
  test(`${name}: over a fast link the best rung comes, over a slow one it does not`, { skip }, async () => {
    const { rungs } = await play({ source: url, rung: 2 });
    for (const [bitsPerSecond, isFast] of [
      [16e6, true],
      [0.6 * rungs[0].bitRate, false],
    ]) {
      const { result, post } = awaitPost(60);
      const host = await serve(clips, post);
      const proxy = await shapedProxy(Number(new URL(host.url).port), { bitsPerSecond, roundTripMs: 40 });
      const leave = visit(browser, `http://127.0.0.1:${proxy.port}/test/ladder_page.html`);
      try {
        const { frames, rungs: tracks, error } = await result;
        assert.equal(error, undefined);
        assert.equal(frames.length, count);
        for (const frame of frames) {
          assert.equal(frame.tracks.length, 2); // a mesh and a picture of one rung
          assert.ok(frame.tracks.every((track) => tracks[frame.rung].includes(track)));
        }
        const taken = frames.map(({ rung }) => rung);
        assert.equal(taken[0], 2);
        assert.equal(taken.includes(0), isFast, `rungs ${taken} at ${bitsPerSecond} bit/s`);
      } finally {
        await leave();
        proxy.close();
        host.close();
      }
    }
  });
}

test("another rung is played from the next group on", async () => {
  const { frames, rungs, gaps } = await play({ source: url, rung: 0 }, async (frame, decoder) => {
    if (frame.number === 1) await decoder.setRung(2);
  });
  assert.deepEqual(gaps, []);
  checkFrames(frames, rungs);
  assert.equal(frames[0].rung, 0);
  assert.equal(frames.at(-1).rung, 2);
  await assert.rejects(createDecoder({ source: url, rung: "best" }), { code: "argument" });
});

test("no rung is chosen that is finer than what is shown", async () => {
  const { frames } = await play({ source: url }, (_, decoder) => decoder.setShownScale(0.3));
  assert.ok(frames.slice(2).every(({ rung }) => rung >= 1));
});

test("a frame that stays on screen comes again in the rung that the network carries", async () => {
  for (const source of [url, manifest]) {
    const decoder = await createDecoder({ source, limits: { cacheBytes: 0 } });
    const first = await decoder.next();
    assert.equal(first.rung, 2);
    const again = async (rung) => {
      await decoder.seek({ frame: 0, ...(rung !== undefined && { rung }) });
      const frame = await decoder.next();
      if (source === url) checkFrames([frame], decoder.rungs); // the segments are of another clip
      assert.equal(frame.number, 0);
      return frame.rung;
    };
    // Before anything is known of the network too, and of that group alone.
    for (const rung of [0, 1]) assert.equal(await again(rung), rung);
    assert.equal(decoder.rung, "auto");
    // What is read ahead tells what the network carries.
    const deadline = performance.now() + 20000;
    while ((await decoder.lastingRung()) !== 0) {
      assert.ok(performance.now() < deadline, `rung ${await decoder.lastingRung()} after 20 s`);
      await new Promise((done) => setTimeout(done, 20));
    }
    assert.equal(await decoder.lastingRung({ plays: true }), 0);
    assert.equal(await again(await decoder.lastingRung()), 0);
    await assert.rejects(decoder.seek({ frame: 0, rung: "best" }), { code: "argument" });
    await decoder.setShownScale(0.3);
    assert.equal(await decoder.lastingRung(), 1);
    await decoder.setRung(2);
    assert.equal(await decoder.lastingRung(), 2);
    assert.equal(await again(), 2);
    decoder.close();
  }
  const local = await createDecoder({ source: readFileSync(clips.ladder) });
  await local.next();
  assert.equal(await local.lastingRung(), 0);
  local.close();
});

test("segments: each rung has files of its own", async () => {
  for (const wanted of ["auto", 0, 2]) {
    const { frames, rungs, gaps, changes } = await play({ source: manifest, rung: wanted });
    assert.equal(rungs.length, 3);
    assert.equal(frames.length, count);
    assert.deepEqual(gaps, []);
    if (wanted !== "auto") assert.ok(frames.every(({ rung }) => rung === wanted));
    else assert.deepEqual([changes[0].rung, changes.at(-1).rung], [2, 0]);
    for (const frame of frames) {
      assert.equal(frame.samples.length, 1);
      assert.ok(rungs[frame.rung].tracks.includes(frame.samples[0].track));
    }
  }
});

test("segments: a damaged file of a rung costs its group and is reported", async () => {
  const path = join(folder, "rung-1", "group-000002.fvv");
  const good = readFileSync(path);
  const bad = Uint8Array.from(good);
  bad[bad.length - 9] ^= 1;
  writeFileSync(path, bad);
  const { frames, gaps } = await play({ source: manifest, rung: 1 });
  writeFileSync(path, good);
  assert.equal(frames.length, count - 1);
  assert.equal(gaps.length, 1);
  assert.equal((await play({ source: manifest, rung: 0 })).frames.length, count);
});

test("over a link that breaks down every frame comes, in lower rungs", async () => {
  const proxy = await shapedProxy(Number(new URL(server.url).port), { bitsPerSecond: 2e6, roundTripMs: 20 });
  const source = `http://127.0.0.1:${proxy.port}/range/ladder`;
  const { frames, rungs, gaps } = await play({ source }, (frame) => frame.number === 0 && proxy.setRate(3e4));
  proxy.close();
  assert.equal(frames.length, count);
  assert.deepEqual(gaps, []);
  checkFrames(frames, rungs);
  assert.equal(frames.at(-1).rung, 2);
});

test("a rung without a track of its own takes that of the next better one", () => {
  const track = (id, alternateGroup, rank) => ({ id, alternateGroup, rank, kind: "mesh", bitRate: 10 ** id, size: 0 });
  const tracksOf = (...tracks) => rungsOf({ tracks, videos: [] }).map(({ tracks }) => tracks);
  const [common, best, coarse] = [track(1, 0, 0), track(2, 9, 0), track(3, 9, 2)];
  const videos = [track(4, 8, 0), track(5, 8, 1), track(6, 8, 2)];
  assert.deepEqual(tracksOf(common, coarse, ...videos, best), [
    [1, 4, 2],
    [1, 5, 2],
    [1, 3, 6],
  ]);
  assert.deepEqual(tracksOf(common, best, videos[1]), [[1, 2, 5]]); // a rung alone, whatever its ranks
  assert.deepEqual(tracksOf(common), [[1]]);
  assert.deepEqual(tracksOf(track(1, 9, 7), track(2, 9, 65535), track(3, 8, 0), track(4, 8, 1)), [
    [1, 3],
    [1, 4],
    [2, 4],
  ]);
});

// The rules by themselves.

const bits = [8e6, 2e6, 5e5];
const at = (megabits, buffer, chooser = new Chooser()) => {
  chooser.measured((1e6 * megabits * 4) / 8, 4);
  return chooser.choose({ bits, seconds: 1, buffer });
};

test("throughput decides while little is buffered", () => {
  const chooser = new Chooser();
  assert.deepEqual(chooser.choose({ bits, seconds: 1, buffer: 0 }), { rung: 2, reason: "start" });
  assert.deepEqual(at(16, 1), { rung: 0, reason: "throughput" });
  assert.deepEqual(at(8, 1), { rung: 1, reason: "throughput" });
  assert.deepEqual(at(2.4, 1), { rung: 1, reason: "throughput" });
  assert.deepEqual(at(0.1, 1), { rung: 2, reason: "throughput" });
});

test("what round trips hold up says little, the beginning counts from the second choice on", () => {
  const chooser = new Chooser();
  chooser.began(80000, 0.04); // 16 Mbit/s
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 0 }).reason, "start");
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 1 }).rung, 0);
  for (let i = 0; i < 20; i++) chooser.measured(15000, 0.4, 0.2); // 0.3 Mbit/s in small parts
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 1 }).rung, 0);
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 7 }).rung, 0); // where BOLA alone takes rung 1
  chooser.measured(30000, 4, 0.2); // much longer than for round trips: the network is slow now
  chooser.measured(30000, 4, 0.2);
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 1 }).rung, 2);
});

test("a better rung is tried while round trips hold up the measured one, if the buffer lasts", () => {
  const chooser = new Chooser();
  chooser.measured(125000, 0.4, 0.2); // 2.5 Mbit/s at least
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 1 }).rung, 1);
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 5 }).rung, 1); // 8 Mbit would take 3.2 s
  assert.equal(chooser.choose({ bits: [4e6, 2e6, 5e5], seconds: 1, buffer: 5 }).rung, 0); // and 4 Mbit 1.6 s
  chooser.measured(1250000, 4, 0.2); // 2.5 Mbit/s, and no more
  assert.equal(chooser.choose({ bits: [4e6, 2e6, 5e5], seconds: 1, buffer: 5 }).rung, 1);
});

test("the more is buffered, the better is BOLA's choice, whatever the throughput", () => {
  const chosen = [6, 7, 8, 9, 10, 11, 12].map((buffer) => at(0.1, buffer).rung);
  assert.deepEqual(
    chosen,
    [...chosen].sort((a, b) => b - a),
  );
  assert.equal(chosen.at(-1), 0);
  const chooser = new Chooser();
  assert.equal(at(0.1, 6, chooser).reason, "buffer");
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 4 }).reason, "buffer");
  assert.equal(chooser.choose({ bits, seconds: 1, buffer: 2 }).reason, "throughput");
  assert.equal(chooser.choose({ bits: [1e6, 1e6], seconds: 1, buffer: 9 }).rung, 0);
});

test("nothing better than the best rung that may be taken is chosen", () => {
  const chooser = new Chooser();
  chooser.measured(1e7, 1);
  for (const buffer of [1, 12]) assert.equal(chooser.choose({ bits, seconds: 1, buffer, best: 1 }).rung, 1);
});

test("a group is abandoned if it would be late and the lowest rung is smaller than what is missing", () => {
  const chooser = new Chooser();
  assert.equal(chooser.abandons({ missing: 8e6, lowest: 5e5, buffer: 1 }), false); // nothing is known
  const late = (missing, buffer) => chooser.abandons({ missing, lowest: 5e5, buffer, throughput: 1e6 });
  assert.equal(late(8e6, 4), true);
  assert.equal(late(8e6, 9), false);
  assert.equal(late(4e5, 0), false);
});

test("the estimate follows a fall at once and a rise slowly", () => {
  const throughput = new Throughput();
  assert.equal(throughput.value, null);
  throughput.add(100, 1); // latency, not throughput
  assert.equal(throughput.value, null);
  for (let i = 0; i < 20; i++) throughput.add(2e6, 1);
  assert.ok(Math.abs(throughput.value - 16e6) < 1);
  for (let i = 0; i < 4; i++) throughput.add(125e3, 1);
  const low = throughput.value;
  assert.ok(low < 5e6);
  for (let i = 0; i < 4; i++) throughput.add(2e6, 1);
  assert.ok(throughput.value > low && throughput.value < 13e6);
});

// The rules of a live stream: 25 frames a second over a link whose rate changes.

/** Plays rates over a link for some seconds; capacity(now) in bits per second. Returns the rung of each second. */
function live({ capacity, seconds, best = () => 0, rates = [8e6, 2e6, 5e5] }) {
  const chooser = new LiveChooser();
  const taken = [];
  let [rung, free] = [2, 0];
  for (let i = 0; i < 25 * seconds; i++) {
    const time = i / 25;
    const bits = rates[rung] / 25;
    free = Math.max(free, time) + bits / capacity(time);
    const now = free + 0.02;
    chooser.arrived(bits / 8, time, now);
    // A change takes effect where a group begins.
    const chosen = chooser.choose({ rates, rung, best: best(time), now });
    if (i % 25 === 0) taken.push((rung = chosen));
  }
  return taken;
}

test("live: a better rung is tried while there is no queue, and left when one grows", () => {
  const fast = live({ capacity: () => 20e6, seconds: 30 });
  assert.equal(fast[0], 2);
  assert.equal(fast.at(-1), 0);
  const slow = live({ capacity: () => 3e6, seconds: 120 });
  assert.ok(slow.filter((rung) => rung === 1).length > 80, slow.join(""));
  // Each failure doubles the time to the next trial.
  assert.ok(slow.filter((rung, i) => rung === 0 && slow[i - 1] === 1).length <= 5, slow.join(""));
});

test("live: a link that breaks down gets the rung that it carries, and a better one when it is back", () => {
  const taken = live({ capacity: (now) => (now < 20 || now > 40 ? 20e6 : 8e5), seconds: 80 });
  assert.equal(taken[19], 0);
  assert.equal(taken[39], 2);
  assert.ok(taken.indexOf(2, 20) < 26, taken.join(""));
  assert.equal(taken.at(-1), 0);
});

test("live: nothing finer than what is shown", () => {
  const taken = live({ capacity: () => 20e6, seconds: 40, best: (now) => (now < 20 ? 0 : 1) });
  assert.equal(taken[19], 0);
  assert.ok(taken.slice(22).every((rung) => rung === 1));
});

test("live: fvvserve sends the rung that is wanted, and the decoder chooses by the delay", async () => {
  const { url: site, close } = await serveFolder({ clip: clips.ladder });
  const source = { url: `${site.replace("http", "ws")}live/clip`, WebSocket };
  try {
    for (const wanted of ["auto", 1]) {
      const decoder = await createDecoder({ source, rung: wanted });
      const changes = [];
      decoder.addEventListener("rung", ({ detail }) => changes.push(detail));
      const frames = [];
      for await (const frame of decoder) {
        frames.push(frame);
        if (wanted === 1 && frames.length === 1) await decoder.setRung(0);
        if (frames.length === (wanted === 1 ? 4 : 2)) break;
      }
      decoder.close();
      assert.equal(decoder.rungs.length, 3);
      for (const { rung, samples, meshes } of frames) {
        assert.deepEqual([samples.length, meshes.length], [1, 1]);
        assert.ok(decoder.rungs[rung].tracks.includes(samples[0].track));
      }
      const [first] = changes;
      assert.deepEqual([first.rung, first.reason], wanted === 1 ? [1, "chosen"] : [2, "start"]);
      if (wanted === 1) assert.equal(frames.at(-1).rung, 0);
    }
  } finally {
    close();
  }
});

test("the best rung that is shown has the smallest size that suffices, and of that size the best quality", () => {
  const bestShown = (scales, shown) => {
    const choice = new RungChoice("auto", () => scales.map((scale) => ({ scale })));
    choice.shownScale = shown;
    return choice.asked(() => 0).best();
  };
  assert.equal(bestShown([1, 0.5, 0.25], null), 0);
  assert.equal(bestShown([1, 0.5, 0.25], 1.5), 0);
  assert.equal(bestShown([1, 0.5, 0.25], 0.6), 0);
  assert.equal(bestShown([1, 0.5, 0.25], 0.5), 1);
  assert.equal(bestShown([1, 0.5, 0.25], 0.1), 2);
  assert.equal(bestShown([1, 1, 1], 0.1), 0);
  assert.equal(bestShown([1, 1, 0.5, 0.5], 0.4), 2);
  assert.equal(bestShown([null, null], 0.4), 0); // an atlas has no tiles
});
