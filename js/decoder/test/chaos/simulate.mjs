// Half an hour, or another time, of films and of a live stream over a network in its bad hours:
// node simulate.mjs [--minutes M] [--seed N] prints the figures as JSON, and exits with 1 if there was a hang, a wrong or lost
// frame, an error, or a recovery that took too long.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { parseArgs } from "node:util";

import { createDecoder } from "../../dist/index.js";
import { frameHashes, makeClips, nativeFrames, tool } from "../native.mjs";
import { messagesOf } from "../server.mjs";
import { Clock, randomOf } from "../../../testing/chaos/clock.mjs";
import { faultsOf, Figures } from "../../../testing/chaos/figures.mjs";
import { anyFault, Host, misfortune } from "../../../testing/chaos/host.mjs";
import { anyLiveFault, LiveServer } from "../../../testing/chaos/live_server.mjs";
import { watchFilm, watchLive } from "./viewer.mjs";

/** Milliseconds of a film before another one begins. */
const SESSION = [10000, 60000];

/** The frames of each rung, as the undamaged file has them. */
async function framesOf(bytes) {
  const rungs = [];
  for (let rung = 0; ; rung++) {
    const decoder = await createDecoder({ source: bytes, rung, video: "encoded" });
    const frames = [];
    for await (const frame of decoder) frames.push(frameHashes(frame));
    const { length } = decoder.rungs;
    decoder.close();
    rungs.push(frames);
    if (rung + 1 >= length) return rungs;
  }
}

async function films(world, { minutes, secondsPerFrame, expected }) {
  const { clock, host, random } = world;
  const ends = clock.now + 60000 * minutes;
  const stop = new AbortController();
  const faults = misfortune(world, anyFault, null, stop.signal);
  const kinds = ["range/delta", "range/ladder", "range/tracks", "whole/delta", "segments/manifest.json"];
  while (clock.now < ends) {
    const kind = random.pick(kinds);
    const rungs = expected[kind.startsWith("segments") ? "ladder" : kind.split("/")[1]];
    await watchFilm(`http://host.test/${kind}`, {
      duration: random.between(...SESSION),
      frameCount: rungs[0].length,
      expected: ({ number }) => rungs.map((frames) => frames[number]),
      secondsPerFrame,
      world,
    });
  }
  stop.abort();
  await faults;
  host.finish();
}

async function live(world, { minutes, file }) {
  const { clock, host, random, figures } = world;
  const frames = nativeFrames(file);
  const { head, groups } = messagesOf(file);
  const server = new LiveServer(clock, host, { head, groups, groupMs: 1000 });
  const stop = new AbortController();
  const faults = misfortune(world, anyLiveFault, server, stop.signal);
  const ends = clock.now + 60000 * minutes;
  while (clock.now < ends)
    await watchLive(
      { url: "ws://host.test/live/x", WebSocket: server.WebSocket, reconnect: true },
      { duration: random.between(30000, 180000), expected: () => frames, world },
    );
  stop.abort();
  await faults;
  host.finish();
  server.end();
  figures.requests = host.requests;
}

/** What replaces films: other meshes and pictures of the same captures. */
const REPLACEMENTS = {
  delta: ["tracked", "--group", "3", "--quality", "30dB", "--triangles", "2000", "--no-environment"],
  ladder: ["slow", "--group", "1", "--quality", "30dB", "--ladder", "1,0.5,0.25", "--crop", "none", "--no-environment"],
};

/** {clips, others, folder, done}: the films, what replaces some of them, and one as segments. */
export function makeFilms() {
  const { clips, done } = makeClips("ladder", "delta", "tracks");
  const home = join(clips.ladder, "..");
  const folder = join(home, "chaos-segments");
  tool("fvvmux", clips.ladder, "--segments", folder);
  const others = {};
  for (const [name, [capture, ...options]] of Object.entries(REPLACEMENTS)) {
    others[name] = join(home, `${name}-replaced.fvv`);
    tool("fvvmux", join(home, capture), "-o", others[name], ...options);
  }
  return { clips, others, folder, done };
}

const bytesOf = (paths) => Object.fromEntries(Object.entries(paths).map(([name, path]) => [name, readFileSync(path)]));

/** Returns {film, live}: Figures. */
export async function simulate({ minutes, seed, made: { clips, others, folder } }) {
  const files = bytesOf(clips);
  const replacements = bytesOf(others);
  const expected = {};
  for (const [name, bytes] of Object.entries(files)) {
    expected[name] = await framesOf(bytes);
    if (replacements[name]) expected[name].push(...(await framesOf(replacements[name])));
  }
  // Segments of another stream have names of their own.
  const read = (path, version) => {
    const [first, ...rest] = path.split("/");
    if (first === "segments") return readFileSync(join(folder, ...rest));
    return (version % 2 && replacements[rest[0]]) || files[rest[0]];
  };
  nativeFrames(clips.delta);
  const results = {};
  for (const part of ["film", "live"]) {
    const clock = new Clock();
    const random = randomOf(seed);
    const host = new Host(clock, random, read);
    const figures = (results[part] = new Figures());
    const world = { clock, host, random, figures };
    try {
      if (part === "film") await films(world, { minutes, secondsPerFrame: 0.5, expected });
      else await live(world, { minutes, file: clips.delta });
    } finally {
      clock.end();
      host.end();
    }
  }
  return results;
}

if (process.argv[1] === import.meta.filename) {
  const { values } = parseArgs({ options: { minutes: { type: "string" }, seed: { type: "string" } } });
  const made = makeFilms();
  const results = await simulate({ minutes: Number(values.minutes ?? 30), seed: Number(values.seed ?? 1), made });
  made.done();
  console.log(JSON.stringify(results, null, 2));
  process.exitCode = Object.values(results).some((figures) => faultsOf(figures).length) ? 1 : 0;
}
