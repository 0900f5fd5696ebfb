// Half an hour, or another time, of films and of a live stream over a network in its bad hours:
// node simulate.mjs [--minutes M] [--seed N] prints the figures as JSON, and exits with 1 if there was a hang, a wrong or lost
// frame, an error, or a recovery that took too long.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { parseArgs } from "node:util";

import { createDecoder } from "../../dist/index.js";
import { frameHashes, makeClips, nativeFrames, tool } from "../native.mjs";
import { messagesOf } from "../server.mjs";
import { Clock, randomOf } from "./clock.mjs";
import { anyFault, Host } from "./host.mjs";
import { anyLiveFault, LiveServer } from "./live_server.mjs";
import { Figures, watchFilm, watchLive } from "./viewer.mjs";

/** Milliseconds of a film before another one begins. */
const SESSION = [10000, 60000];
/** Milliseconds without a fault. */
const PEACE = [1000, 12000];

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

/** Faults one after the other, with peace between them, until the signal is aborted. */
async function misfortune({ clock, host, random, figures }, choose, victim, signal) {
  while (!signal.aborted) {
    await clock.wait(random.between(...PEACE));
    const fault = choose(random, clock.now);
    figures.note(fault);
    host.begin(fault);
    victim?.begin(fault);
    await clock.wait(fault.until - clock.now);
    host.finish();
    host.last = fault;
    host.ended = clock.now;
    victim?.finish(fault);
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

/** {clips, folder, done}: the films, one of them as segments. */
export function makeFilms() {
  const { clips, done } = makeClips("ladder", "delta", "tracks");
  const folder = join(clips.ladder, "..", "chaos-segments");
  tool("fvvmux", clips.ladder, "--segments", folder);
  return { clips, folder, done };
}

/** Returns {film, live}: Figures. */
export async function simulate({ minutes, seed, made: { clips, folder } }) {
  const files = Object.fromEntries(Object.entries(clips).map(([name, path]) => [name, readFileSync(path)]));
  const expected = {};
  for (const [name, bytes] of Object.entries(files)) expected[name] = await framesOf(bytes);
  nativeFrames(clips.delta);
  const results = {};
  for (const part of ["film", "live"]) {
    const clock = new Clock();
    const random = randomOf(seed);
    const host = new Host(clock, random, { files, folder });
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

/** What is wrong, as text; empty: nothing is. */
export const faultsOf = ({ hangs, wrong, lost, errors, late }) =>
  [
    hangs && `${hangs} hangs`,
    wrong && `${wrong} wrong frames`,
    lost && `${lost} positions lost`,
    ...errors,
    ...late.map(({ kind, milliseconds }) => `${kind}: playing again after ${Math.round(milliseconds)} ms`),
  ].filter(Boolean);

if (process.argv[1] === import.meta.filename) {
  const { values } = parseArgs({ options: { minutes: { type: "string" }, seed: { type: "string" } } });
  const made = makeFilms();
  const results = await simulate({ minutes: Number(values.minutes ?? 30), seed: Number(values.seed ?? 1), made });
  made.done();
  console.log(JSON.stringify(results, null, 2));
  process.exitCode = Object.values(results).some((figures) => faultsOf(figures).length) ? 1 : 0;
}
